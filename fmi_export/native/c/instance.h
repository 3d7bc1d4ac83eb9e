/* An instance of the FMU. */

#ifndef INSTANCE_H
#define INSTANCE_H

#include "prefix.h"

#include "fmi2Functions.h"
#include "model.h"

/* Phases of an instance (FMI 2.0.4, figure 11), one bit each so that a function can name those it is allowed in. */
enum Phase {
    INSTANTIATED = 1,
    INITIALIZING = 2,
    RUNNING = 4,
    TERMINATED = 8,
    FAILED = 16,
};

/* Everything that a run changes: what an FMU state saves. */
struct Progress {
    enum Phase phase;
    bool stale;          /* the outputs of a block that has not started are not computed yet */
    bool suspect;        /* a value out of range was set */
    bool timed;          /* the start time is known */
    double next_time;    /* s, where the next communication step has to start */
    double stop_time;    /* s, infinite if the importer has defined none */
};

struct Instance {
    fmi2CallbackFunctions callbacks;
    char *name;
    bool logging;        /* of what is discarded; errors are always said */
    struct Progress progress;
    void *block;
};


/* Memory by the importer's functions, or the C library's if it gives none; zeroed. */
void *allocate(const fmi2CallbackFunctions *callbacks, size_t size);
void release(const fmi2CallbackFunctions *callbacks, void *memory);

/* Compute the initial outputs from what is set so far, if it is in range: if not, the end of the initialization says so. */
void refresh(struct Instance *instance);

/* Log a message, formatted as by printf, and return fmi2Error; here and below, without an instance nothing is logged. */
fmi2Status refuse(const struct Instance *instance, const char *format, ...);

/* The same for what the FMU cannot tell: fmi2Discard, logged only if the importer has asked for that. */
fmi2Status discard(const struct Instance *instance, const char *format, ...);

/* Whether a call is allowed in the instance's phase; logs it if it is not. */
bool allowed(const struct Instance *instance, const char *call, int phases);

/* Log what a status other than 0 of the block means, in a step from a time (s) over a step size (s). */
fmi2Status refuse_status(const struct Instance *instance, int64_t status, double time, double step);

/* A double in the fewest digits that give it back, as Python writes it; text has room for NUMBER_LENGTH. */
enum { NUMBER_LENGTH = 40 };
const char *number(double value, char *text);

static inline double *real_at(const struct Instance *instance, const struct Variable *variable)
{
    return (double *)((char *)instance->block + variable->offset);
}

static inline bool *boolean_at(const struct Instance *instance, const struct Variable *variable)
{
    return (bool *)((char *)instance->block + variable->offset);
}

#endif
