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

enum Status complete_step(struct Instance *instance, const char *call)
{
    if (!exchanging(instance, call, BETWEEN_EVENTS)) {
        return REFUSED;
    }
    struct RunState *state = instance->state;
    if (state->progress.suspect && check_ranges(instance) != DONE) {
        return fail(instance);
    }
    int64_t status = MODEL.continuous->derive(state->block);
    if (status != 0) {
        refuse_status(instance, REFUSED, status, state->progress.next_time, 0.0);
        return fail(instance);
    }
    state->progress.stale = false;
    MODEL.continuous->measure(state->block);
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

/* Whether there are derivatives of all unknowns by all knowns; says why if not, or the status of the point. */
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
    const struct Continuous *model = MODEL.continuous;
    for (size_t i = 0; i < unknown_count; ++i) {
        if (!listed(model->unknowns, model->unknown_count, unknowns[i])) {
            return refuse(instance, "%s of value reference %u, expected a derivative of a state or a continuous output",
                          call, (unsigned)unknowns[i]);
        }
    }
    for (size_t i = 0; i < known_count; ++i) {
        bool known = knowns[i] < MODEL.variable_count && !MODEL.variables[knowns[i]].boolean
                     && (MODEL.variables[knowns[i]].causality == INPUT || is_state(knowns[i]));
        if (!known) {
            return refuse(instance, "%s by value reference %u, expected a state or a real input", call,
                          (unsigned)knowns[i]);
        }
    }
    return refresh(instance);
}

/* Derivative of a variable along the direction. */
static double *along(const struct Instance *instance, uint32_t reference)
{
    return (double *)((char *)instance->direction + MODEL.variables[reference].offset
                      - offsetof(struct RunState, block));
}

enum Status differentiate(struct Instance *instance, const char *call, const uint32_t unknowns[], size_t unknown_count,
                          const uint32_t knowns[], size_t known_count, const double seed[], double sensitivity[])
{
    enum Status status = differentiable(instance, call, unknowns, unknown_count, knowns, known_count, seed, sensitivity);
    if (status != DONE) {
        return status;
    }
    memset(instance->direction, 0, MODEL.block_size);
    for (size_t i = 0; i < known_count; ++i) {
        *along(instance, knowns[i]) = seed[i];
    }
    MODEL.continuous->differentiate(instance->state->block, instance->direction);
    for (size_t i = 0; i < unknown_count; ++i) {
        sensitivity[i] = *along(instance, unknowns[i]);
    }
    return DONE;
}

enum Status differentiate_adjoint(struct Instance *instance, const char *call, const uint32_t unknowns[],
                                  size_t unknown_count, const uint32_t knowns[], size_t known_count,
                                  const double seed[], double sensitivity[])
{
    enum Status status = differentiable(instance, call, unknowns, unknown_count, knowns, known_count, seed, sensitivity);
    for (size_t k = 0; status == DONE && k < known_count; ++k) {   /* a column of the Jacobian at a time */
        memset(instance->direction, 0, MODEL.block_size);
        *along(instance, knowns[k]) = 1.0;
        MODEL.continuous->differentiate(instance->state->block, instance->direction);
        sensitivity[k] = 0.0;
        for (size_t i = 0; i < unknown_count; ++i) {
            sensitivity[k] += seed[i] * *along(instance, unknowns[i]);
        }
    }
    return status;
}
