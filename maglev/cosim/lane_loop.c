#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include "instance.h"
#include "export.h"
$includes

/* Endings of a run, as in lane_loop.py. */
enum { RUN_DONE, RUN_REFUSED, RUN_OTHERWISE };

/* The struct Moved of lane_loop.py. */
struct moved {
    double time, time_stride, size;
};

/* Return true if an instance would take a step of co-simulation in its present state. */
static bool ready(const struct Progress *progress)
{
    return progress->phase == RUNNING && !progress->exchange && !progress->events;
}

/* Several runs side by side, each in a lane: values that differ between them are vectors. */
#define LANES $width
enum { TRACKS = $tracks, COLUMNS = $columns, AMOUNTS = $amounts };
$lanes

static inline lanes_float lanes_from(const double *const *rows, int64_t place)
{
    lanes_float result;
    LANES_LOOP result[_lane] = rows[_lane][place];
    return result;
}

/* Take the size of a number into the sum and the largest one. */
static inline void lanes_take_size(double *sum, double *largest, lanes_float x)
{
    lanes_float total, most;
    __builtin_memcpy(&total, sum, sizeof total);
    __builtin_memcpy(&most, largest, sizeof most);
    x = lanes_fabs(x);
    lanes_put(sum, total + x);
    lanes_put(largest, lanes_select(x > most, x, most));
}

/* The blocks of all lanes, and the row of each track of outputs. */
struct in_lanes {
$members
};

/* Put initialised instances and first rows into a lane, the first one into lane 0. Returns RUN_REFUSED where an FMU
 * would refuse a step, RUN_OTHERWISE if they differ in a value that lanes share. Without instances it returns the
 * number of bytes of a group of lanes. */
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

/* Fill lanes without a run with a copy of a lane that has one; return false if there is no run at all. */
static bool fill(struct in_lanes *all, const bool *live)
{
    int from = 0;
    while (from < LANES && !live[from]) {
        ++from;
    }
    for (int to = 0; from < LANES && to < LANES; ++to) {
        if (!live[to]) {
$copy
        }
    }
    return from < LANES;
}

/* Give a variable, by its place in the list of those that change, another value in a lane. */
EXPORT void maglev_lanes_change(struct in_lanes *all, int64_t lane, int64_t what, double value);
void maglev_lanes_change(struct in_lanes *all, int64_t lane, int64_t what, double value)
{
    switch (what) {
$changes
    default: break;
    }
}

/* Run one group of lanes, see maglev_lanes. */
static inline void run_group(struct in_lanes *restrict all, const struct moved *calls, const void *const *rows, int64_t first,
                             int64_t end, int64_t last, double *seen, double *sizes, int64_t *status)
{
    const int64_t points = last + 1;
    bool live[LANES];
    $signals
    (void)points;
    (void)rows;
    for (int lane = 0; lane < LANES; ++lane) {
        live[lane] = status[lane] == RUN_DONE;
    }
    if (!fill(all, live)) {
        return;
    }
    for (int64_t k = first; k < end; ++k, seen += COLUMNS * LANES) {
        lanes_int refused = {0};
$see
        if (k == last) {
            break;
        }
$step
        if (lanes_any(refused)) {
            for (int lane = 0; lane < LANES; ++lane) {
                if (live[lane] && refused[lane]) {
                    live[lane] = false;
                    status[lane] = RUN_REFUSED;
                }
            }
            if (!fill(all, live)) {
                return;
            }
        }
    }
}

/* Write the rows for communication points `first` to before `end`, and make the steps that begin at them, but none at
 * the `last` point of all. `sizes` has sums and largest ones of amounts. `status` says how the run in each lane goes.
 * Each lane has TRACKS rows; that of a signal's track has its values at all points, one after the other. The data of a
 * group of lanes follow those of the group before it. */
EXPORT void maglev_lanes(struct in_lanes *taken, int64_t groups, const struct moved *calls, const void *const *rows,
                         int64_t first, int64_t end, int64_t last, double *seen, double *sizes, int64_t *status);
void maglev_lanes(struct in_lanes *taken, int64_t groups, const struct moved *calls, const void *const *rows,
                  int64_t first, int64_t end, int64_t last, double *seen, double *sizes, int64_t *status)
{
    for (int64_t group = 0; group < groups; ++group) {
        run_group(taken + group, calls, rows + group * LANES * TRACKS, first, end, last,
                  seen + group * (end - first) * COLUMNS * LANES, sizes + group * 2 * AMOUNTS * LANES,
                  status + group * LANES);
    }
}
