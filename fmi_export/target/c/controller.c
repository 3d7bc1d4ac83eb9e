/* @NAME@: see @NAME@.h. */

#include "@NAME@.h"

@ARITHMETIC@
@CONSTANTS@
@FUNCTIONS@
void @NAME@_init(struct @NAME@ *self)
{
    @BLOCK@__init__(@ARGUMENTS@);
    self->samples = 0.0;
}

int32_t @NAME@_start(struct @NAME@ *self)
{
    struct @NAME@_block *block = &self->block;
@CHECKED_PARAMETERS@
    return (int32_t)@BLOCK@__start(block);
}

int32_t @NAME@_sample(struct @NAME@ *self,
                @SPACE@const struct @NAME@_inputs *inputs,
                @SPACE@struct @NAME@_outputs *outputs)
{
    struct @NAME@_block *block = &self->block;
@CHECKED_INPUTS@
@TAKEN@
    double step = block->@SAMPLE_TIME@;
    int32_t status = (int32_t)@BLOCK@__step(block, self->samples * step, step);
    if (status != 0) {
        return status;
    }
    self->samples += 1.0;
@GIVEN@
    return 0;
}
