#include "instance.h"
#include "whole_run.h"
#include "export.h"

/* Whether an instance would take a step of co-simulation as it is. */
static bool ready(const struct Progress *progress)
{
    return progress->phase == RUNNING && !progress->exchange && !progress->events && !progress->suspect;
}

/* Write what a run begins with, of instances and first rows, if there is where; returns its bytes, 0 where an FMU would
   refuse a step. */
EXPORT int64_t maglev_whole_run_begin(struct Instance *const *instances, const void *const *rows,
                                struct beginning *beginning);
int64_t maglev_whole_run_begin(struct Instance *const *instances, const void *const *rows,
                         struct beginning *beginning)
{
    if (beginning) {
        if ($ready) {
            return 0;
        }
$copy
    }
    return sizeof *beginning;
}
