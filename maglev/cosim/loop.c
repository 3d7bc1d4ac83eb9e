#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include "instance.h"
#include "export.h"
#include "run.h"
$includes

$observer

/* All steps to communication point `last`, on copies of the blocks: the instances stay at the first point. Of a track of
   outputs, `rows` has the first row; of one of signals, the values of one after the other at all points. Returns
   RUN_REFUSED where an FMU would refuse something, RUN_ENDED as soon as somebody says so. */
EXPORT int64_t maglev_whole_run(struct Instance *const *instances, const struct moved *calls, const void *const *rows,
                          int64_t last, const volatile int64_t *ended, struct observer *observer);
int64_t maglev_whole_run(struct Instance *const *instances, const struct moved *calls, const void *const *rows,
                   int64_t last, const volatile int64_t *ended, struct observer *observer)
{
    if ($not_ready) {
        return RUN_REFUSED;
    }
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
