/* Access to the variables, by their places in the table: there are real and Boolean ones. */

#include "variables.h"

#include "messages.h"
#include "outputs.h"

#include <math.h>

static const int WRITABLE = INSTANTIATED | INITIALIZING | RUNNING | AT_EVENT | BETWEEN_EVENTS;

/* Return true if a reference is of a variable of this type. */
static inline bool known(uint32_t reference, bool boolean)
{
    return reference < MODEL.variable_count && MODEL.variables[reference].boolean == boolean;
}

/* Say why a reference is not known, and return false. */
static bool refuse_reference(const struct Instance *instance, uint32_t reference)
{
    if (reference >= MODEL.variable_count) {
        refuse(instance, "value reference = %u, expected 0 to %u", (unsigned)reference,
               (unsigned)(MODEL.variable_count - 1));
    } else {
        const struct Variable *variable = &MODEL.variables[reference];
        refuse(instance, "%s is a %s variable, expected a call for that type", variable->name,
               variable->boolean ? "Boolean" : real_type());
    }
    return false;
}

bool listed(const uint32_t references[], size_t count, uint32_t reference)
{
    for (size_t i = 0; i < count; ++i) {
        if (references[i] == reference) {
            return true;
        }
    }
    return false;
}

bool is_state(uint32_t reference)
{
    return MODEL.continuous && listed(MODEL.continuous->states, MODEL.continuous->state_count, reference);
}

bool callable(const struct Instance *instance, const char *call, int phases, const void *references, size_t count,
              const void *values)
{
    if (!allowed(instance, call, phases)) {
        return false;
    }
    if (count > 0 && (!references || !values)) {
        refuse(instance, "%s of %u variables with a null pointer, expected arrays", call, (unsigned)count);
        return false;
    }
    return true;
}

/* Return true if a variable other than an input can be set now; log the reason if not. */
static bool other_settable(const struct Instance *instance, uint32_t reference)
{
    const struct Variable *variable = &MODEL.variables[reference];
    const enum Phase phase = instance->state->progress.phase;
    if (instance->exchange && phase & (AT_EVENT | BETWEEN_EVENTS) && is_state(reference)) {
        return true;   /* FMI 3.0, 3.2.1; importers of FMI 2.0 such as CasADi do it too */
    }
    if (variable->causality != PARAMETER) {
        refuse(instance, "%s is %s, expected an input or a parameter to set", variable->name,
               variable->causality == OUTPUT ? "an output" : variable->causality == LOCAL ? "local" : "independent");
    } else if (phase == BETWEEN_EVENTS) {
        refuse(instance, "%s is a parameter, expected to be set in event mode", variable->name);
    } else if (variable->fixed && phase & (RUNNING | AT_EVENT)) {
        refuse(instance, "%s is a fixed parameter, expected to be set before the initialization ends", variable->name);
    } else {
        return true;
    }
    return false;
}

/* Return true if an instance with event mode gives access to variables now: to those of a clock only while it is
 * active. */
static bool accessible_at_event(const struct Instance *instance, const uint32_t references[], size_t count)
{
    const struct Progress *progress = &instance->state->progress;
    if (!MODEL.sampling->clocked || progress->sampling || !(progress->phase & (RUNNING | AT_EVENT))) {
        return true;
    }
    for (size_t i = 0; i < count; ++i) {
        if (references[i] < MODEL.variable_count) {
            const struct Variable *variable = &MODEL.variables[references[i]];
            if (variable->causality == INPUT || variable->causality == OUTPUT) {
                refuse(instance, "%s belongs to the clock, expected access to it in event mode while the clock is active",
                       variable->name);
                return false;
            }
        }
    }
    return true;
}

