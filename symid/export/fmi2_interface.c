/* FMI 2.0 for co-simulation around an axis exported by symid. AXIS_... are defined above by the export. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include AXIS_SOURCE

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef char fmi2Char;
typedef const fmi2Char *fmi2String;
typedef char fmi2Byte;
typedef unsigned int fmi2ValueReference;
typedef void *fmi2Component;
typedef void *fmi2FMUstate;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;

/* Numbers of the variables: the inputs, the readings, the parameters, the internal step. */
enum {
    FIRST_READING = AXIS_INPUTS,
    FIRST_PARAMETER = FIRST_READING + AXIS_READINGS,
    INTERNAL_STEP = FIRST_PARAMETER + AXIS_PARAMETERS
};

typedef struct {
    double p[AXIS_PARAMETERS]; /* laid out as AXIS_parameters: doubles only */
    double x[AXIS_STATES], y[AXIS_READINGS];
    double input[AXIS_INPUTS], internal_step;
#ifdef AXIS_way
    AXIS_way way; /* what delays hold back */
#endif
} Instance;

static const AXIS_parameters *parameters(const Instance *c) { return (const AXIS_parameters *)(const void *)c->p; }

static void reset(Instance *c)
{
    memset(c, 0, sizeof *c);
    memcpy(c->p, &AXIS_values, sizeof c->p);
    c->internal_step = 2e-5;
    const double still[AXIS_STATES] = {0.0};
    AXIS_sensors(c->x, still, c->y);
}

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

EXPORT fmi2Component fmi2Instantiate(fmi2String name, int type, fmi2String guid, fmi2String resources,
                                     const void *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)name, (void)resources, (void)functions, (void)visible, (void)logging;
    const int co_simulation = 1;
    if (type != co_simulation || strcmp(guid, AXIS_GUID) != 0) return NULL;
    Instance *c = malloc(sizeof *c);
    if (c) reset(c);
    return c;
}

EXPORT void fmi2FreeInstance(fmi2Component c) { free(c); }

EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[])
{
    (void)c, (void)on, (void)n, (void)categories;
    return fmi2OK;
}

EXPORT fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                                      fmi2Boolean has_stop, fmi2Real stop)
{
    (void)c, (void)has_tolerance, (void)tolerance, (void)start, (void)has_stop, (void)stop;
    return fmi2OK;
}

EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
EXPORT fmi2Status fmi2Terminate(fmi2Component c) { return c ? fmi2OK : fmi2Error; }

EXPORT fmi2Status fmi2Reset(fmi2Component component)
{
    reset(component);
    return fmi2OK;
}

EXPORT fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    const Instance *c = component;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] > INTERNAL_STEP) return fmi2Error;
        value[i] = vr[i] < FIRST_READING ? c->input[vr[i]]
                 : vr[i] < FIRST_PARAMETER ? c->y[vr[i] - FIRST_READING]
                 : vr[i] < INTERNAL_STEP ? c->p[vr[i] - FIRST_PARAMETER]
                 : c->internal_step;
    }
    return fmi2OK;
}

EXPORT fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference vr[], size_t n, const fmi2Real value[])
{
    Instance *c = component;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] < FIRST_READING) c->input[vr[i]] = value[i];
        else if (vr[i] >= FIRST_PARAMETER && vr[i] < INTERNAL_STEP) c->p[vr[i] - FIRST_PARAMETER] = value[i];
        else if (vr[i] == INTERNAL_STEP && value[i] > 0.0) c->internal_step = value[i];
        else return fmi2Error;
    }
    return fmi2OK;
}

EXPORT fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real step, fmi2Boolean keep)
{
    Instance *c = component;
    (void)time, (void)keep;
    if (!(step > 0.0)) return fmi2Error;
    const int count = (int)ceil(step/c->internal_step*(1.0 - 1e-12));
    const double h = step/count;
    for (int k = 0; k < count; k++) {
#ifdef AXIS_way
        AXIS_advance(parameters(c), &c->way, c->x, AXIS_FORCES(c->input), h, c->y);
#else
        double change[AXIS_STATES];
        memcpy(change, c->x, sizeof change);
        AXIS_step(parameters(c), c->x, AXIS_FORCES(c->input), h);
        for (int i = 0; i < AXIS_STATES; i++) change[i] = (c->x[i] - change[i])/h;
        AXIS_sensors(c->x, change, c->y);
#endif
    }
    return fmi2OK;
}

EXPORT fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) { (void)c, (void)state; return fmi2Error; }
EXPORT fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) { (void)c, (void)state; return fmi2Error; }
EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) { (void)c, (void)state; return fmi2Error; }

EXPORT fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    (void)c, (void)state, (void)size;
    return fmi2Error;
}

EXPORT fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    (void)c, (void)state, (void)bytes, (void)size;
    return fmi2Error;
}

EXPORT fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    (void)c, (void)bytes, (void)size, (void)state;
    return fmi2Error;
}

EXPORT fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n_unknown,
                                               const fmi2ValueReference known[], size_t n_known,
                                               const fmi2Real change_known[], fmi2Real change_unknown[])
{
    (void)c, (void)unknown, (void)n_unknown, (void)known, (void)n_known, (void)change_known, (void)change_unknown;
    return fmi2Error;
}

/* Variables of other types and derivatives of signals: there are none. */
#define NONE(name, type) \
    EXPORT fmi2Status name(fmi2Component c, const fmi2ValueReference vr[], size_t n, type value[]) \
    { \
        (void)c, (void)vr, (void)value; \
        return n ? fmi2Error : fmi2OK; \
    }
NONE(fmi2GetInteger, fmi2Integer)
NONE(fmi2SetInteger, const fmi2Integer)
NONE(fmi2GetBoolean, fmi2Boolean)
NONE(fmi2SetBoolean, const fmi2Boolean)
NONE(fmi2GetString, fmi2String)
NONE(fmi2SetString, const fmi2String)

EXPORT fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                              const fmi2Integer order[], const fmi2Real value[])
{
    (void)c, (void)vr, (void)order, (void)value;
    return n ? fmi2Error : fmi2OK;
}

EXPORT fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                               const fmi2Integer order[], fmi2Real value[])
{
    (void)c, (void)vr, (void)order, (void)value;
    return n ? fmi2Error : fmi2OK;
}

EXPORT fmi2Status fmi2CancelStep(fmi2Component c) { (void)c; return fmi2Error; }

/* Steps are never pending. */
#define STATUS(name, type) \
    EXPORT fmi2Status name(fmi2Component c, int kind, type *value) { (void)c, (void)kind, (void)value; return fmi2Discard; }
STATUS(fmi2GetStatus, fmi2Status)
STATUS(fmi2GetRealStatus, fmi2Real)
STATUS(fmi2GetIntegerStatus, fmi2Integer)
STATUS(fmi2GetBooleanStatus, fmi2Boolean)
STATUS(fmi2GetStringStatus, fmi2String)
