/* An FMU of FMI 3.0 with triggered clocks, after the text of the standard (2.2.10): its own clock `fired` ticks in the
 * event after `x` has risen above 1 in a step, and counts; at each tick of `take`, the importer's, `given` is added to
 * `total`. It refuses access to what belongs to a clock while that is inactive. */

#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"

enum { TIME, FIRED, X, COUNT, TAKE, GIVEN, TOTAL, VARIABLES };

typedef struct {
    double values[VARIABLES];
    bool above, risen, running, active[VARIABLES], taken;
} Triggered;

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference intermediate[], size_t n, fmi3InstanceEnvironment of,
                                         fmi3LogMessageCallback logger, fmi3IntermediateUpdateCallback update) {
    (void)name; (void)token; (void)resources; (void)visible; (void)logging; (void)early; (void)intermediate; (void)n;
    (void)of; (void)logger; (void)update;
    return events ? calloc(1, sizeof(Triggered)) : NULL;
}

void fmi3FreeInstance(fmi3Instance f) { free(f); }
fmi3Status fmi3Reset(fmi3Instance f) { memset(f, 0, sizeof(Triggered)); return fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance f) { (void)f; return fmi3OK; }
fmi3Status fmi3ExitInitializationMode(fmi3Instance f) { ((Triggered *)f)->running = true; return fmi3OK; }
fmi3Status fmi3EnterStepMode(fmi3Instance f) { (void)f; return fmi3OK; }

fmi3Status fmi3EnterInitializationMode(fmi3Instance f, fmi3Boolean tolerant, fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean stops, fmi3Float64 stop) {
    (void)f; (void)tolerant; (void)tolerance; (void)start; (void)stops; (void)stop;
    return fmi3OK;
}

fmi3Status fmi3EnterEventMode(fmi3Instance f) {
    Triggered *t = f;
    t->active[FIRED] = t->risen;
    if (t->risen) t->values[COUNT]++;
    t->risen = t->taken = false;
    return fmi3OK;
}

fmi3Status fmi3GetClock(fmi3Instance f, const fmi3ValueReference vr[], size_t n, fmi3Clock value[]) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != FIRED) return fmi3Error;
        value[i] = ((Triggered *)f)->active[FIRED];
    }
    return fmi3OK;
}

fmi3Status fmi3SetClock(fmi3Instance f, const fmi3ValueReference vr[], size_t n, const fmi3Clock value[]) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != TAKE) return fmi3Error;
        ((Triggered *)f)->active[TAKE] = value[i];
    }
    return fmi3OK;
}

static void take(Triggered *t) {
    if (t->active[TAKE] && !t->taken) t->values[TOTAL] += t->values[GIVEN];
    t->taken = true;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance f, fmi3Boolean *again, fmi3Boolean *ends, fmi3Boolean *nominals,
                                    fmi3Boolean *states, fmi3Boolean *defined, fmi3Float64 *next) {
    Triggered *t = f;
    take(t);
    t->active[FIRED] = t->active[TAKE] = false;
    *again = *ends = *nominals = *states = *defined = false;
    *next = 0.0;
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance f, fmi3Float64 time, fmi3Float64 step, fmi3Boolean keep, fmi3Boolean *event,
                      fmi3Boolean *ends, fmi3Boolean *early, fmi3Float64 *last) {
    Triggered *t = f;
    (void)keep;
    *event = t->risen = t->values[X] > 1.0 && !t->above;
    t->above = t->values[X] > 1.0;
    *ends = *early = false;
    *last = time + step;
    return fmi3OK;
}

static bool accessible(const Triggered *t, fmi3ValueReference vr) {
    const fmi3ValueReference clock = vr == COUNT ? FIRED : TAKE;
    return vr == TIME || vr == X || (vr != FIRED && vr != TAKE && (!t->running || t->active[clock]));
}

fmi3Status fmi3GetFloat64(fmi3Instance f, const fmi3ValueReference vr[], size_t n, fmi3Float64 value[], size_t count) {
    Triggered *t = f;
    (void)count;
    for (size_t i = 0; i < n; i++) {
        if (!accessible(t, vr[i])) return fmi3Error;
        if (vr[i] == TOTAL) take(t);
        value[i] = t->values[vr[i]];
    }
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance f, const fmi3ValueReference vr[], size_t n, const fmi3Float64 value[],
                          size_t count) {
    Triggered *t = f;
    (void)count;
    for (size_t i = 0; i < n; i++) {
        if (!accessible(t, vr[i])) return fmi3Error;
        t->values[vr[i]] = value[i];
    }
    return fmi3OK;
}
