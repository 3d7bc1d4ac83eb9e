/* The run of run.h, on any processor that has a C compiler: writes its digest.

   A digest is FNV-1a, 64 bits, over the bytes of the numbers, the lowest first, whatever their order in memory. */

#include <stdint.h>

#if __STDC_HOSTED__
#include <inttypes.h>
#include <stdio.h>
#endif

#define EMPTY_DIGEST UINT64_C(14695981039346656037)

static uint64_t taken(uint64_t digest, double value)
{
    union {
        double value;
        uint64_t bits;
    } one = {.value = value};
    for (int shift = 0; shift < 64; shift += 8) {
        digest = (digest ^ (one.bits >> shift & 0xFF)) * UINT64_C(1099511628211);
    }
    return digest;
}

#include "run.h"

#ifdef __wasm__

/* The same for whom a module cannot write to. */
__attribute__((visibility("default"))) uint64_t digest_of_run(void);

uint64_t digest_of_run(void)
{
    return run();
}

#elif __STDC_HOSTED__

int main(void)
{
    printf("%016" PRIx64 "\n", run());
    return 0;
}

#else

#include "bare.h"

#endif
