/* Values computed from inputs, parameters and states: outputs, rates, samples. */

#include "outputs.h"

#include "messages.h"

#include <math.h>
#include <string.h>

/* Share of an interval by which an importer may miss the time of a sample. */
#define PUNCTUALITY 1.0e-3

/* Share of the time, of some ten times its rounding, by which an importer's clock may be aside. */
#define CLOCK_ROUNDING 1.0e-14

enum Status fail(struct Instance *instance)
{
    instance->state->progress.phase = FAILED;
    return REFUSED;
}

double clock_rounding(const struct Instance *instance)
{
    return CLOCK_ROUNDING * fabs(instance->state->progress.next_time);
}

double sample_interval(const struct Instance *instance)
{
    return *(const double *)((const char *)instance->state + MODEL.interval);
}

double next_sample(const struct Instance *instance)
{
    const struct Progress *progress = &instance->state->progress;
    return progress->start_time + (double)progress->samples * sample_interval(instance);
}

double sample_tolerance(const struct Instance *instance)
{
    return PUNCTUALITY * sample_interval(instance) + clock_rounding(instance);
}

bool sample_due(const struct Instance *instance)
{
    return fabs(instance->state->progress.next_time - next_sample(instance)) <= sample_tolerance(instance);
}

void begin_sample(struct Instance *instance)
{
    instance->state->progress.sampling = true;
    instance->state->progress.stale = true;
}

enum Status take_sample(struct Instance *instance)
{
    struct RunState *state = instance->state;
    int64_t status = MODEL.step(state->block, next_sample(instance), sample_interval(instance));
    if (status != 0) {
        refuse_status(instance, REFUSED, status, next_sample(instance), sample_interval(instance));
        return fail(instance);
    }
    state->progress.stale = false;
    return DONE;
}

/* For who reads an output before all inputs are set. */
static enum Status try_sample(struct Instance *instance)
{
    memcpy(before_sample(instance->state), instance->state->block, MODEL.block_size);
    return take_sample(instance);
}

void undo_sample(struct Instance *instance)
{
    memcpy(instance->state->block, before_sample(instance->state), MODEL.block_size);
    instance->state->progress.stale = true;
}

enum Status compute(struct Instance *instance)
{
    struct RunState *state = instance->state;
    struct Progress *progress = &state->progress;
    if (progress->sampling) {
        return try_sample(instance);
    }
    if (instance->exchange && progress->phase & (AT_EVENT | BETWEEN_EVENTS | TERMINATED)) {
        int64_t status = MODEL.continuous->derive(state->block);
        if (status != 0) {   /* an integrator may try another step */
            return refuse_status(instance, DISCARDED, status, progress->next_time, 0.0);
        }
    } else {
        if (instance->exchange && progress->phase == FAILED) {
            return DONE;
        }
        MODEL.start(state->block);
        if (instance->exchange) {
            MODEL.continuous->derive(state->block);
        }
    }
    progress->stale = false;
    return DONE;
}
