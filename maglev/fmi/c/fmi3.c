/* FMI 3.0: its functions over an instance; those of model exchange are in fmi3_exchange.c. */

#include "life.h"
#include "messages.h"
#include "outputs.h"
#include "state.h"
#include "variables.h"

#include <math.h>

#include "fmi3Functions.h"

void tell(const struct Instance *instance, enum Status status, const char *category, const char *message)
{
    fmi3LogMessageCallback logger = (fmi3LogMessageCallback)instance->importer.logger;
    logger(instance->importer.environment, (fmi3Status)status, category, message);
}

const char *phase_name(enum Phase phase)
{
    switch (phase) {
    case INSTANTIATED: return "before fmi3EnterInitializationMode";
    case INITIALIZING: return "in the initialization";
    case RUNNING: return "in step mode";
    case TERMINATED: return "after fmi3Terminate";
    case AT_EVENT: return "in event mode";
    case BETWEEN_EVENTS: return "in continuous-time mode";
    default: return "after an error";
    }
}

const char *real_type(void)
{
    return "Float64";
}

int readable_phases(void)
{
    return INSTANTIATED | INITIALIZING | RUNNING | AT_EVENT | BETWEEN_EVENTS | TERMINATED | FAILED;   /* start values too */
}

const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken,
                                         fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                         fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference requiredIntermediateVariables[],
                                         size_t nRequiredIntermediateVariables,
                                         fmi3InstanceEnvironment instanceEnvironment,
                                         fmi3LogMessageCallback logMessage,
                                         fmi3IntermediateUpdateCallback intermediateUpdate)
{
    (void)resourcePath;
    (void)visible;
    (void)requiredIntermediateVariables;
    (void)intermediateUpdate;
    const struct Importer importer = {.environment = instanceEnvironment, .logger = (void (*)(void))logMessage};
    const struct Instance nobody = {.importer = importer};
    if (eventModeUsed && !MODEL.sampling) {
        refuse(&nobody, "eventModeUsed = true, expected false: the model description says that this FMU has no event mode");
        return NULL;
    }
    if (!eventModeUsed && MODEL.sampling && MODEL.sampling->clocked) {
        refuse(&nobody, "eventModeUsed = false, expected true: this FMU has a clock");
        return NULL;
    }
    if (nRequiredIntermediateVariables > 0) {
        refuse(&nobody, "%u intermediate variables required, expected 0: the model description has none",
               (unsigned)nRequiredIntermediateVariables);
        return NULL;
    }
    struct Instance *instance = created(&importer, instanceName, false, loggingOn, "instantiation token",
                                        instantiationToken);
    if (instance && eventModeUsed) {
        use_events(instance, earlyReturnAllowed);
    }
    return instance;
}

void fmi3FreeInstance(fmi3Instance instance)
{
    freed(instance);
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[])
{
    return (fmi3Status)set_logging(instance, loggingOn, nCategories, categories);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 startTime, fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{
    static const char *const CALL = "fmi3EnterInitializationMode";
    (void)toleranceDefined;
    (void)tolerance;
    enum Status status = set_times(instance, CALL, startTime, stopTimeDefined ? stopTime : INFINITY);
    return (fmi3Status)(status == DONE ? enter_initialization(instance, CALL) : status);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    return (fmi3Status)exit_initialization(instance, "fmi3ExitInitializationMode");
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *eventHandlingNeeded,
                      fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!eventHandlingNeeded || !terminateSimulation || !earlyReturn || !lastSuccessfulTime) {
        return (fmi3Status)refuse(instance, "fmi3DoStep with a null pointer, expected places for its results");
    }
    const struct Instance *self = instance;
    enum Status status = take_step(instance, "fmi3DoStep", currentCommunicationPoint, communicationStepSize);
    *eventHandlingNeeded = false;
    *terminateSimulation = false;
    *earlyReturn = false;
    if (self) {
        *lastSuccessfulTime = self->state->progress.next_time;
        if (status == DONE && self->events) {
            *earlyReturn = *lastSuccessfulTime < currentCommunicationPoint + communicationStepSize;
            *eventHandlingNeeded = !MODEL.sampling->clocked && sample_due(self);
        }
    }
    return (fmi3Status)status;
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    return (fmi3Status)end_run(instance, "fmi3Terminate");
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    return (fmi3Status)begin_anew(instance);
}

