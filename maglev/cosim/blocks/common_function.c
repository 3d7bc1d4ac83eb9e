$common
/* The same with what runs have in common as constants; RUN_OTHERWISE where a run has it otherwise. */
EXPORT int64_t maglev_whole_run(struct Instance *const *instances, const struct moved *calls, const void *const *rows,
                          int64_t last, const volatile int64_t *ended, struct observer *observer);
int64_t maglev_whole_run(struct Instance *const *instances, const struct moved *calls, const void *const *rows,
                   int64_t last, const volatile int64_t *ended, struct observer *observer)
{
    struct beginning given, beginning;
    uint64_t own[OWN];
    (void)calls;
    __builtin_memset(&given, 0, sizeof given);
    if (maglev_whole_run_begin(instances, rows, &given) == 0) {
        return RUN_REFUSED;
    }
    if (!own_of(&given, own)) {
        return RUN_OTHERWISE;
    }
    begin_as_common(&beginning, own);
    return whole_run(&beginning, common_calls, rows, last, ended, observer);
}
