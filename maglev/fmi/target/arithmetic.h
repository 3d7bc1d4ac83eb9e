/* Functions of a mathematical library that the blocks need, without the library: all else is +, -, *, / and comparisons.
 *
 * Compile without contraction of a product and a sum (-ffp-contract=off), without -ffast-math, and with -fno-math-errno
 * if the processor has a square root of doubles. Otherwise PORTABLE_ARITHMETIC computes it in integers, with the same
 * bits. */

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

#if !defined(PORTABLE_ARITHMETIC) && (!defined(__GNUC__) || (defined(__arm__) && !(__ARM_FP & 8)))
#define PORTABLE_ARITHMETIC
#endif

#ifndef PORTABLE_ARITHMETIC

#define fabs(x) __builtin_fabs(x)
#define sqrt(x) __builtin_sqrt(x)

#else

union Bits {
    double value;
    uint64_t bits;
};

static inline double fabs_of(double x)
{
    union Bits one = {.value = x};
    one.bits &= UINT64_MAX >> 1;
    return one.value;
}

/* Digit by digit: the 53 of the root and one more, by which it is rounded. */
static inline double sqrt_of(double x)
{
    union Bits one = {.value = x};
    if (!(x > 0.0) || one.bits == UINT64_C(0x7ff0000000000000)) {
        return x >= 0.0 || x != x ? x : (x - x) / (x - x);
    }
    int exponent = (int)(one.bits >> 52);
    uint64_t digits = one.bits & ((UINT64_C(1) << 52) - 1);
    if (exponent > 0) {
        digits |= UINT64_C(1) << 52;
    } else {
        for (exponent = 1; !(digits >> 52); --exponent) {
            digits <<= 1;
        }
    }
    exponent -= 1075;   /* x is digits times that power of two */
    if (exponent & 1) {
        digits <<= 1;
        exponent -= 1;
    }
    uint64_t root = 0, rest = 0;
    for (int place = 52; place >= -54; place -= 2) {
        rest = rest << 2 | (place >= 0 ? digits >> place & 3 : 0);
        uint64_t next = root << 2 | 1;
        root <<= 1;
        if (rest >= next) {
            rest -= next;
            root |= 1;
        }
    }
    one.bits = ((uint64_t)(exponent / 2 + 1049) << 52) + (((root >> 1) + (root & 1)) - (UINT64_C(1) << 52));
    return one.value;
}

#define fabs(x) fabs_of(x)
#define sqrt(x) sqrt_of(x)

#endif

#if defined(__GNUC__)
#define INFINITY __builtin_huge_val()
#define NAN __builtin_nan("")
#define isfinite(x) __builtin_isfinite(x)
#define isnan(x) __builtin_isnan(x)
#define isinf(x) __builtin_isinf(x)
#else
#define INFINITY (1e308 * 10.0)
#define NAN (INFINITY - INFINITY)
#define isfinite(x) ((x) - (x) == 0.0)
#define isnan(x) ((x) != (x))
#define isinf(x) (!isfinite(x) && !isnan(x))
#endif
