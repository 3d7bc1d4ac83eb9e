/* FMI 3.0 for model exchange, and derivatives: its functions over an instance. */

#include "exchange.h"
#include "life.h"
#include "messages.h"

#include "fmi3Functions.h"

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage)
{
    (void)resourcePath;
    (void)visible;
    const struct Importer importer = {.environment = instanceEnvironment, .logger = (void (*)(void))logMessage};
    return created(&importer, instanceName, true, loggingOn, "instantiation token", instantiationToken);
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi3Boolean *enterEventMode, fmi3Boolean *terminateSimulation)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!enterEventMode || !terminateSimulation) {
        return (fmi3Status)refuse(instance, "fmi3CompletedIntegratorStep with a null pointer, expected places for its "
                                  "results");
    }
    *terminateSimulation = false;
    return (fmi3Status)complete_step(instance, "fmi3CompletedIntegratorStep", enterEventMode);
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    return (fmi3Status)set_time(instance, "fmi3SetTime", time);
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 continuousStates[],
                                   size_t nContinuousStates)
{
    return (fmi3Status)set_states(instance, "fmi3SetContinuousStates", continuousStates, nContinuousStates);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[],
                                             size_t nContinuousStates)
{
    return (fmi3Status)get_rates(instance, "fmi3GetContinuousStateDerivatives", derivatives, nContinuousStates);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 eventIndicators[], size_t nEventIndicators)
{
    return (fmi3Status)get_indicators(instance, "fmi3GetEventIndicators", eventIndicators, nEventIndicators);
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 continuousStates[], size_t nContinuousStates)
{
    return (fmi3Status)get_states(instance, "fmi3GetContinuousStates", continuousStates, nContinuousStates);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t nContinuousStates)
{
    return (fmi3Status)get_nominals(instance, "fmi3GetNominalsOfContinuousStates", nominals, nContinuousStates);
}

/* How many there are of something. */
static fmi3Status counted(const struct Instance *instance, const char *call, size_t count, size_t *place)
{
    if (!instance || !instance->exchange) {
        return (fmi3Status)absent(instance, call);
    }
    if (!place) {
        return (fmi3Status)refuse(instance, "%s with a null pointer, expected a place for the number", call);
    }
    *place = count;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *nEventIndicators)
{
    return counted(instance, "fmi3GetNumberOfEventIndicators",
                   MODEL.continuous ? MODEL.continuous->indicator_count : 0, nEventIndicators);
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *nContinuousStates)
{
    return counted(instance, "fmi3GetNumberOfContinuousStates",
                   MODEL.continuous ? MODEL.continuous->state_count : 0, nContinuousStates);
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                        const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                        size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
{
    if (nSeed != nKnowns || nSensitivity != nUnknowns) {
        return (fmi3Status)refuse(instance, "fmi3GetDirectionalDerivative of %u unknowns by %u knowns with %u and %u "
                                  "values, expected one for each", (unsigned)nUnknowns, (unsigned)nKnowns,
                                  (unsigned)nSensitivity, (unsigned)nSeed);
    }
    return (fmi3Status)differentiate(instance, "fmi3GetDirectionalDerivative", unknowns, nUnknowns, knowns, nKnowns,
                                     seed, sensitivity);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                    const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                    size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
{
    if (nSeed != nUnknowns || nSensitivity != nKnowns) {
        return (fmi3Status)refuse(instance, "fmi3GetAdjointDerivative of %u unknowns by %u knowns with %u and %u values, "
                                  "expected one for each", (unsigned)nUnknowns, (unsigned)nKnowns, (unsigned)nSeed,
                                  (unsigned)nSensitivity);
    }
    return (fmi3Status)differentiate_adjoint(instance, "fmi3GetAdjointDerivative", unknowns, nUnknowns, knowns, nKnowns,
                                             seed, sensitivity);
}
