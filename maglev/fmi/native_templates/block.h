/* @NAME@: its block, translated from Python. The file and line that a function comes from stand above it. */

#ifndef BLOCK_H
#define BLOCK_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* A product and a sum stay two roundings, as in Python; compilers without this pragma keep to it with -std=c99. */
#if defined(__clang__) || defined(_MSC_VER)
#pragma STDC FP_CONTRACT OFF
#endif

@STRUCTS@
@FUNCTIONS@
typedef struct @STRUCT@ Block;

static @INITIAL@
enum { FIRST_FAILURE = 1000000 };   /* status: this and the number, from 1 on, of the failure */

static const char *const FAILURES[] = {
@FAILURES@
};

@WRAPPERS@
#endif
