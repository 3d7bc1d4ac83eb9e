/* A small FMU of FMI 3.0, x' = u - x, for co-simulation and for model exchange, with holes for what no FMU should do.
 *
 * What is defined as a hole stands at the end of its function; it sees the arguments and `f`. */

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "fmi3Functions.h"

#define AT 0.1   /* s, time of the step in which a fault shows */

enum { TIME, INPUT, STATE, RATE, OUTPUT, FLAG, INDICATOR };

#ifndef IN_STEP
#define IN_STEP
#endif
#ifndef IN_UPDATE
#define IN_UPDATE
#endif
#ifndef IN_NOMINALS
#define IN_NOMINALS
#endif
#ifndef IN_INDICATORS
#define IN_INDICATORS
#endif
#ifndef IN_RATES
#define IN_RATES
#endif
#ifndef IN_FLAGS
#define IN_FLAGS
#endif
#ifndef IN_INITIALIZATION
#define IN_INITIALIZATION
#endif
#ifndef IN_TERMINATE
#define IN_TERMINATE
#endif
#ifndef IN_FREE
#define IN_FREE
#endif
#ifndef INDICATORS
#define INDICATORS 1
#endif
#ifndef STATES
#define STATES 1
#endif

typedef struct {
    double time, u, x;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} Small;

static Small *renewed(Small *f) {
    f->time = f->u = 0.0;
    f->x = 1.0;
    return f;
}

static bool late(const Small *f) { return f->time > AT - 1e-6; }

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference intermediate[], size_t n, fmi3InstanceEnvironment of,
                                         fmi3LogMessageCallback logger, fmi3IntermediateUpdateCallback update) {
    Small *f = calloc(1, sizeof *f);
    (void)name; (void)token; (void)resources; (void)visible; (void)logging; (void)events; (void)early;
    (void)intermediate; (void)n; (void)update;
    f->environment = of;
    f->log = logger;
    return renewed(f);
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment of,
                                          fmi3LogMessageCallback logger) {
    return fmi3InstantiateCoSimulation(name, token, resources, visible, logging, false, false, NULL, 0, of, logger,
                                       NULL);
}

void fmi3FreeInstance(fmi3Instance f) { IN_FREE; free(f); }

fmi3Status fmi3Reset(fmi3Instance f) { renewed(f); return fmi3OK; }

fmi3Status fmi3Terminate(fmi3Instance f) { (void)f; IN_TERMINATE; return fmi3OK; }

fmi3Status fmi3EnterInitializationMode(fmi3Instance f, fmi3Boolean tolerant, fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean stops, fmi3Float64 stop) {
    (void)f; (void)tolerant; (void)tolerance; (void)start; (void)stops; (void)stop;
    IN_INITIALIZATION;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance f) { (void)f; return fmi3OK; }

fmi3Status fmi3EnterEventMode(fmi3Instance f) { (void)f; return fmi3OK; }

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance f) { (void)f; return fmi3OK; }

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 step, fmi3Boolean keep, fmi3Boolean *event,
                      fmi3Boolean *ends, fmi3Boolean *early, fmi3Float64 *last) {
    Small *f = instance;
    (void)keep; (void)event; (void)ends; (void)early; (void)last;
    f->time = time;
    f->x = f->u + (f->x - f->u) * exp(-step);
    IN_STEP;
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *again, fmi3Boolean *ends,
                                    fmi3Boolean *nominals, fmi3Boolean *states, fmi3Boolean *defined,
                                    fmi3Float64 *next) {
    Small *f = instance;
    (void)f; (void)next;
    *again = *ends = *nominals = *states = *defined = false;
    IN_UPDATE;
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Float64 value[],
                          size_t m) {
    const Small *f = instance;
    (void)m;
    for (size_t i = 0; i < n; i++) {
        value[i] = vr[i] == INPUT ? f->u : vr[i] == RATE ? f->u - f->x : vr[i] == TIME ? f->time : f->x;
    }
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Float64 value[],
                          size_t m) {
    Small *f = instance;
    (void)m;
    for (size_t i = 0; i < n; i++) *(vr[i] == INPUT ? &f->u : &f->x) = value[i];
    return fmi3OK;
}

fmi3Status fmi3SetString(fmi3Instance f, const fmi3ValueReference vr[], size_t n, const fmi3String text[], size_t m) {
    (void)vr; (void)m;
    if (n) ((Small *)f)->x = atof(text[0]);
    return fmi3OK;
}

fmi3Status fmi3SetInt64(fmi3Instance f, const fmi3ValueReference vr[], size_t n, const fmi3Int64 value[], size_t m) {
    (void)vr; (void)m;
    if (n) ((Small *)f)->x = (double)value[0];
    return fmi3OK;
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Boolean value[],
                          size_t m) {
    const Small *f = instance;
    (void)vr; (void)m;
    for (size_t i = 0; i < n; i++) value[i] = f->x > 0.5;
    IN_FLAGS;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance f, fmi3Float64 time) { ((Small *)f)->time = time; return fmi3OK; }

fmi3Status fmi3SetContinuousStates(fmi3Instance f, const fmi3Float64 value[], size_t n) {
    if (n) ((Small *)f)->x = value[0];
    return fmi3OK;
}

fmi3Status fmi3GetContinuousStates(fmi3Instance f, fmi3Float64 value[], size_t n) {
    if (n) value[0] = ((Small *)f)->x;
    return fmi3OK;
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 value[], size_t n) {
    const Small *f = instance;
    if (n) value[0] = f->u - f->x;
    IN_RATES;
    return fmi3OK;
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 value[], size_t n) {
    const Small *f = instance;
    (void)f;
    if (n) value[0] = 1.0;
    IN_NOMINALS;
    return fmi3OK;
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 value[], size_t n) {
    const Small *f = instance;
    if (n) value[0] = f->x - 0.5;
    IN_INDICATORS;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance f, size_t *n) { (void)f; *n = INDICATORS; return fmi3OK; }

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance f, size_t *n) { (void)f; *n = STATES; return fmi3OK; }

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance f, fmi3Boolean keep, fmi3Boolean *event, fmi3Boolean *ends) {
    (void)f; (void)keep;
    *event = *ends = false;
    return fmi3OK;
}
