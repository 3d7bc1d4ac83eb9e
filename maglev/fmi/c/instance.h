/* An instance of the FMU, the same under every version of FMI: its phases, steps, variables, states and messages. Its
 * functions are in files that each know only those before them: messages, state, outputs, variables, exchange, events,
 * life. Above these is a shell, fmi2.c or fmi3.c, with the functions of one version. The shell gives the names of FMI
 * functions for messages; statuses have the numbers that they have in all versions. */

#ifndef INSTANCE_H
#define INSTANCE_H

#include "model.h"
#include "prefix.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Phases of an instance (FMI 2.0.4, figure 11; FMI 3.0, 2.3), one bit each so that a function can name those it is
 * allowed in. */
enum Phase {
    INSTANTIATED = 1,
    INITIALIZING = 2,
    RUNNING = 4,         /* co-simulation, between its steps */
    TERMINATED = 8,
    FAILED = 16,
    AT_EVENT = 32,       /* event mode of model exchange, or of co-simulation if the importer uses it */
    BETWEEN_EVENTS = 64, /* in model exchange */
};

/* Statuses of FMI that occur here, with its numbers. */
enum Status { DONE = 0, DISCARDED = 2, REFUSED = 3 };

/* Everything that a run changes but the block. */
struct Progress {
    enum Phase phase;
    bool exchange;       /* of an instance for model exchange */
    bool events;         /* of one for co-simulation with event mode */
    bool sampling;       /* at an event: a sample falls on it */
    bool stale;          /* the outputs of a block that has not started, or is continuous, are not computed yet */
    bool timed;          /* the start time is known */
    double next_time;    /* s, where the next communication step has to start; the time in model exchange */
    double stop_time;    /* s, infinite if the importer has defined none */
    double start_time;   /* s */
    double told;         /* s, interval of the clock as the importer knows it; 0 if it does not */
    int64_t samples;     /* taken at events */
};

/* Content of a saved FMU state. */
struct RunState {
    struct Progress progress;
    double block[];      /* of the alignment that a block needs; with event mode a second one, before_sample() */
};

/* Callbacks of the importer; only the shell knows the type of its logger. */
struct Importer {
    void *environment;
    void (*logger)(void);
    void *(*allocate)(size_t count, size_t size);   /* zeroed; NULL, as the next one, for the C library's */
    void (*release)(void *memory);
};

struct Instance {
    struct Importer importer;
    char *name;
    bool logging;        /* of discarded calls; errors are always logged */
    bool exchange;       /* for model exchange, not co-simulation */
    bool events;         /* for co-simulation with event mode: samples are taken at events, not in steps */
    bool early;          /* a step may end before its end, at the next sample */
    struct RunState *state;
    void *scratch;       /* two blocks, in model exchange: trial() and direction() */
};

/* Asked of the shell: to pass a message to the importer's logger, which there is. */
void tell(const struct Instance *instance, enum Status status, const char *category, const char *message);

/* Asked of it, too: a phase, and the type of a real variable, in the words of a version; the phases to read variables in. */
const char *phase_name(enum Phase phase);
const char *real_type(void);
int readable_phases(void);

/* True if a sample was taken early for a reader of an output, and can still be undone. */
static inline bool sample_tried(const struct Progress *progress)
{
    return progress->sampling && !progress->stale;
}

/* Bytes of a state, of an instance with event mode or without. */
static inline size_t state_size(bool events)
{
    return sizeof(struct RunState) + (events ? 2 : 1) * MODEL.block_size;
}

/* The room for a state of any instance of the FMU. */
static inline size_t state_room(void)
{
    return state_size(MODEL.sampling != NULL);
}

/* The block before the early sample. */
static inline void *before_sample(struct RunState *state)
{
    return (char *)state->block + MODEL.block_size;
}

/* A block to try things with; one of derivatives along a direction. */
static inline void *trial(const struct Instance *instance)
{
    return instance->scratch;
}

static inline void *direction(const struct Instance *instance)
{
    return (char *)instance->scratch + MODEL.block_size;
}

/* Return the address of a variable in a block. */
static inline void *in_block(void *block, const struct Variable *variable)
{
    return (char *)block + variable->offset - offsetof(struct RunState, block);
}

static inline double *real_at(const struct Instance *instance, const struct Variable *variable)
{
    return (double *)((char *)instance->state + variable->offset);
}

static inline bool *boolean_at(const struct Instance *instance, const struct Variable *variable)
{
    return (bool *)((char *)instance->state + variable->offset);
}

#endif
