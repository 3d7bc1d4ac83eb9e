/* An FMU of FMI 3.0 with numbers of every type and arrays: each output is the input of its type, those of arrays in the
 * other order; the temperature is that of the parameter. */

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"

enum { SIZE = 3, MOST = 200 };

typedef union {
    double real[SIZE];
    float single[SIZE];
    int64_t whole[SIZE];
    uint8_t bytes[8 * SIZE];
} Value;

typedef struct {
    Value values[MOST];
} Typed;

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference intermediate[], size_t n, fmi3InstanceEnvironment of,
                                         fmi3LogMessageCallback logger, fmi3IntermediateUpdateCallback update) {
    (void)name; (void)token; (void)resources; (void)visible; (void)logging; (void)events; (void)early;
    (void)intermediate; (void)n; (void)of; (void)logger; (void)update;
    return calloc(1, sizeof(Typed));
}

void fmi3FreeInstance(fmi3Instance f) { free(f); }
fmi3Status fmi3Reset(fmi3Instance f) { memset(f, 0, sizeof(Typed)); return fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance f) { (void)f; return fmi3OK; }
fmi3Status fmi3ExitInitializationMode(fmi3Instance f) { (void)f; return fmi3OK; }

fmi3Status fmi3EnterInitializationMode(fmi3Instance f, fmi3Boolean tolerant, fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean stops, fmi3Float64 stop) {
    (void)f; (void)tolerant; (void)tolerance; (void)start; (void)stops; (void)stop;
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance f, fmi3Float64 time, fmi3Float64 step, fmi3Boolean keep, fmi3Boolean *event,
                      fmi3Boolean *ends, fmi3Boolean *early, fmi3Float64 *last) {
    (void)f; (void)keep;
    *event = *ends = *early = false;
    *last = time + step;
    return fmi3OK;
}

/* Value references are even for inputs, and one more for their outputs; from 100 on arrays of three. */
#define ACCESS(GET, SET, TYPE)                                                                                         \
    fmi3Status SET(fmi3Instance f, const fmi3ValueReference vr[], size_t n, const TYPE value[], size_t count) {        \
        size_t at = 0;                                                                                                 \
        for (size_t i = 0; i < n; i++) {                                                                               \
            TYPE *own = (TYPE *)&((Typed *)f)->values[vr[i] & ~1u];                                                    \
            for (size_t k = 0; k < (vr[i] < 100 ? 1 : SIZE); k++) own[k] = value[at++];                                \
        }                                                                                                              \
        return at == count ? fmi3OK : fmi3Error;                                                                       \
    }                                                                                                                  \
    fmi3Status GET(fmi3Instance f, const fmi3ValueReference vr[], size_t n, TYPE value[], size_t count) {              \
        size_t at = 0;                                                                                                 \
        for (size_t i = 0; i < n; i++) {                                                                               \
            const TYPE *own = (const TYPE *)&((Typed *)f)->values[vr[i] & ~1u];                                        \
            const size_t size = vr[i] < 100 ? 1 : SIZE;                                                                \
            for (size_t k = 0; k < size; k++) value[at++] = own[vr[i] % 2 ? size - 1 - k : k];                         \
        }                                                                                                              \
        return at == count ? fmi3OK : fmi3Error;                                                                       \
    }

ACCESS(fmi3GetFloat64, fmi3SetFloat64, fmi3Float64)
ACCESS(fmi3GetFloat32, fmi3SetFloat32, fmi3Float32)
ACCESS(fmi3GetBoolean, fmi3SetBoolean, fmi3Boolean)
ACCESS(fmi3GetInt8, fmi3SetInt8, fmi3Int8)
ACCESS(fmi3GetInt16, fmi3SetInt16, fmi3Int16)
ACCESS(fmi3GetInt32, fmi3SetInt32, fmi3Int32)
ACCESS(fmi3GetInt64, fmi3SetInt64, fmi3Int64)
ACCESS(fmi3GetUInt8, fmi3SetUInt8, fmi3UInt8)
ACCESS(fmi3GetUInt16, fmi3SetUInt16, fmi3UInt16)
ACCESS(fmi3GetUInt32, fmi3SetUInt32, fmi3UInt32)
ACCESS(fmi3GetUInt64, fmi3SetUInt64, fmi3UInt64)
