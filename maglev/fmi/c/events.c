/* Event mode: of model exchange, and of sampled FMUs in co-simulation, if the importer uses it there. Samples are then
 * taken at events, not in steps. An event is a sample if its time has come or, in an FMU with a clock, if the importer
 * activates the clock. The sample is taken with the inputs that are set in the event, by the end of the instant. An
 * output that is read before that follows from the inputs set so far: in a feedback loop some inputs follow from
 * outputs. */

#include "events.h"

#include "exchange.h"
#include "messages.h"
#include "outputs.h"
#include "variables.h"

#include <math.h>

/* Return true if a call of event mode is allowed; log the reason if not. */
static bool with_events(const struct Instance *instance, const char *call, int phases)
{
    if (!instance || instance->events) {
        return allowed(instance, call, phases);
    }
    if (instance->exchange) {
        refuse(instance, "%s of an instance for model exchange, expected one for co-simulation", call);
    } else if (MODEL.sampling) {
        refuse(instance, "%s of an instance without event mode, expected one with it", call);
    } else {
        absent(instance, call);
    }
    return false;
}

void begin_event(struct Instance *instance)
{
    instance->state->progress.phase = AT_EVENT;
    if (instance->events && !MODEL.sampling->clocked && sample_due(instance)) {
        begin_sample(instance);
    }
}

enum Status enter_event(struct Instance *instance, const char *call)
{
    if (!instance || !MODEL.sampling) {
        if (!exchanging(instance, call, BETWEEN_EVENTS | AT_EVENT)) {   /* FMI 2.0.4, 3.2.3: in event mode too */
            return REFUSED;
        }
    } else if (!with_events(instance, call, RUNNING)) {
        return REFUSED;
    }
    begin_event(instance);
    return DONE;
}

enum Status take_event(struct Instance *instance, const char *call, bool *states_changed, double *next)
{
    *states_changed = false;
    *next = INFINITY;
    if (instance && instance->events) {
        if (!allowed(instance, call, AT_EVENT)) {
            return REFUSED;
        }
        struct Progress *progress = &instance->state->progress;
        if (progress->sampling) {
            if (progress->stale && take_sample(instance) != DONE) {
                return REFUSED;
            }
            progress->sampling = false;
            ++progress->samples;
        }
        if (!MODEL.sampling->clocked) {
            *next = next_sample(instance);
        }
        return DONE;
    }
    if (!exchanging(instance, call, AT_EVENT)) {
        return REFUSED;
    }
    struct RunState *state = instance->state;
    MODEL.continuous->settle(state->block);
    *states_changed = true;   /* or rates: some importers (fmusim) restart their solver only if they are told so */
    state->progress.stale = true;
    return DONE;
}

enum Status leave_event(struct Instance *instance, const char *call)
{
    if (!exchanging(instance, call, AT_EVENT)) {
        return REFUSED;
    }
    instance->state->progress.phase = BETWEEN_EVENTS;
    return DONE;
}

enum Status enter_steps(struct Instance *instance, const char *call)
{
    char text[NUMBER_LENGTH];
    if (!with_events(instance, call, AT_EVENT)) {
        return REFUSED;
    }
    if (instance->state->progress.sampling) {
        return refuse(instance, "%s at t = %s s, where a sample is due, expected an update of the discrete "
                      "states before", call, number(next_sample(instance), text));
    }
    instance->state->progress.phase = RUNNING;
    return DONE;
}

enum Status hold(struct Instance *instance, double *end)
{
    char from[NUMBER_LENGTH], to[NUMBER_LENGTH], at[NUMBER_LENGTH];
    double time = instance->state->progress.next_time, next = next_sample(instance), slack = sample_tolerance(instance);
    bool stops = instance->early && !MODEL.sampling->clocked;   /* for an event */
    if (next <= time + slack && !stops) {
        return refuse(instance, "communication step from %s s, expected event mode before it%s, as a sample is due at "
                      "%s s", number(time, from), MODEL.sampling->clocked ? " with the clock active" : "",
                      number(next, at));
    }
    if (next < *end - slack) {
        if (!stops) {
            return refuse(instance, "communication step from %s s to %s s, expected one to %s s at most, where the next "
                          "sample is due", number(time, from), number(*end, to), number(next, at));
        }
        *end = next > time ? next : time;
    }
    return DONE;
}

enum Status clocks_known(const struct Instance *instance, const char *call, int phases, const uint32_t references[],
                         size_t count, const void *values)
{
    if (!MODEL.sampling || !MODEL.sampling->clocked) {
        return absent(instance, call);
    }
    if (!with_events(instance, call, phases) || !callable(instance, call, phases, references, count, values)) {
        return REFUSED;
    }
    for (size_t i = 0; i < count; ++i) {
        if (references[i] != MODEL.sampling->clock) {
            return refuse(instance, "%s of value reference %u, expected the clock, %u", call, (unsigned)references[i],
                          (unsigned)MODEL.sampling->clock);
        }
    }
    return DONE;
}

enum Status set_clocks(struct Instance *instance, const char *call, const uint32_t references[], size_t count,
                       const bool values[])
{
    char now[NUMBER_LENGTH], expected[NUMBER_LENGTH];
    if (clocks_known(instance, call, AT_EVENT, references, count, values) != DONE) {
        return REFUSED;
    }
    for (size_t i = 0; i < count; ++i) {
        if (!values[i]) {
            return refuse(instance, "clock = inactive, expected active: the FMU deactivates it at the end of the instant");
        }
        if (!instance->state->progress.sampling) {
            if (!sample_due(instance)) {
                return refuse(instance, "clock = active at t = %s s, expected its next tick at %s s",
                              number(instance->state->progress.next_time, now), number(next_sample(instance), expected));
            }
            begin_sample(instance);
        }
    }
    return DONE;
}

enum Status get_clocks(struct Instance *instance, const char *call, const uint32_t references[], size_t count,
                       bool values[])
{
    if (clocks_known(instance, call, INTERVAL_READABLE, references, count, values) != DONE) {
        return REFUSED;
    }
    for (size_t i = 0; i < count; ++i) {
        values[i] = instance->state->progress.sampling;
    }
    return DONE;
}

double told_interval(struct Instance *instance, bool *changed)
{
    struct Progress *progress = &instance->state->progress;
    *changed = progress->phase == INITIALIZING && progress->told != sample_interval(instance);
    return progress->told = sample_interval(instance);
}

enum Status set_interval(const struct Instance *instance, const char *call)
{
    if (!MODEL.sampling || !MODEL.sampling->clocked) {
        return absent(instance, call);
    }
    return refuse(instance, "%s, expected the interval of the parameter sample_time, without a shift", call);
}
