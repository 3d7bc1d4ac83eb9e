/* The communication steps of a co-simulation whose calls are all C functions: the loop of step_loop.py, compiled. */

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#if defined _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef unsigned int (*Exchange)(void *instance, const uint32_t *references, size_t count, char *values);
typedef unsigned int (*DoStep)(void *instance, double time, double step, int no_set_before);
typedef unsigned int (*Exchange3)(void *instance, const uint32_t *references, size_t count, char *values,
                                  size_t values_count);
typedef unsigned int (*DoStep3)(void *instance, double time, double step, bool no_set_before, bool *event, bool *end,
                                bool *early, double *last_time);

/* The struct Prepared of step_loop.py. */
struct call {
    void *function;               /* that gets or sets values of one type; DoStep where there are no references */
    void *instance;
    const uint32_t *references;
    size_t count;
    char *row;                    /* values at the first communication point that lies in memory */
    int64_t row_stride;           /* bytes from one point to the next */
    double time, time_stride;     /* s */
    double step;                  /* s */
    int64_t fmi3;                 /* whether the function is of FMI 3.0 */
    int64_t warnings;             /* how often it has returned one */
};

enum { WARNING = 1, EARLY = 100, END = 101 };   /* the last two are of this loop: a step that was not made to its end */

/* A call of FMI 3.0 in communication step k, with the row; of a step that was not made to its end, the time that was
   reached (s). */
static unsigned int call_fmi3(const struct call *c, int64_t k, char *row, double *reached)
{
    bool event = false, end = false, early = false;
    if (c->references) {
        return ((Exchange3)c->function)(c->instance, c->references, c->count, row, c->count);
    }
    const double time = c->time + (double)k * c->time_stride, next = time + c->step;
    *reached = (double)NAN;
    const unsigned int status = ((DoStep3)c->function)(c->instance, time, c->step, true, &event, &end, &early, reached);
    if (status > WARNING) {
        return status;
    }
    /* 1e-6 of a step is PUNCTUAL in clocks.py; a time that is no number fails both comparisons. */
    const bool made = *reached >= next - 1e-6 * c->step && *reached <= next + 1e-6 * c->step;
    return end ? END : early && !made ? EARLY : status;
}

/* VERSION is of this text: a library of another text has other structures. */
EXPORT uint64_t maglev_step_loop_version(void) { return VERSION; }

/* Steps first to before last; step k makes the calls of phase k modulo their number, which end before ends[phase].
   Rows are counted from that of communication point origin. A call is counted in *begun before it is made. Returns the
   status of a call that was refused, with its step and number in refused[0] and refused[1], and the time that a step
   has reached in *reached; else 0. */
EXPORT unsigned int maglev_step_over(struct call *calls, const int64_t *ends, int64_t phases, int64_t first,
                                     int64_t last, int64_t origin, int64_t *begun, int64_t *refused, double *reached)
{
    int64_t phase = first % phases;
    for (int64_t k = first; k < last; ++k, phase = phase + 1 < phases ? phase + 1 : 0) {
        for (int64_t i = phase > 0 ? ends[phase - 1] : 0; i < ends[phase]; ++i) {
            struct call *c = &calls[i];
            ++*begun;
            char *const row = c->row + (k - origin) * c->row_stride;
            const unsigned int status = c->fmi3 ? call_fmi3(c, k, row, reached) : c->references
                ? ((Exchange)c->function)(c->instance, c->references, c->count, row)
                : ((DoStep)c->function)(c->instance, c->time + (double)k * c->time_stride, c->step, 1);
            if (status != 0) {
                if (status != WARNING) {
                    refused[0] = k;
                    refused[1] = i;
                    return status;
                }
                ++c->warnings;
            }
        }
    }
    return 0;
}
