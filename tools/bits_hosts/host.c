/* The run of run.h, on any processor that has a C compiler: writes its digest.

   A digest is FNV-1a, 64 bits, over the bytes of the numbers, the lowest first, whatever their order in memory. */

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define EMPTY_DIGEST UINT64_C(14695981039346656037)

static uint64_t taken(uint64_t digest, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    for (int shift = 0; shift < 64; shift += 8) {
        digest = (digest ^ (bits >> shift & 0xFF)) * UINT64_C(1099511628211);
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

#else

int main(void)
{
    printf("%016" PRIx64 "\n", run());
    return 0;
}

#endif
