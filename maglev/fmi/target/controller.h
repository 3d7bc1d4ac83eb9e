/*
@ABOUT@
 */

#ifndef @GUARD@
#define @GUARD@

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

struct @NAME@_inputs {
@INPUTS@
};

struct @NAME@_outputs {
@OUTPUTS@
};

struct @NAME@;

void @NAME@_init(struct @NAME@ *self);
int32_t @NAME@_start(struct @NAME@ *self);
int32_t @NAME@_sample(struct @NAME@ *self,
                @SPACE@const struct @NAME@_inputs *inputs,
                @SPACE@struct @NAME@_outputs *outputs);

/* Parameters, by the number of the variable, which counts from 0 with the inputs and outputs before:
 *
@PARAMETERS@
 *
 * Statuses:
 *
@STATUSES@
 */

/* -- What is within. -- */

@STRUCTS@
struct @NAME@ {
    struct @STRUCT@ block;
    double samples;
};

#ifdef __cplusplus
}
#endif

#endif
