/* An instance of the FMU, the same under every version of FMI: its phases, steps, variables, states and messages.
 *
 * Over it lies a shell, fmi2.c or fmi3.c, with the functions of one version. Names of functions of FMI, for messages,
 * come from there; statuses have the numbers that they have in all versions. */

#ifndef INSTANCE_H
#define INSTANCE_H

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
    bool suspect;        /* a value out of range was set */
    bool timed;          /* the start time is known */
    double next_time;    /* s, where the next communication step has to start; the time in model exchange */
    double stop_time;    /* s, infinite if the importer has defined none */
    double start_time;   /* s */
    double told;         /* s, interval of the clock that the importer has been told; 0 if none */
    int64_t samples;     /* taken at events */
};

/* What an FMU state saves. */
struct RunState {
    struct Progress progress;
    double block[];      /* of the alignment that a block needs */
};

/* What the importer gives; its logger is of a type that only the shell knows. */
struct Importer {
    void *environment;
    void (*logger)(void);
    void *(*allocate)(size_t count, size_t size);   /* zeroed; NULL, as the next one, for the C library's */
    void (*release)(void *memory);
};

struct Instance {
    struct Importer importer;
    char *name;
    bool logging;        /* of what is discarded; errors are always said */
    bool exchange;       /* for model exchange, not co-simulation */
    bool events;         /* for co-simulation with event mode: samples are taken at events, not in steps */
    bool early;          /* a step may end before its end, at the next sample */
    struct RunState *state;
    void *direction;     /* scratch for directional derivatives: a block, in model exchange */
};

#include "model.h"

/* -- of the shell -- */

/* Pass a message to the importer's logger, which there is. */
void tell(const struct Instance *instance, enum Status status, const char *category, const char *message);

/* A phase, and the type of a real variable, in the words of a version of FMI; the phases in which variables are read. */
const char *phase_name(enum Phase phase);
const char *real_type(void);
int readable_phases(void);

/* -- instance.c; `call` is the name of the function of FMI -- */

/* A new instance, or NULL and a message. The key of the FMU (GUID, instantiation token) has a name for the message. */
struct Instance *created(const struct Importer *importer, const char *name, bool exchange, bool logging,
                         const char *key_name, const char *key);
void freed(struct Instance *instance);

/* Let a new instance of what is sampled use event mode, and perhaps end its steps early. */
void use_events(struct Instance *instance, bool early);
enum Status set_logging(struct Instance *instance, bool on, size_t count, const char *const categories[]);

/* Start and stop time, s; the latter infinite if there is none. */
enum Status set_times(struct Instance *instance, const char *call, double start, double stop);
enum Status enter_initialization(struct Instance *instance, const char *call);
enum Status exit_initialization(struct Instance *instance, const char *call);
enum Status take_step(struct Instance *instance, const char *call, double time, double size);
enum Status end_run(struct Instance *instance, const char *call);
enum Status begin_anew(struct Instance *instance);

/* By how much rounding may put the importer's clock aside, s. */
double clock_rounding(const struct Instance *instance);

/* Memory by the importer's functions, or the C library's if it gives none; zeroed. */
void *allocate(const struct Importer *importer, size_t size);
void release(const struct Importer *importer, void *memory);

/* Compute the outputs, which are stale, from what is set so far. In the initialization that is done if it is in range: if
 * not, its end says so. In model exchange, what is out of range is refused, and a point at which there are no rates
 * discarded. */
enum Status compute(struct Instance *instance);

/* Leave the instance as one that can only be reset, restored or freed. */
enum Status fail(struct Instance *instance);

/* Refuse the first input or parameter that is not a finite number within its range. */
enum Status check_ranges(struct Instance *instance);

/* -- variables.c -- */

enum Status get_reals(struct Instance *instance, const char *call, const uint32_t references[], size_t count,
                      double values[]);
enum Status set_reals(struct Instance *instance, const char *call, const uint32_t references[], size_t count,
                      const double values[]);

/* Whether Boolean variables can be read, or set, now: what a Boolean is differs from version to version. */
bool booleans_readable(struct Instance *instance, const char *call, const uint32_t references[], size_t count,
                       const void *values);
bool booleans_settable(struct Instance *instance, const char *call, const uint32_t references[], size_t count,
                       const void *values);

/* Access to variables of a type that this FMU does not have. */
enum Status get_none(const struct Instance *instance, const char *call, size_t count);
enum Status set_none(const struct Instance *instance, const char *call, size_t count);

/* Whether a call with so many references and values can be carried out; says why if it cannot. */
bool callable(const struct Instance *instance, const char *call, int phases, const void *references, size_t count,
              const void *values);

/* -- events.c: event mode, of co-simulation too -- */

void begin_event(struct Instance *instance);
enum Status enter_event(struct Instance *instance, const char *call);

/* End an instant; `next` is the time of the next event (s), infinite if the importer knows it or there is none. */
enum Status take_event(struct Instance *instance, const char *call, bool *states_changed, double *next);