/* Return true if all variables of references can be set now; inputs always can. */
static bool settable(const struct Instance *instance, const uint32_t references[], size_t count, bool boolean)
{
    if (instance->events && !accessible_at_event(instance, references, count)) {
        return false;
    }
    for (size_t i = 0; i < count; ++i) {
        if (!known(references[i], boolean)) {
            return refuse_reference(instance, references[i]);
        }
        if (MODEL.variables[references[i]].causality != INPUT && !other_settable(instance, references[i])) {
            return false;
        }
    }
    return true;
}

/* Values are about to change: mark those that follow from them, in the initialization or at a sample, as stale. */
static void outdate(struct Instance *instance)
{
    struct Progress *progress = &instance->state->progress;
    if (instance->events && progress->phase == AT_EVENT) {
        if (sample_tried(progress)) {
            undo_sample(instance);
        }
    } else if (progress->phase != RUNNING) {
        progress->stale = true;
    }
}

enum Status get_reals(struct Instance *instance, const char *call, const uint32_t references[], size_t count,
                      double values[])
{
    if (!callable(instance, call, readable_phases(), references, count, values)
        || (instance->events && !accessible_at_event(instance, references, count))) {
        return REFUSED;
    }
    enum Status status = refresh(instance);
    if (status != DONE) {
        return status;
    }
    for (size_t i = 0; i < count; ++i) {
        if (!known(references[i], false)) {
            refuse_reference(instance, references[i]);
            return REFUSED;
        }
        values[i] = *real_at(instance, &MODEL.variables[references[i]]);
    }
    return DONE;
}

enum Status set_reals(struct Instance *instance, const char *call, const uint32_t references[], size_t count,
                      const double values[])
{
    if (!callable(instance, call, WRITABLE, references, count, values)
        || !settable(instance, references, count, false)) {
        return REFUSED;   /* and nothing is set */
    }
    char text[NUMBER_LENGTH];
    for (size_t i = 0; i < count; ++i) {
        const struct Variable *variable = &MODEL.variables[references[i]];
        if (!isfinite(values[i]) && instance->exchange && is_state(references[i])) {   /* another step may be tried */
            return discard(instance, "%s = %s, expected a finite number", variable->name, number(values[i], text));
        }
        if (!(values[i] >= variable->minimum && values[i] <= variable->maximum && isfinite(values[i]))) {
            return refuse_value(instance, variable, values[i]);
        }
    }
    outdate(instance);
    for (size_t i = 0; i < count; ++i) {
        *real_at(instance, &MODEL.variables[references[i]]) = values[i];
    }
    return DONE;
}

bool booleans_readable(struct Instance *instance, const char *call, const uint32_t references[], size_t count,
                       const void *values)
{
    if (!callable(instance, call, readable_phases(), references, count, values)
        || (instance->events && !accessible_at_event(instance, references, count))) {
        return false;
    }
    /* In model exchange they change only at events. */
    if ((!instance->exchange || instance->state->progress.phase == INITIALIZING) && refresh(instance) != DONE) {
        return false;
    }
    for (size_t i = 0; i < count; ++i) {
        if (!known(references[i], true)) {
            return refuse_reference(instance, references[i]);
        }
    }
    return true;
}

bool booleans_settable(struct Instance *instance, const char *call, const uint32_t references[], size_t count,
                       const void *values)
{
    if (!callable(instance, call, WRITABLE, references, count, values)
        || !settable(instance, references, count, true)) {
        return false;
    }
    outdate(instance);
    return true;
}

static enum Status no_such_type(const struct Instance *instance, const char *call, int phases, size_t count)
{
    if (!allowed(instance, call, phases)) {
        return REFUSED;
    }
    return count == 0 ? DONE : refuse(instance, "%s of %u variables, expected %s or Boolean variables: there are "
                                      "no others", call, (unsigned)count, real_type());
}

enum Status get_none(const struct Instance *instance, const char *call, size_t count)
{
    return no_such_type(instance, call, readable_phases(), count);
}

enum Status set_none(const struct Instance *instance, const char *call, size_t count)
{
    return no_such_type(instance, call, WRITABLE, count);
}