/* Return the number of values of a variable; those of an array belong to its reference and the next ones. */
static uint32_t size_of(fmi3ValueReference reference)
{
    return MODEL.sizes && reference < MODEL.variable_count ? MODEL.sizes[reference] : 1;
}

/* Let `scalars` be a reference for each value of variables: the same ones without arrays, else memory to release. False,
 * and the reason logged, if that are not as many as values are given. */
static bool spread(const struct Instance *instance, const char *call, const fmi3ValueReference references[], size_t count,
                   size_t values, const uint32_t **scalars)
{
    size_t needed = 0;
    for (size_t i = 0; i < count; ++i) {
        needed += references ? size_of(references[i]) : 1;
    }
    if (needed != values) {
        refuse(instance, "%s of %u variables with %u values, expected %u", call, (unsigned)count, (unsigned)values,
               (unsigned)needed);
        return false;
    }
    *scalars = references;
    if (needed == count || !instance) {
        return true;
    }
    uint32_t *next = allocate(&instance->importer, needed * sizeof *next);
    *scalars = next;
    for (size_t i = 0; next && i < count; ++i) {
        for (uint32_t k = 0; k < size_of(references[i]); ++k) {
            *next++ = references[i] + k;
        }
    }
    if (!*scalars) {
        refuse(instance, "out of memory");
    }
    return *scalars;
}

/* Release what `spread` has allocated. */
static fmi3Status settled(const struct Instance *instance, const fmi3ValueReference references[],
                          const uint32_t *scalars, enum Status status)
{
    if (scalars != references) {
        release(&instance->importer, (void *)scalars);
    }
    return (fmi3Status)status;
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Float64 values[], size_t nValues)
{
    const uint32_t *scalars;
    if (!spread(instance, "fmi3GetFloat64", valueReferences, nValueReferences, nValues, &scalars)) {
        return fmi3Error;
    }
    const enum Status status = get_reals(instance, "fmi3GetFloat64", scalars, nValues, values);
    return settled(instance, valueReferences, scalars, status);
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Float64 values[], size_t nValues)
{
    const uint32_t *scalars;
    if (!spread(instance, "fmi3SetFloat64", valueReferences, nValueReferences, nValues, &scalars)) {
        return fmi3Error;
    }
    const enum Status status = set_reals(instance, "fmi3SetFloat64", scalars, nValues, values);
    return settled(instance, valueReferences, scalars, status);
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Boolean values[], size_t nValues)
{
    const uint32_t *scalars;
    if (!spread(instance, "fmi3GetBoolean", valueReferences, nValueReferences, nValues, &scalars)) {
        return fmi3Error;
    }
    const bool able = booleans_readable(instance, "fmi3GetBoolean", scalars, nValues, values);
    for (size_t i = 0; able && i < nValues; ++i) {
        values[i] = *boolean_at(instance, &MODEL.variables[scalars[i]]);
    }
    return settled(instance, valueReferences, scalars, able ? DONE : REFUSED);
}

fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Boolean values[], size_t nValues)
{
    const uint32_t *scalars;
    if (!spread(instance, "fmi3SetBoolean", valueReferences, nValueReferences, nValues, &scalars)) {
        return fmi3Error;
    }
    const bool able = booleans_settable(instance, "fmi3SetBoolean", scalars, nValues, values);
    for (size_t i = 0; able && i < nValues; ++i) {
        *boolean_at(instance, &MODEL.variables[scalars[i]]) = values[i];
    }
    return settled(instance, valueReferences, scalars, able ? DONE : REFUSED);
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    return (fmi3Status)save_state(instance, "fmi3GetFMUState", FMUState);
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState)
{
    return (fmi3Status)restore_state(instance, "fmi3SetFMUState", FMUState);
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    return (fmi3Status)free_state(instance, FMUState);
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState, size_t *size)
{
    return (fmi3Status)serialized_size(instance, "fmi3SerializedFMUStateSize", FMUState, size);
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState, fmi3Byte serializedState[], size_t size)
{
    return (fmi3Status)serialize(instance, "fmi3SerializeFMUState", FMUState, serializedState, size);
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte serializedState[], size_t size,
                                   fmi3FMUState *FMUState)
{
    return (fmi3Status)deserialize(instance, "fmi3DeserializeFMUState", serializedState, size, FMUState);
}
