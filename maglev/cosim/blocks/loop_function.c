/* A run as above; the instances stay at the first point. */
EXPORT int64_t maglev_whole_run(struct Instance *const *instances, const struct moved *calls, const void *const *rows,
                          int64_t last, const volatile int64_t *ended, struct observer *observer);
int64_t maglev_whole_run(struct Instance *const *instances, const struct moved *calls, const void *const *rows,
                   int64_t last, const volatile int64_t *ended, struct observer *observer)
{
    struct beginning beginning;
    return maglev_whole_run_begin(instances, rows, &beginning) == 0 ? RUN_REFUSED :
        whole_run(&beginning, calls, rows, last, ended, observer);
}
