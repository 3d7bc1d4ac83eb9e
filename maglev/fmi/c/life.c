/* Instances of the FMU: their lives, phases and steps. */

#include "life.h"

#include "events.h"
#include "messages.h"
#include "outputs.h"
#include "state.h"

#include <math.h>
#include <string.h>

/* Largest difference between the importer's clock and the end of the step before. It is a share of a communication
 * step, at most so many seconds, plus the rounding of the time. */
#define CONTINUITY 1.0e-3
#define LARGEST_MISS 1.0e-5
/* s: a step that does not fit is ignored up to here. An importer that adds up its steps may have it left at the end. */
#define NO_STEP 1.0e-8
/* Of the time: two of its last bits, one for each of the two times in the difference that is a step. */
#define RESOLUTION 4.440892098500626e-16
/* Of a step: largest error of a step that a sampled block takes as whole. */
#define FITTING 0.999e-6
#define LARGEST_RATIO 1.0e9   /* of steps in a sample, or samples in a step: more fit none */

static void renew(struct Instance *instance)
{
    struct RunState *state = instance->state;
    /* Padding too, so that equal states are equal bytes; from here on members change one by one. */
    memset(state, 0, state_room());
    memcpy(state->block, MODEL.initial, MODEL.block_size);
    state->progress.phase = INSTANTIATED;
    state->progress.exchange = instance->exchange;
    state->progress.events = instance->events;
    state->progress.stale = true;
    state->progress.stop_time = INFINITY;
}

struct Instance *created(const struct Importer *importer, const char *name, bool exchange, bool logging,
                         const char *key_name, const char *key)
{
    if (!name) {
        name = "";
    }
    /* Until there is an instance, this one does the talking. */
    struct Instance nobody = {.importer = *importer, .name = (char *)name};
    if (!*name) {
        refuse(&nobody, "instance name = '', expected one");
        return NULL;
    }
    if (!key || strcmp(key, MODEL.guid) != 0) {
        refuse(&nobody, "%s = %s, expected %s: model description and binary are not of the same FMU", key_name,
               key ? key : "(none)", MODEL.guid);
        return NULL;
    }
    if (exchange && !MODEL.continuous) {
        refuse(&nobody, "%s supports co-simulation only, not model exchange", MODEL.name);
        return NULL;
    }
    struct Instance *instance = allocate(importer, sizeof *instance);
    char *kept_name = allocate(importer, strlen(name) + 1);
    struct RunState *state = allocate(importer, state_room());
    void *scratch = exchange ? allocate(importer, 2 * MODEL.block_size) : NULL;
    if (!instance || !kept_name || !state || (exchange && !scratch)) {
        refuse(&nobody, "out of memory");
        release(importer, scratch);
        release(importer, state);
        release(importer, kept_name);
        release(importer, instance);
        return NULL;
    }
    instance->importer = *importer;
    instance->name = strcpy(kept_name, name);
    instance->logging = logging;
    instance->exchange = exchange;
    instance->state = state;
    instance->scratch = scratch;
    renew(instance);
    return instance;
}

void use_events(struct Instance *instance, bool early)
{
    instance->events = true;
    instance->early = early;
    instance->state->progress.events = true;
}

void freed(struct Instance *instance)
{
    if (!instance) {
        return;
    }
    struct Importer importer = instance->importer;
    release(&importer, instance->scratch);
    release(&importer, instance->state);
    release(&importer, instance->name);
    release(&importer, instance);
}

enum Status set_logging(struct Instance *instance, bool on, size_t count, const char *const categories[])
{
    if (!instance) {
        return REFUSED;
    }
    bool discards = count == 0;
    for (size_t i = 0; i < count; ++i) {
        const char *category = categories && categories[i] ? categories[i] : "(none)";
        if (strcmp(category, "logAll") == 0 || strcmp(category, "logStatusDiscard") == 0) {
            discards = true;
        } else if (strcmp(category, "logStatusWarning") != 0 && strcmp(category, "logStatusError") != 0
                   && strcmp(category, "logStatusFatal") != 0) {
            return refuse(instance, "log category = %s, expected one of the model description", category);
        }
    }
    /* Errors are always logged. On enables the named categories; off leaves those that are not named unchanged. */
    instance->logging = on ? discards : instance->logging && !discards;
    return DONE;
}

enum Status set_times(struct Instance *instance, const char *call, double start, double stop)
{
    char text[NUMBER_LENGTH];
    if (!allowed(instance, call, INSTANTIATED)) {
        return REFUSED;
    }
    if (!isfinite(start)) {
        return refuse(instance, "start time = %s s, expected a finite time", number(start, text));
    }
    struct Progress *progress = &instance->state->progress;
    progress->timed = true;
    progress->next_time = start;
    progress->start_time = start;
    progress->stop_time = stop;
    return DONE;
}

