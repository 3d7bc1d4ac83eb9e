/* Samples of a batch, each in a thread of a graphics processor; on another one, one after the other, by the same code.
   The run and measuring.c come before. Of what each sample has of its own, that of one lies behind that of another. */

/* Windows of a sample: as many as its references have steps. */
struct own_windows {
    int64_t count;
    const int64_t *starts, *steady;    /* as of a meter */
    struct window *found;
};

/* The struct OnDevice of graphics_processor.py. */
struct batch {
    int64_t samples, last;             /* last communication point */
    const void *beginnings;            /* of each, or of each its OWN words, where the rest is common */
    const struct moved *calls;
    const void *const *rows;           /* values of signals, of each sample by track */
    int64_t tracks;
    int64_t *returned;                 /* by each run */
    const struct own_windows *windows; /* of each */
    struct observer first;             /* of the first sample, without a meter and without windows */
};

static inline void run_sample(const struct batch *batch, int64_t sample)
{
    const int64_t never = 0;
    struct meter meter = {0};
    struct whole whole = {{0}};
    struct observer observer = batch->first;
    struct given *const given = &observer.given;
    const void *const *const rows = batch->rows + sample * batch->tracks;
    const struct own_windows *const windows = batch->windows + sample;
    observer.meter = &meter;
    observer.whole = &whole;            /* what is written at each point is a thread's own */
    observer.windows = windows->found;
    given->windows = windows->count;
    given->starts = windows->starts;
    given->steady = windows->steady;
    observer.events += sample * given->events;
    given->resistances += sample * MOTORS;
    if (given->errors) {
        given->errors += sample * AXES * given->points;
    }
    if (given->keeping) {
        given->kept += sample * KEPT * ((given->points - 1) / given->every + 1);
    }
#if defined OWN
    struct beginning beginning;
    begin_as_common(&beginning, (const uint64_t *)batch->beginnings + sample * OWN);
    batch->returned[sample] = whole_run(&beginning, common_calls, rows, batch->last, &never, &observer);
#else
    batch->returned[sample] = whole_run((const struct beginning *)batch->beginnings + sample, batch->calls, rows,
                                        batch->last, &never, &observer);
#endif
    batch->first.whole[sample] = whole;
}

#if defined __NVPTX__

__attribute__((device_kernel)) void maglev_samples(const struct batch *batch)
{
    const int64_t sample = (int64_t)__nvvm_read_ptx_sreg_ctaid_x() * __nvvm_read_ptx_sreg_ntid_x()
        + __nvvm_read_ptx_sreg_tid_x();
    if (sample < batch->samples) {
        run_sample(batch, sample);
    }
}

#else

__attribute__((visibility("default"))) void maglev_samples(const struct batch *batch);
void maglev_samples(const struct batch *batch)
{
    for (int64_t sample = 0; sample < batch->samples; ++sample) {
        run_sample(batch, sample);
    }
}

#endif
