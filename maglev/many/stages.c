#include "instance.h"
#include "export.h"
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
$includes

/* The blocks of one stage. */
struct stage {
    $members
};

/* An input or a parameter of a stage, which is one of the list that is made with this. */
struct change {
    int64_t stage, what;
    double value;
};

/* The struct Batch of stages.py. */
struct batch {
    struct stage *stages;
    double *rows;                   /* of each stage as many numbers as the width, as compiled_stage.py says */
    int64_t width;
    int64_t *made;                  /* samples since an episode began */
    double step;                    /* s */
    int64_t samples;                /* to advance by */
    int64_t *refused, *at_stop;
    const struct change *changes;   /* to be made one after the other */
    int64_t changing;
};

/* Go on with a stage. One that refuses a command says so, and stays as it was. */
static inline void advance(const struct batch *batch, int64_t i)
{
    struct stage *const stage = &batch->stages[i];
    double *const row = batch->rows + i * batch->width;
    const double step = batch->step;
    const int64_t first = batch->made[i], last = first + batch->samples;
    bool wrong = $wrong;
    for (int64_t k = first; !wrong && k < last; ++k) {
        const double time = (double)k * step;
$step
    }
    batch->made[i] = last;
    batch->refused[i] = wrong;
    batch->at_stop[i] = $at_stop;
}

/* Give inputs and parameters other values. */
EXPORT void maglev_change(const struct batch *batch);
void maglev_change(const struct batch *batch)
{
    for (int64_t k = 0; k < batch->changing; ++k) {
        struct stage *const stage = &batch->stages[batch->changes[k].stage];
        const double value = batch->changes[k].value;
        switch (batch->changes[k].what) {
        $changes
        default: break;
        }
    }
}

EXPORT int64_t maglev_stage_size(void);
int64_t maglev_stage_size(void) { return (int64_t)sizeof(struct stage); }

/* Take over the blocks of instances that have just been started. */
EXPORT void maglev_take(struct Instance *const *instances, struct stage *stage);
void maglev_take(struct Instance *const *instances, struct stage *stage)
{
    $take
}

/* Go on with stages first to before last. */
EXPORT void maglev_advance(const struct batch *batch, int64_t first, int64_t last);
void maglev_advance(const struct batch *batch, int64_t first, int64_t last)
{
    for (int64_t i = first; i < last; ++i) {
        advance(batch, i);
    }
}