enum Status enter_initialization(struct Instance *instance, const char *call)
{
    if (!allowed(instance, call, INSTANTIATED)) {
        return REFUSED;
    }
    instance->state->progress.phase = INITIALIZING;
    return DONE;
}

enum Status exit_initialization(struct Instance *instance, const char *call)
{
    if (!allowed(instance, call, INITIALIZING)) {
        return REFUSED;
    }
    int64_t status = MODEL.start(instance->state->block);
    if (status != 0) {
        refuse_status(instance, REFUSED, status, 0.0, 0.0);
        return fail(instance);
    }
    instance->state->progress.stale = instance->exchange;   /* the start leaves the rates to be computed */
    if (instance->exchange || instance->events) {
        begin_event(instance);
    } else {
        instance->state->progress.phase = RUNNING;
    }
    return DONE;
}

/* Return the step of whole samples, or of a whole fraction of one, that differs from `size` by the resolution of late
 * times; else `size`. From 1.7e9 s on, the time of computers' clocks, a difference of two times misses 0.5 ms by up to
 * 0.24 us. */
static double whole_step(const struct Instance *instance, double size, double resolution)
{
    double sample = sample_interval(instance), ratio = sample / size, steps = 1.0, samples = 1.0;
    if (!(ratio < LARGEST_RATIO && ratio * LARGEST_RATIO > 1.0)) {
        return size;
    }
    if (ratio >= 1.0) {
        steps = (double)(int64_t)(ratio + 0.5);
    } else {
        samples = (double)(int64_t)(size / sample + 0.5);
    }
    double whole = samples * sample / steps, miss = fabs(size - whole);
    /* Where neighbouring shares of a sample cannot be distinguished, the block refuses a step that does not fit. */
    return FITTING * whole < miss && miss <= resolution && 2.0 * steps * resolution < whole ? whole : size;
}

enum Status take_step(struct Instance *instance, const char *call, double time, double size)
{
    char text[NUMBER_LENGTH], expected[NUMBER_LENGTH];
    double end = time + size;
    if (!allowed(instance, call, RUNNING)) {
        return REFUSED;
    }
    struct RunState *state = instance->state;
    struct Progress *progress = &state->progress;
    if (!(size > 0.0 && isfinite(size))) {
        refuse(instance, "communication step = %s s, expected a positive, finite step", number(size, text));
        return fail(instance);
    }
    if (!isfinite(end)) {
        refuse(instance, "communication point = %s s, expected a finite time", number(time, text));
        return fail(instance);
    }
    double miss = CONTINUITY * size;
    double tolerance = (miss < LARGEST_MISS ? miss : LARGEST_MISS) + clock_rounding(instance);
    if (progress->timed && !(fabs(time - progress->next_time) <= tolerance)) {
        refuse(instance, "communication point = %s s, expected %s s, where the step before ended",
               number(time, text), number(progress->next_time, expected));
        return fail(instance);
    }
    /* FMI 2.0.4, fmi2SetupExperiment: an error. The clock of an importer that adds up its steps may have drifted. */
    if (end > progress->stop_time + CONTINUITY * size + clock_rounding(instance)) {
        refuse(instance, "communication step to %s s, expected at most the stop time, %s s", number(end, text),
               number(progress->stop_time, expected));
        return fail(instance);
    }
    int64_t status = 0;
    double resolution = RESOLUTION * (fabs(time) + size);
    if (!instance->events) {
        bool late = MODEL.interval && resolution > FITTING * size;
        status = MODEL.step(state->block, time, late ? whole_step(instance, size, resolution) : size);
    } else if (hold(instance, &end) != DONE) {
        return fail(instance);
    }
    if (status != 0 && (MODEL.variable_step || size > NO_STEP + resolution)) {
        refuse_status(instance, REFUSED, status, time, size);
        return fail(instance);
    }
    progress->timed = true;
    progress->next_time = end;
    return DONE;
}

enum Status end_run(struct Instance *instance, const char *call)
{
    if (!allowed(instance, call, RUNNING | AT_EVENT | BETWEEN_EVENTS)) {
        return REFUSED;
    }
    instance->state->progress.phase = TERMINATED;
    return DONE;
}

enum Status begin_anew(struct Instance *instance)
{
    if (!instance) {
        return REFUSED;
    }
    renew(instance);
    return DONE;
}