/* Leave event mode, of model exchange and of co-simulation. */
enum Status leave_event(struct Instance *instance, const char *call);
enum Status enter_steps(struct Instance *instance, const char *call);

/* Take the sample that falls on the event, with the inputs as they are. */
enum Status take_sample(struct Instance *instance);

/* Let time pass until the end of a step (s), in which no sample is taken: `end` becomes where it ends. */
enum Status hold(struct Instance *instance, double *end);

/* Whether a sample is due at the end of the step before. */
bool sample_due(const struct Instance *instance);

/* Whether an instance with event mode gives access to variables now: to set them, before the sample is taken; those of a
 * clock only while it is active. */
bool accessible_at_event(const struct Instance *instance, const uint32_t references[], size_t count, bool setting);

/* Whether a call is about the clock, and allowed in these phases. */
enum Status clocks_known(const struct Instance *instance, const char *call, int phases, const uint32_t references[],
                         size_t count, const void *values);

/* Access to the clock; values are whether it is active. */
enum Status set_clocks(struct Instance *instance, const char *call, const uint32_t references[], size_t count,
                       const bool values[]);
enum Status get_clocks(struct Instance *instance, const char *call, const uint32_t references[], size_t count,
                       bool values[]);

/* Interval of the clock, s, and whether the importer has not been told it yet; refusal of a call that sets it. */
enum { INTERVAL_READABLE = INITIALIZING | AT_EVENT };
double told_interval(struct Instance *instance, bool *changed);
enum Status set_interval(const struct Instance *instance, const char *call);

/* -- exchange.c: model exchange -- */

/* Whether a variable is a continuous state. */
bool is_state(uint32_t reference);

/* Whether an instance is for model exchange and a call allowed in its phase; says why if not. */
bool exchanging(const struct Instance *instance, const char *call, int phases);

enum Status complete_step(struct Instance *instance, const char *call);
enum Status set_time(struct Instance *instance, const char *call, double time);
enum Status set_states(struct Instance *instance, const char *call, const double values[], size_t count);
enum Status get_states(struct Instance *instance, const char *call, double values[], size_t count);
enum Status get_nominals(struct Instance *instance, const char *call, double values[], size_t count);
enum Status get_rates(struct Instance *instance, const char *call, double values[], size_t count);
enum Status get_indicators(struct Instance *instance, const char *call, double values[], size_t count);

/* Derivatives of unknowns along a seed of knowns, and of a seed of unknowns by each known. */
enum Status differentiate(struct Instance *instance, const char *call, const uint32_t unknowns[], size_t unknown_count,
                          const uint32_t knowns[], size_t known_count, const double seed[], double sensitivity[]);
enum Status differentiate_adjoint(struct Instance *instance, const char *call, const uint32_t unknowns[],
                                  size_t unknown_count, const uint32_t knowns[], size_t known_count,
                                  const double seed[], double sensitivity[]);

/* -- state.c -- */

enum Status save_state(struct Instance *instance, const char *call, void **place);
enum Status restore_state(struct Instance *instance, const char *call, const void *state);
enum Status free_state(struct Instance *instance, void **place);
enum Status serialized_size(struct Instance *instance, const char *call, const void *state, size_t *size);
enum Status serialize(struct Instance *instance, const char *call, const void *state, void *bytes, size_t size);
enum Status deserialize(struct Instance *instance, const char *call, const void *bytes, size_t size, void **place);

/* -- messages.c -- */

/* Log a message, formatted as by printf, and return REFUSED; here and below, without an instance nothing is logged. */
enum Status refuse(const struct Instance *instance, const char *format, ...);

/* The same for what the FMU cannot tell: DISCARDED, logged only if the importer has asked for that. */
enum Status discard(const struct Instance *instance, const char *format, ...);

/* For a function that the model description says the FMU does not have. */
enum Status absent(const struct Instance *instance, const char *call);

/* Log that a call is not allowed in the instance's phase, but in these, and return false. */
bool refuse_phase(const struct Instance *instance, const char *call, int phases);

/* Log what a status other than 0 of the block means, in a step from a time (s) over a step size (s), and return what it
 * is told as: REFUSED or DISCARDED. */
enum Status refuse_status(const struct Instance *instance, enum Status as, int64_t status, double time, double step);

/* A double in the fewest digits that give it back, as Python writes it; text has room for NUMBER_LENGTH. */
enum { NUMBER_LENGTH = 40 };
const char *number(double value, char *text);

/* Whether a call is allowed in the instance's phase; logs it if it is not. */
static inline bool allowed(const struct Instance *instance, const char *call, int phases)
{
    return instance && ((instance->state->progress.phase & phases) || refuse_phase(instance, call, phases));
}

/* Compute the outputs if they are stale. */
static inline enum Status refresh(struct Instance *instance)
{
    return instance->state->progress.stale ? compute(instance) : DONE;
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
