/* Functions of FMI 3.0 that this FMU does not support, as its model description says, and access to variables of types
 * that it does not have. */

#include "messages.h"
#include "variables.h"

#include "fmi3Functions.h"

/* The parameters are those of FMI, and only the instance is of use. */
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

#define NO_VARIABLES(type)                                                                                             \
    fmi3Status fmi3Get##type(fmi3Instance instance, const fmi3ValueReference valueReferences[],                        \
                             size_t nValueReferences, fmi3##type values[], size_t nValues)                             \
    {                                                                                                                  \
        return (fmi3Status)get_none(instance, "fmi3Get" #type, nValueReferences);                                      \
    }                                                                                                                  \
                                                                                                                       \
    fmi3Status fmi3Set##type(fmi3Instance instance, const fmi3ValueReference valueReferences[],                        \
                             size_t nValueReferences, const fmi3##type values[], size_t nValues)                       \
    {                                                                                                                  \
        return (fmi3Status)set_none(instance, "fmi3Set" #type, nValueReferences);                                      \
    }

NO_VARIABLES(Float32)
NO_VARIABLES(Int8)
NO_VARIABLES(UInt8)
NO_VARIABLES(Int16)
NO_VARIABLES(UInt16)
NO_VARIABLES(Int32)
NO_VARIABLES(UInt32)
NO_VARIABLES(Int64)
NO_VARIABLES(UInt64)
NO_VARIABLES(String)

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         size_t valueSizes[], fmi3Binary values[], size_t nValues)
{
    return (fmi3Status)get_none(instance, "fmi3GetBinary", nValueReferences);
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         const size_t valueSizes[], const fmi3Binary values[], size_t nValues)
{
    return (fmi3Status)set_none(instance, "fmi3SetBinary", nValueReferences);
}

#define ABSENT(function, ...)                                                                                          \
    fmi3Status fmi3##function(fmi3Instance instance, __VA_ARGS__)                                                      \
    {                                                                                                                  \
        return (fmi3Status)absent(instance, "fmi3" #function);                                                         \
    }

#define ABSENT_ALONE(function)                                                                                         \
    fmi3Status fmi3##function(fmi3Instance instance)                                                                   \
    {                                                                                                                  \
        return (fmi3Status)absent(instance, "fmi3" #function);                                                         \
    }

/* Derivatives of outputs by time, dependencies that change. */
ABSENT(GetOutputDerivatives, const fmi3ValueReference valueReferences[], size_t nValueReferences,
       const fmi3Int32 orders[], fmi3Float64 values[], size_t nValues)
ABSENT(GetNumberOfVariableDependencies, fmi3ValueReference valueReference, size_t *nDependencies)
ABSENT(GetVariableDependencies, fmi3ValueReference dependent, size_t elementIndicesOfDependent[],
       fmi3ValueReference independents[], size_t elementIndicesOfIndependents[], fmi3DependencyKind dependencyKinds[],
       size_t nDependencies)

/* Structural parameters. */
ABSENT_ALONE(EnterConfigurationMode)
ABSENT_ALONE(ExitConfigurationMode)

/* Events, and clocks in fractions. */
ABSENT_ALONE(EvaluateDiscreteStates)
ABSENT(GetIntervalFraction, const fmi3ValueReference valueReferences[], size_t nValueReferences,
       fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
ABSENT(GetShiftFraction, const fmi3ValueReference valueReferences[], size_t nValueReferences, fmi3UInt64 counters[],
       fmi3UInt64 resolutions[])

/* Scheduled execution. */
ABSENT(ActivateModelPartition, fmi3ValueReference clockReference, fmi3Float64 activationTime)

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String instanceName, fmi3String instantiationToken,
                                               fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                               fmi3InstanceEnvironment instanceEnvironment,
                                               fmi3LogMessageCallback logMessage, fmi3ClockUpdateCallback clockUpdate,
                                               fmi3LockPreemptionCallback lockPreemption,
                                               fmi3UnlockPreemptionCallback unlockPreemption)
{
    const struct Importer importer = {.environment = instanceEnvironment, .logger = (void (*)(void))logMessage};
    const struct Instance nobody = {.importer = importer};
    absent(&nobody, "fmi3InstantiateScheduledExecution");
    return NULL;
}

#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif
