/* The PD controller of the examples as an FMU of FMI 3.0 with a periodic clock of the importer's, after the text of the
 * standard: the interval is constant (2.2.10), inputs and outputs belong to the clock, each tick is one evaluation. It
 * refuses ticks that are out of time or left out, and access to what belongs to the clock while that is inactive. */

#include "pd_controller.c"

#include <stdbool.h>

#include "fmi3Functions.h"

#define INTERVAL 0.5e-3   /* s, as in the model description */

enum { TIME = VARIABLES, CLOCK };

typedef struct {
    Controller law;
    bool initialized, at_event, active, evaluated;
    long ticks;
    double time;   /* s */
} Clocked;

static bool near(double a, double b) { return fabs(a - b) < 1e-6 * INTERVAL; }

static void evaluate(Clocked *c) {
    if (c->active && !c->evaluated) control(&c->law, INTERVAL);
    c->evaluated = true;
}

/* FMI 3.0, 2.2.10.3 and 4.2: in the initialization, and in event mode while the clock is active. */
static bool accessible(const Clocked *c, const fmi3ValueReference vr[], size_t n) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] > TIME || (vr[i] <= CURRENT_W && c->initialized && !c->active)) return false;
    }
    return true;
}

static void renew(Clocked *c) {
    fmi2Component fresh = fmi2Instantiate("", fmi2CoSimulation, GUID, "", NULL, 0, 0);
    memset(c, 0, sizeof *c);
    memcpy(&c->law, fresh, sizeof c->law);
    fmi2FreeInstance(fresh);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference intermediate[], size_t n, fmi3InstanceEnvironment of,
                                         fmi3LogMessageCallback logger, fmi3IntermediateUpdateCallback update) {
    Clocked *c = events && strcmp(token, "clocked pd") == 0 ? malloc(sizeof *c) : NULL;
    (void)name; (void)resources; (void)visible; (void)logging; (void)early; (void)intermediate; (void)n; (void)of;
    (void)logger; (void)update;
    if (c != NULL) renew(c);
    return c;
}

void fmi3FreeInstance(fmi3Instance c) { free(c); }

fmi3Status fmi3Reset(fmi3Instance c) { renew(c); return fmi3OK; }

fmi3Status fmi3Terminate(fmi3Instance c) { (void)c; return fmi3OK; }

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean tolerant, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean stops, fmi3Float64 stop) {
    (void)tolerant; (void)tolerance; (void)stops; (void)stop;
    ((Clocked *)instance)->time = start;
    return start == 0.0 ? fmi3OK : fmi3Error;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    Clocked *c = instance;
    c->initialized = c->at_event = true;
    return fmi3OK;
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance) {
    Clocked *c = instance;
    if (!c->initialized || c->at_event) return fmi3Error;
    c->at_event = true;
    return fmi3OK;
}

fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Clock value[]) {
    Clocked *c = instance;
    if (!c->at_event || n != 1 || vr[0] != CLOCK || !value[0] || c->active || !near(c->time, c->ticks * INTERVAL)) {
        return fmi3Error;
    }
    c->active = true;
    c->evaluated = false;
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *again, fmi3Boolean *ends,
                                    fmi3Boolean *nominals, fmi3Boolean *states, fmi3Boolean *defined,
                                    fmi3Float64 *next) {
    Clocked *c = instance;
    if (!c->at_event) return fmi3Error;
    evaluate(c);
    c->ticks += c->active;
    c->active = false;
    *again = *ends = *nominals = *states = *defined = false;
    *next = 0.0;
    return fmi3OK;
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
    Clocked *c = instance;
    if (!c->at_event || c->active) return fmi3Error;
    c->at_event = false;
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 step, fmi3Boolean keep, fmi3Boolean *event,
                      fmi3Boolean *ends, fmi3Boolean *early, fmi3Float64 *last) {
    Clocked *c = instance;
    double next = c->ticks * INTERVAL;
    (void)keep;
    *event = *ends = *early = false;
    if (c->at_event || !near(time, c->time) || time > next - 1e-6 * INTERVAL || time + step > next + 1e-6 * INTERVAL) {
        return fmi3Error;
    }
    *last = c->time = time + step;
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Float64 value[],
                          size_t m) {
    Clocked *c = instance;
    if (n != m || !accessible(c, vr, n)) return fmi3Error;
    evaluate(c);
    for (size_t i = 0; i < n; i++) value[i] = vr[i] == TIME ? c->time : c->law.value[vr[i]];
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Float64 value[],
                          size_t m) {
    Clocked *c = instance;
    if (n != m || !accessible(c, vr, n) || (c->active && c->evaluated)) return fmi3Error;
    for (size_t i = 0; i < n; i++) c->law.value[vr[i]] = value[i];
    return fmi3OK;
}
