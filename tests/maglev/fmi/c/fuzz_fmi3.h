/* FMI 3.0 under the names of FMI 2.0, for the fuzz driver: what both can do is tried in the same way. */

#ifndef FUZZ_FMI3_H
#define FUZZ_FMI3_H

#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>

#include "prefix.h"

#include "fmi3Functions.h"

#define fmi2Component fmi3Instance
#define fmi2FMUstate fmi3FMUState
#define fmi2ValueReference fmi3ValueReference
#define fmi2Boolean fmi3Boolean
#define fmi2Integer fmi3Int32
#define fmi2Real fmi3Float64
#define fmi2String fmi3String
#define fmi2Status fmi3Status
#define fmi2True fmi3True
#define fmi2False fmi3False
#define fmi2OK fmi3OK
#define fmi2Discard fmi3Discard
#define fmi2Error fmi3Error

#define fmi2FreeInstance fmi3FreeInstance
#define fmi2SetDebugLogging fmi3SetDebugLogging
#define fmi2ExitInitializationMode fmi3ExitInitializationMode
#define fmi2Terminate fmi3Terminate
#define fmi2Reset fmi3Reset
#define fmi2GetReal(instance, references, count, values) fmi3GetFloat64(instance, references, count, values, count)
#define fmi2SetReal(instance, references, count, values) fmi3SetFloat64(instance, references, count, values, count)
#define fmi2GetBoolean(instance, references, count, values) fmi3GetBoolean(instance, references, count, values, count)
#define fmi2SetBoolean(instance, references, count, values) fmi3SetBoolean(instance, references, count, values, count)
#define fmi2GetInteger(instance, references, count, values) fmi3GetInt32(instance, references, count, values, count)
#define fmi2SetInteger(instance, references, count, values) fmi3SetInt32(instance, references, count, values, count)
#define fmi2GetString(instance, references, count, values) fmi3GetString(instance, references, count, values, count)
#define fmi2SetString(instance, references, count, values) fmi3SetString(instance, references, count, values, count)
#define fmi2GetFMUstate fmi3GetFMUState
#define fmi2SetFMUstate fmi3SetFMUState
#define fmi2FreeFMUstate fmi3FreeFMUState
#define fmi2SerializedFMUstateSize fmi3SerializedFMUStateSize
#define fmi2SerializeFMUstate(instance, state, bytes, size) fmi3SerializeFMUState(instance, state, (fmi3Byte *)(bytes), size)
#define fmi2DeSerializeFMUstate(instance, bytes, size, state) \
    fmi3DeserializeFMUState(instance, (const fmi3Byte *)(bytes), size, state)

typedef enum { fmi2CoSimulation, fmi2ModelExchange } fmi2Type;

typedef struct {
    void (*logger)(void *environment, fmi3String instance, fmi3Status status, fmi3String category, fmi3String format,
                   ...);
    void *(*allocateMemory)(size_t count, size_t size);   /* FMI 3.0 does without these two */
    void (*freeMemory)(void *memory);
    void *componentEnvironment;
} fmi2CallbackFunctions;

static const fmi2CallbackFunctions *given;

static void pass_on(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message)
{
    given->logger(environment, "", status, category, "%s", message);
}

static fmi3Instance fmi2Instantiate(fmi3String name, fmi2Type type, fmi3String token, fmi3String resources,
                                    const fmi2CallbackFunctions *functions, fmi3Boolean visible, fmi3Boolean logging)
{
    if (!functions) {
        return fmi3InstantiateCoSimulation(name, "{another}", resources, visible, logging, false, false, NULL, 0, NULL,
                                           NULL, NULL);
    }
    given = functions;
    if (type == fmi2ModelExchange) {
        return fmi3InstantiateModelExchange(name, token, resources, visible, logging, functions->componentEnvironment,
                                            pass_on);
    }
    return fmi3InstantiateCoSimulation(name, token, resources, visible, logging, false, true, NULL, 0,
                                       functions->componentEnvironment, pass_on, NULL);
}

static fmi3Status fmi2DoStep(fmi3Instance instance, double time, double size, fmi3Boolean no_set_before)
{
    bool event = true, end = true, early = true;
    double last = -1.0;
    fmi3Status status = fmi3DoStep(instance, time, size, no_set_before, &event, &end, &early, &last);
    if (status == fmi3OK && (event || end || early || last != time + size)) {
        abort();
    }
    return status;
}

#endif
