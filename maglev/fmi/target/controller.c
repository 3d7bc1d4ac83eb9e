/* @NAME@: see @NAME@.h. */

#include "@NAME@.h"

@ARITHMETIC@
@FUNCTIONS@
@INITIAL@
void @NAME@_init(struct @NAME@ *self)
{
    self->block = INITIAL;
    self->samples = 0.0;
}

int32_t @NAME@_start(struct @NAME@ *self)
{
    struct @STRUCT@ *block = &self->block;
    int64_t failure = 0;
@CHECKED_PARAMETERS@
    int32_t status = (int32_t)@START@;
    if (failure != 0 || status != 0) {
        return failure != 0 ? (int32_t)(@FAILED@ + failure) : status;
    }
@FINITE@    return 0;
}

int32_t @NAME@_sample(struct @NAME@ *self,
                @SPACE@const struct @NAME@_inputs *inputs,
                @SPACE@struct @NAME@_outputs *outputs)
{
    struct @STRUCT@ *block = &self->block;
    int64_t failure = 0;
@CHECKED_INPUTS@
@TAKEN@
    double step = block->@SAMPLE_TIME@;
    int32_t status = (int32_t)@STEP@;
    if (failure != 0 || status != 0) {
        return failure != 0 ? (int32_t)(@FAILED@ + failure) : status;
    }
@FINITE@    self->samples += 1.0;
@GIVEN@
    return 0;
}
