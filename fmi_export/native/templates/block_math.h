/* math.h with what C99 leaves out, for the translated blocks. Of its functions they call fabs, sqrt and isfinite: what
   processors have, and nothing of a mathematical library. */

#ifndef BLOCK_MATH_H
#define BLOCK_MATH_H

#include <math.h>

#ifndef M_PI
#define M_PI 3.14159265358979323846
#endif

/* A product and a sum stay two roundings, as in Python; compilers without this pragma keep to it with -std=c99. */
#if defined(__clang__) || defined(_MSC_VER)
#pragma STDC FP_CONTRACT OFF
#endif

/* Where blocks are one translation unit with what calls them, the compiler may make their functions part of their
   callers. */
#if defined BLOCKS_IN_ONE_UNIT
#define BLOCK_FUNCTION static __attribute__((unused))
#define SELDOM_CALLED static __attribute__((noinline, unused))
#else
#define BLOCK_FUNCTION
#define SELDOM_CALLED
#endif

#endif
