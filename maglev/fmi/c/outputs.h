/* Values computed from inputs, parameters and states: outputs and rates, samples. */

#ifndef OUTPUTS_H
#define OUTPUTS_H

#include "instance.h"

/* Largest shift of the importer's clock by rounding, s. */
double clock_rounding(const struct Instance *instance);

/* Leave the instance as one that can only be reset, restored or freed. */
enum Status fail(struct Instance *instance);

/* When the next sample is to be taken, s; the interval between two, s; by how much a time may miss one, s. */
double next_sample(const struct Instance *instance);
double sample_interval(const struct Instance *instance);
double sample_tolerance(const struct Instance *instance);

/* Return true if a sample is due at the end of the step before. */
bool sample_due(const struct Instance *instance);

/* A sample falls on this event, and is not taken yet. */
void begin_sample(struct Instance *instance);

/* Take the sample of the event, with the present inputs; undo an early sample for a reader of an output. */
enum Status take_sample(struct Instance *instance);
void undo_sample(struct Instance *instance);

/* Compute the stale outputs from the values set so far. If they cannot be computed in the initialization, the end of
 * the initialization reports it. In model exchange a point without rates is discarded. */
enum Status compute(struct Instance *instance);

/* Compute the outputs if they are stale. */
static inline enum Status refresh(struct Instance *instance)
{
    return instance->state->progress.stale ? compute(instance) : DONE;
}

#endif
