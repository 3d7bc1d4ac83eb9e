#include <math.h>
#include <stdbool.h>
#include <stdint.h>
$includes

/* How a run ends, as in block_loop.py. */
enum { RUN_DONE, RUN_REFUSED, RUN_ENDED, RUN_OTHERWISE };

/* The struct Moved of block_loop.py. */
struct moved {
    double time, time_stride, size;
};

/* What a run begins with: initialised blocks, and the first row of each track of outputs. */
struct beginning {
$members
};

$observer

/* All steps to communication point `last`. Of a track of signals, `rows` has the values of one after the other at all
   points. Returns RUN_REFUSED where an FMU would refuse something, RUN_ENDED as soon as somebody says so. */
static inline __attribute__((always_inline)) int64_t whole_run(
    const struct beginning *beginning, const struct moved *calls, const void *const *rows, int64_t last,
    const volatile int64_t *ended, struct observer *observer)
{
$begin
    const int64_t points = last + 1;
    struct seen seen = {{0}};
    bool refused = false;
    for (int64_t k = 0;; ++k) {
$see
        observe(observer, k, &seen);
        if (k == last) {
            return RUN_DONE;
        }
        if (k % 1024 == 0 && *ended) {
            return RUN_ENDED;
        }
$step
        if (refused) {
            return RUN_REFUSED;
        }
    }
}
