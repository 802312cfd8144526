/* FMI 3.0 for co-simulation. */
#include <stdbool.h>
#include <stdint.h>

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef void *fmi3Instance;
typedef uint32_t fmi3ValueReference;
typedef const char *fmi3String;

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

EXPORT fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, bool visible,
                                                bool logging, bool event_mode, bool early_return,
                                                const fmi3ValueReference between[], size_t n_between,
                                                void *environment, void *log, void *update)
{
    (void)name, (void)resources, (void)visible, (void)logging, (void)event_mode, (void)early_return;
    (void)between, (void)n_between, (void)environment, (void)log, (void)update;
    if (strcmp(token, AXIS_GUID) != 0) return NULL;
    Instance *c = malloc(sizeof *c);
    if (c) reset(c);
    return c;
}

EXPORT void fmi3FreeInstance(fmi3Instance c) { free(c); }

EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, bool has_tolerance, double tolerance, double start,
                                              bool has_stop, double stop)
{
    Instance *c = instance;
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    c->time = start;
    return fmi3OK;
}

EXPORT fmi3Status fmi3Reset(fmi3Instance c)
{
    reset(c);
    return fmi3OK;
}

EXPORT fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, double value[], size_t size)
{
    return size == n && get(c, vr, n, value) ? fmi3OK : fmi3Error;
}

EXPORT fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const double value[],
                                 size_t size)
{
    return size == n && set(c, vr, n, value) ? fmi3OK : fmi3Error;
}

EXPORT fmi3Status fmi3DoStep(fmi3Instance c, double time, double step, bool keep, bool *event, bool *terminate,
                             bool *early, double *reached)
{
    (void)keep;
    *event = *terminate = *early = false;
    *reached = time + step;
    return advance(c, time, step) ? fmi3OK : fmi3Error;
}

/* There is nothing to do. */
#define STATE(name) \
    EXPORT fmi3Status name(fmi3Instance c) { return c ? fmi3OK : fmi3Error; }
STATE(fmi3ExitInitializationMode)
STATE(fmi3EnterEventMode)
STATE(fmi3EnterStepMode)
STATE(fmi3EnterConfigurationMode)
STATE(fmi3ExitConfigurationMode)
STATE(fmi3Terminate)

EXPORT fmi3Status fmi3SetDebugLogging(fmi3Instance c, bool on, size_t n, const fmi3String categories[])
{
    (void)c, (void)on, (void)n, (void)categories;
    return fmi3OK;
}

/* Variables of other types: there are none. */
#define NONE(name, type) \
    EXPORT fmi3Status fmi3Get##name(fmi3Instance c, const fmi3ValueReference vr[], size_t n, type value[], size_t size) \
    { \
        (void)c, (void)vr, (void)value, (void)size; \
        return n ? fmi3Error : fmi3OK; \
    } \
    EXPORT fmi3Status fmi3Set##name(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const type value[], \
                                    size_t size) \
    { \
        (void)c, (void)vr, (void)value, (void)size; \
        return n ? fmi3Error : fmi3OK; \
    }
NONE(Float32, float)
NONE(Int8, int8_t)
NONE(UInt8, uint8_t)
NONE(Int16, int16_t)
NONE(UInt16, uint16_t)
NONE(Int32, int32_t)
NONE(UInt32, uint32_t)
NONE(Int64, int64_t)
NONE(UInt64, uint64_t)
NONE(Boolean, bool)
NONE(String, fmi3String)

/* Not offered: other kinds of units, clocks, binary values, saved states, derivatives. The caller gets an error. */
#define REFUSED(name) \
    EXPORT fmi3Status name(void) { return fmi3Error; }
REFUSED(fmi3GetBinary)
REFUSED(fmi3SetBinary)
REFUSED(fmi3GetClock)
REFUSED(fmi3SetClock)
REFUSED(fmi3GetNumberOfVariableDependencies)
REFUSED(fmi3GetVariableDependencies)
REFUSED(fmi3GetFMUState)
REFUSED(fmi3SetFMUState)
REFUSED(fmi3FreeFMUState)
REFUSED(fmi3SerializedFMUStateSize)
REFUSED(fmi3SerializeFMUState)
REFUSED(fmi3DeserializeFMUState)
REFUSED(fmi3GetDirectionalDerivative)
REFUSED(fmi3GetAdjointDerivative)
REFUSED(fmi3GetIntervalDecimal)
REFUSED(fmi3GetIntervalFraction)
REFUSED(fmi3GetShiftDecimal)
REFUSED(fmi3GetShiftFraction)
REFUSED(fmi3SetIntervalDecimal)
REFUSED(fmi3SetIntervalFraction)
REFUSED(fmi3SetShiftDecimal)
REFUSED(fmi3SetShiftFraction)
REFUSED(fmi3EvaluateDiscreteStates)
REFUSED(fmi3UpdateDiscreteStates)
REFUSED(fmi3GetOutputDerivatives)
REFUSED(fmi3ActivateModelPartition)
REFUSED(fmi3CompletedIntegratorStep)
REFUSED(fmi3EnterContinuousTimeMode)
REFUSED(fmi3GetContinuousStateDerivatives)
REFUSED(fmi3GetContinuousStates)
REFUSED(fmi3GetEventIndicators)
REFUSED(fmi3GetNominalsOfContinuousStates)
REFUSED(fmi3GetNumberOfContinuousStates)
REFUSED(fmi3GetNumberOfEventIndicators)
REFUSED(fmi3SetContinuousStates)
REFUSED(fmi3SetTime)

EXPORT fmi3Instance fmi3InstantiateModelExchange(void) { return NULL; }
EXPORT fmi3Instance fmi3InstantiateScheduledExecution(void) { return NULL; }
