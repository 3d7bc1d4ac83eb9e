/* Model exchange: the states of the block, which the importer integrates, their rates, events, and derivatives. */

#include "exchange.h"

#include "messages.h"
#include "outputs.h"
#include "variables.h"

#include <math.h>
#include <string.h>

static const int READABLE = INITIALIZING | AT_EVENT | BETWEEN_EVENTS | TERMINATED | FAILED;

bool exchanging(const struct Instance *instance, const char *call, int phases)
{
    if (instance && !instance->exchange) {
        if (MODEL.continuous) {
            refuse(instance, "%s of an instance for co-simulation, expected one for model exchange", call);
        } else {
            absent(instance, call);
        }
        return false;
    }
    return allowed(instance, call, phases);
}

/* The same for a call with an array of values. */
static bool fitting(const struct Instance *instance, const char *call, int phases, const void *values, size_t count,
                    size_t expected)
{
    if (!exchanging(instance, call, phases)) {
        return false;
    }
    if (count != expected || !values) {
        refuse(instance, "%s of %u values%s, expected an array of %u", call, (unsigned)count,
               values ? "" : " with a null pointer", (unsigned)expected);
        return false;
    }
    return true;
}

static double *state_at(const struct Instance *instance, size_t i)
{
    return real_at(instance, &MODEL.variables[MODEL.continuous->states[i]]);
}

/* Return true if an event here would change an output that only events change: a copy of the block takes it in. */
static bool outputs_due(const struct Instance *instance)
{
    const struct RunState *state = instance->state;
    memcpy(trial(instance), state->block, MODEL.block_size);
    MODEL.continuous->settle(trial(instance));
    for (size_t i = 0; i < MODEL.variable_count; ++i) {
        const struct Variable *variable = &MODEL.variables[i];
        if (variable->causality == OUTPUT && variable->discrete) {
            const void *after = in_block(trial(instance), variable);
            bool due = variable->boolean ? *(const bool *)after != *boolean_at(instance, variable)
                                         : *(const double *)after != *real_at(instance, variable);
            if (due) {
                return true;
            }
        }
    }
    return false;
}

enum Status complete_step(struct Instance *instance, const char *call, bool *event)
{
    *event = false;
    if (!exchanging(instance, call, BETWEEN_EVENTS)) {
        return REFUSED;
    }
    struct RunState *state = instance->state;
    int64_t status = MODEL.continuous->derive(state->block);
    if (status != 0) {
        refuse_status(instance, REFUSED, status, state->progress.next_time, 0.0);
        return fail(instance);
    }
    state->progress.stale = false;
    *event = outputs_due(instance);
    return DONE;
}

enum Status set_time(struct Instance *instance, const char *call, double time)
{
    char text[NUMBER_LENGTH];
    if (!exchanging(instance, call, AT_EVENT | BETWEEN_EVENTS)) {
        return REFUSED;
    }
    if (!isfinite(time)) {
        return refuse(instance, "time = %s s, expected a finite time", number(time, text));
    }
    instance->state->progress.next_time = time;
    return DONE;
}

enum Status set_states(struct Instance *instance, const char *call, const double values[], size_t count)
{
    char text[NUMBER_LENGTH];
    if (!fitting(instance, call, BETWEEN_EVENTS, values, count, MODEL.continuous ? MODEL.continuous->state_count : 0)) {
        return REFUSED;
    }
    for (size_t i = 0; i < count; ++i) {
        if (!isfinite(values[i])) {   /* an integrator may try another step */
            return discard(instance, "%s = %s, expected a finite number",
                           MODEL.variables[MODEL.continuous->states[i]].name, number(values[i], text));
        }
    }
    for (size_t i = 0; i < count; ++i) {
        *state_at(instance, i) = values[i];
    }
    instance->state->progress.stale = true;
    return DONE;
}

enum Status get_states(struct Instance *instance, const char *call, double values[], size_t count)
{
    if (!fitting(instance, call, READABLE, values, count, MODEL.continuous ? MODEL.continuous->state_count : 0)) {
        return REFUSED;
    }
    enum Status status = refresh(instance);
    for (size_t i = 0; status == DONE && i < count; ++i) {
        values[i] = *state_at(instance, i);
    }
    return status;
}

enum Status get_nominals(struct Instance *instance, const char *call, double values[], size_t count)
{
    if (!fitting(instance, call, READABLE | INSTANTIATED, values, count,
                 MODEL.continuous ? MODEL.continuous->state_count : 0)) {
        return REFUSED;
    }
    memcpy(values, MODEL.continuous->nominals, count * sizeof *values);
    return DONE;
}

/* Variables that follow from the states. */
static enum Status get_derived(struct Instance *instance, const uint32_t references[], double values[], size_t count)
{
    enum Status status = refresh(instance);
    for (size_t i = 0; status == DONE && i < count; ++i) {
        values[i] = *real_at(instance, &MODEL.variables[references[i]]);
    }
    return status;
}

enum Status get_rates(struct Instance *instance, const char *call, double values[], size_t count)
{
    if (!fitting(instance, call, READABLE, values, count, MODEL.continuous ? MODEL.continuous->state_count : 0)) {
        return REFUSED;
    }
    return get_derived(instance, MODEL.continuous->rates, values, count);
}

