/* @NAME@: the block, its variables and its refusals. Generated from the table that the model description is made of. */

#include "instance.h"
#include "block.h"

#define AT(path) (offsetof(struct RunState, block) + offsetof(Block, path))

static const struct Variable VARIABLES[] = {
@VARIABLES@
};

static const struct Refusal REFUSALS[] = {
@REFUSALS@
};

@SIZES_TABLE@@CONTINUOUS_TABLES@@SAMPLING_TABLE@const struct Model MODEL = {
    .name = @NAME_TEXT@,
    .guid = @GUID@,
    .block_size = sizeof(Block),
    .initial = &INITIAL,
    .start = start_block,
    .step = step_block,
    .variables = VARIABLES,
    .variable_count = sizeof VARIABLES / sizeof *VARIABLES,
    .sizes = @SIZES@,
    .refusals = REFUSALS,
    .refusal_count = sizeof REFUSALS / sizeof *REFUSALS,
    .failed = FIRST_FAILURE,
    .failures = FAILURES,
    .failure_count = sizeof FAILURES / sizeof *FAILURES,
    .continuous = @CONTINUOUS@,
    .variable_step = @VARIABLE_STEP@,
    .interval = @INTERVAL@,
    .sampling = @SAMPLING@,
};
