/* The communication steps of a co-simulation whose calls are all C functions: the loop of stepping.py, compiled. */

#include <stddef.h>
#include <stdint.h>

#if defined _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef unsigned int (*Exchange)(void *instance, const uint32_t *references, size_t count, char *values);
typedef unsigned int (*DoStep)(void *instance, double time, double step, int no_set_before);

/* The struct Prepared of step_loop.py. */
struct call {
    void *function;               /* fmi2GetXXX, fmi2SetXXX; fmi2DoStep where there are no references */
    void *instance;
    const uint32_t *references;
    size_t count;
    char *row;                    /* values at communication point 0 */
    int64_t row_stride;           /* bytes from one point to the next */
    double time, time_stride;     /* s */
    double step;                  /* s */
};

/* VERSION is of this text: a library of another text has other structures. */
EXPORT uint64_t maglev_step_loop_version(void) { return VERSION; }

/* Steps first to before last; step k makes the calls of phase k modulo their number, which end before ends[phase].
   A call is counted in *begun before it is made. Returns the status of a call that was refused, with its step and number in refused[0] and refused[1]; else 0. */
EXPORT unsigned int maglev_step_over(const struct call *calls, const int64_t *ends, int64_t phases, int64_t first,
                                     int64_t last, int64_t *begun, int64_t *refused)
{
    for (int64_t k = first; k < last; ++k) {
        const int64_t phase = k % phases;
        for (int64_t i = phase > 0 ? ends[phase - 1] : 0; i < ends[phase]; ++i) {
            const struct call *c = &calls[i];
            ++*begun;
            const unsigned int status = c->references
                ? ((Exchange)c->function)(c->instance, c->references, c->count, c->row + k * c->row_stride)
                : ((DoStep)c->function)(c->instance, c->time + (double)k * c->time_stride, c->step, 1);
            if (status > 1) {   /* fmi2Warning */
                refused[0] = k;
                refused[1] = i;
                return status;
            }
        }
    }
    return 0;
}
