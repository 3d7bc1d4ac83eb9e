/* @NAME@: the block, its variables and its refusals. Generated from the table that the model description is made of. */

#include "instance.h"
#include "@HEADER@"
@MORE_HEADERS@
static void construct(void *block)
{
    @BLOCK@__init__(@ARGUMENTS@);
}

static int64_t start(void *block)
{
    return @BLOCK@__start(block);
}

static int64_t step(void *block, double time, double size)
{
    return @BLOCK@__step(block, time, size);
}

#define AT(path) (offsetof(struct RunState, block) + offsetof(struct @BLOCK@, path))

static const struct Variable VARIABLES[] = {
@VARIABLES@
};

static const struct Refusal REFUSALS[] = {
@REFUSALS@
};

@CONTINUOUS_TABLES@@SAMPLING_TABLE@const struct Model MODEL = {
    .name = @NAME_TEXT@,
    .guid = @GUID@,
    .block_size = sizeof(struct @BLOCK@),
    .construct = construct,
    .start = start,
    .step = step,
    .variables = VARIABLES,
    .variable_count = sizeof VARIABLES / sizeof *VARIABLES,
    .refusals = REFUSALS,
    .refusal_count = sizeof REFUSALS / sizeof *REFUSALS,
    .continuous = @CONTINUOUS@,
    .variable_step = @VARIABLE_STEP@,
    .interval = @INTERVAL@,
    .sampling = @SAMPLING@,
};
