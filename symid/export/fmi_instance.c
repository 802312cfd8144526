/* A unit for co-simulation around an axis exported by symid. AXIS_... are defined above by the export. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include AXIS_SOURCE

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

/* Numbers of the variables: the inputs, the readings, the parameters, the internal step, the time. */
enum {
    FIRST_READING = AXIS_INPUTS,
    FIRST_PARAMETER = FIRST_READING + AXIS_READINGS,
    INTERNAL_STEP = FIRST_PARAMETER + AXIS_PARAMETERS,
    TIME
};

typedef struct {
    double p[AXIS_PARAMETERS]; /* laid out as AXIS_parameters: doubles only */
    double x[AXIS_STATES], y[AXIS_READINGS];
    double input[AXIS_INPUTS], internal_step, time;
#ifdef AXIS_way
    AXIS_way way; /* what delays hold back */
#endif
    int settled; /* whether lags have begun where the first inputs hold them */
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

/* 1 if all variables are known, else 0. */
static int get(const Instance *c, const unsigned int number[], size_t n, double value[])
{
    for (size_t i = 0; i < n; i++) {
        if (number[i] > TIME) return 0;
        value[i] = number[i] < FIRST_READING ? c->input[number[i]]
                 : number[i] < FIRST_PARAMETER ? c->y[number[i] - FIRST_READING]
                 : number[i] < INTERNAL_STEP ? c->p[number[i] - FIRST_PARAMETER]
                 : number[i] == INTERNAL_STEP ? c->internal_step
                 : c->time;
    }
    return 1;
}

/* 1 if all variables can be set to these values, else 0. */
static int set(Instance *c, const unsigned int number[], size_t n, const double value[])
{
    for (size_t i = 0; i < n; i++) {
        if (number[i] < FIRST_READING) c->input[number[i]] = value[i];
        else if (number[i] >= FIRST_PARAMETER && number[i] < INTERNAL_STEP) c->p[number[i] - FIRST_PARAMETER] = value[i];
        else if (number[i] == INTERNAL_STEP && value[i] > 0.0) c->internal_step = value[i];
        else return 0;
    }
    return 1;
}

/* 1 if the step is positive, else 0. */
static int advance(Instance *c, double time, double step)
{
    if (!(step > 0.0)) return 0;
    const int count = (int)ceil(step/c->internal_step*(1.0 - 1e-12));
    const double h = step/count;
#ifdef AXIS_settle
    if (!c->settled) AXIS_settle(parameters(c), c->x, AXIS_FORCES(c->input));
#endif
    c->settled = 1;
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
    c->time = time + step;
    return 1;
}