enum Status get_indicators(struct Instance *instance, const char *call, double values[], size_t count)
{
    if (!fitting(instance, call, READABLE, values, count, MODEL.continuous ? MODEL.continuous->indicator_count : 0)) {
        return REFUSED;
    }
    return get_derived(instance, MODEL.continuous->indicators, values, count);
}

/* Return true if a variable has derivatives in a phase: rates and real outputs, outputs of events where these can
 * change, and states while the initialization gives them their values. */
static bool is_unknown(uint32_t reference, enum Phase phase)
{
    if (reference >= MODEL.variable_count || MODEL.variables[reference].boolean) {
        return false;
    }
    const struct Variable *variable = &MODEL.variables[reference];
    return listed(MODEL.continuous->rates, MODEL.continuous->state_count, reference)
           || (variable->causality == OUTPUT && (!variable->discrete || phase & (INITIALIZING | AT_EVENT)))
           || (is_state(reference) && phase == INITIALIZING);
}

/* Return true if a variable can be the known of a derivative in a phase: real inputs and the time, start values in the
 * initialization, states after it. */
static bool is_known(uint32_t reference, enum Phase phase)
{
    if (reference >= MODEL.variable_count || MODEL.variables[reference].boolean) {
        return false;
    }
    const enum Causality causality = MODEL.variables[reference].causality;
    return causality == INPUT || causality == INDEPENDENT
           || (phase == INITIALIZING ? causality == PARAMETER : is_state(reference));
}

/* Return true if there are derivatives of all unknowns by all knowns; otherwise log the reason, or the status of the
 * point. */
static enum Status differentiable(struct Instance *instance, const char *call, const uint32_t unknowns[],
                                  size_t unknown_count, const uint32_t knowns[], size_t known_count, const double seed[],
                                  const double sensitivity[])
{
    if (!exchanging(instance, call, READABLE)
        || !callable(instance, call, READABLE, unknowns, unknown_count, unknowns)
        || !callable(instance, call, READABLE, knowns, known_count, knowns)) {
        return REFUSED;
    }
    if (!seed || !sensitivity) {
        return refuse(instance, "%s with a null pointer, expected arrays", call);
    }
    const enum Phase phase = instance->state->progress.phase;
    for (size_t i = 0; i < unknown_count; ++i) {
        if (!is_unknown(unknowns[i], phase)) {
            return refuse(instance, "%s of value reference %u %s, expected a derivative of a state or a real output%s",
                          call, (unsigned)unknowns[i], phase_name(phase), phase == INITIALIZING ? " or a state"
                          : phase == AT_EVENT ? "" : " that is continuous");
        }
    }
    for (size_t i = 0; i < known_count; ++i) {
        if (!is_known(knowns[i], phase)) {
            return refuse(instance, "%s by value reference %u %s, expected a real input or a %s", call,
                          (unsigned)knowns[i], phase_name(phase), phase == INITIALIZING ? "real parameter" : "state");
        }
    }
    return refresh(instance);
}

/* Derivative of a variable along the direction. */
static double *derivative_of(const struct Instance *instance, uint32_t reference)
{
    return in_block(direction(instance), &MODEL.variables[reference]);
}

/* Derivatives of all variables along a direction, which the seed of some knowns makes. */
static void derive_along(const struct Instance *instance, const uint32_t knowns[], size_t known_count,
                         const double seed[])
{
    const struct Continuous *model = MODEL.continuous;
    memcpy(trial(instance), instance->state->block, MODEL.block_size);
    memset(direction(instance), 0, MODEL.block_size);
    for (size_t i = 0; i < known_count; ++i) {
        if (MODEL.variables[knowns[i]].causality != INDEPENDENT) {   /* nothing follows from the time */
            *derivative_of(instance, knowns[i]) = seed[i];
        }
    }
    if (instance->state->progress.phase == INITIALIZING) {
        model->differentiate_start(trial(instance), direction(instance));
    }
    model->differentiate(trial(instance), direction(instance));
    if (instance->state->progress.phase == AT_EVENT) {
        model->differentiate_measurement(trial(instance), direction(instance));
    }
}

enum Status differentiate(struct Instance *instance, const char *call, const uint32_t unknowns[], size_t unknown_count,
                          const uint32_t knowns[], size_t known_count, const double seed[], double sensitivity[])
{
    enum Status status = differentiable(instance, call, unknowns, unknown_count, knowns, known_count, seed, sensitivity);
    if (status != DONE) {
        return status;
    }
    derive_along(instance, knowns, known_count, seed);
    for (size_t i = 0; i < unknown_count; ++i) {
        sensitivity[i] = *derivative_of(instance, unknowns[i]);
    }
    return DONE;
}

enum Status differentiate_adjoint(struct Instance *instance, const char *call, const uint32_t unknowns[],
                                  size_t unknown_count, const uint32_t knowns[], size_t known_count,
                                  const double seed[], double sensitivity[])
{
    enum Status status = differentiable(instance, call, unknowns, unknown_count, knowns, known_count, seed, sensitivity);
    for (size_t k = 0; status == DONE && k < known_count; ++k) {   /* a column of the Jacobian at a time */
        derive_along(instance, &knowns[k], 1, &(double){1.0});
        sensitivity[k] = 0.0;
        for (size_t i = 0; i < unknown_count; ++i) {
            sensitivity[k] += seed[i] * *derivative_of(instance, unknowns[i]);
        }
    }
    return status;
}
