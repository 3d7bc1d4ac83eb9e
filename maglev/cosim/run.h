/* How a run ends, as in block_loop.py. */
enum { RUN_DONE, RUN_REFUSED, RUN_ENDED, RUN_OTHERWISE };

/* The struct Moved of block_loop.py. */
struct moved {
    double time, time_stride, size;
};

/* Whether an instance would take a step of co-simulation as it is. */
static bool ready(const struct Progress *progress)
{
    return progress->phase == RUNNING && !progress->exchange && !progress->events;
}
