#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include "instance.h"
#include "export.h"
#include "run.h"
$includes

$observer

/* Several runs side by side, each in a lane: what they differ in is a vector. */
#define LANES $width
$lanes

static inline lanes_float lanes_from(const double *const *rows, int64_t place)
{
    lanes_float result;
    LANES_LOOP result[_lane] = rows[_lane][place];
    return result;
}

/* The blocks of all lanes, and the row of each track of outputs. */
struct in_lanes {
$members
};

/* Put initialised instances and first rows into a lane, the first one into lane 0. Returns RUN_REFUSED where an FMU would
   refuse a step, RUN_OTHERWISE where they differ in what lanes have in common; without instances, the bytes of all. */
EXPORT int64_t maglev_lanes_take(struct in_lanes *all, struct Instance *const *instances, const void *const *rows,
                                 int64_t lane);
int64_t maglev_lanes_take(struct in_lanes *all, struct Instance *const *instances, const void *const *rows, int64_t lane)
{
    bool same = true;
    if (!instances) {
        return sizeof *all;
    }
    if ($not_ready) {
        return RUN_REFUSED;
    }
$load
    return same ? RUN_DONE : RUN_OTHERWISE;
}

/* Have a lane go on as another one. */
static void copy_lane(struct in_lanes *all, int to, int from)
{
$copy
}

/* Make all steps of the runs in the first lanes to communication point `last`; `status` says of each how it ends. Of
   tracks of signals, rows[run][track] has the values of one after the other at all points. */
EXPORT void maglev_lanes(const struct in_lanes *taken, int64_t count, const struct moved *calls,
                         const void *const *const *rows, int64_t last, const volatile int64_t *ended,
                         struct observer *const *observers, int64_t *status);
void maglev_lanes(const struct in_lanes *taken, int64_t count, const struct moved *calls, const void *const *const *rows,
                  int64_t last, const volatile int64_t *ended, struct observer *const *observers, int64_t *status)
{
    struct in_lanes all = *taken;
    const int64_t points = last + 1;
    struct seen seen[LANES] = {{{0}}};
    bool live[LANES];
    $signals
    (void)points;
    for (int lane = 0; lane < LANES; ++lane) {
        live[lane] = lane < count;
        if (!live[lane]) {
            copy_lane(&all, lane, 0);
        } else {
            status[lane] = RUN_DONE;
        }
    }
    for (int64_t k = 0;; ++k) {
        lanes_int refused = {0};
        for (int lane = 0; lane < LANES; ++lane) {
            if (live[lane]) {
$see
                observe(observers[lane], k, &seen[lane]);
            }
        }
        if (k == last) {
            return;
        }
        if (k % 1024 == 0 && *ended) {
            for (int lane = 0; lane < count; ++lane) {
                status[lane] = RUN_ENDED;
            }
            return;
        }
$step
        if (lanes_any(refused)) {
            int from = -1;
            for (int lane = 0; lane < LANES; ++lane) {
                if (live[lane] && refused[lane]) {
                    live[lane] = false;
                    status[lane] = RUN_REFUSED;
                }
                from = live[lane] ? lane : from;
            }
            if (from < 0) {
                return;
            }
            for (int lane = 0; lane < LANES; ++lane) {
                if (!live[lane]) {
                    copy_lane(&all, lane, from);
                }
            }
        }
    }
}
