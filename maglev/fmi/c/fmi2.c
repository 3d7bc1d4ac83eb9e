/* FMI 2.0: its functions over an instance; those of model exchange are in fmi2_exchange.c. */

#include "life.h"
#include "messages.h"
#include "state.h"
#include "variables.h"

#include <math.h>

#include "fmi2Functions.h"

void tell(const struct Instance *instance, enum Status status, const char *category, const char *message)
{
    fmi2CallbackLogger logger = (fmi2CallbackLogger)instance->importer.logger;
    /* The message is no format: it may have a per cent sign in it. */
    logger(instance->importer.environment, instance->name, (fmi2Status)status, category, "%s", message);
}

const char *phase_name(enum Phase phase)
{
    switch (phase) {
    case INSTANTIATED: return "before fmi2EnterInitializationMode";
    case INITIALIZING: return "in the initialization";
    case RUNNING: return "after the initialization";
    case TERMINATED: return "after fmi2Terminate";
    case AT_EVENT: return "in event mode";
    case BETWEEN_EVENTS: return "in continuous-time mode";
    default: return "after an error";
    }
}

const char *real_type(void)
{
    return "Real";
}

int readable_phases(void)
{
    return INITIALIZING | RUNNING | AT_EVENT | BETWEEN_EVENTS | TERMINATED | FAILED;
}

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn)
{
    (void)fmuResourceLocation;
    (void)visible;
    if (!functions) {
        return NULL;
    }
    struct Importer importer = {functions->componentEnvironment, (void (*)(void))functions->logger,
                                functions->allocateMemory, functions->freeMemory};
    if (instanceName && *instanceName && fmuType != fmi2CoSimulation && fmuType != fmi2ModelExchange) {
        struct Instance nobody = {.importer = importer, .name = (char *)instanceName};
        refuse(&nobody, "FMU type = %d, expected fmi2CoSimulation or fmi2ModelExchange", (int)fmuType);
        return NULL;
    }
    return created(&importer, instanceName, fmuType == fmi2ModelExchange, loggingOn != fmi2False, "GUID", fmuGUID);
}

void fmi2FreeInstance(fmi2Component c)
{
    freed(c);
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[])
{
    return (fmi2Status)set_logging(c, loggingOn != fmi2False, nCategories, categories);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance,
                               fmi2Real startTime, fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    (void)toleranceDefined;
    (void)tolerance;
    return (fmi2Status)set_times(c, "fmi2SetupExperiment", startTime, stopTimeDefined ? stopTime : INFINITY);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    return (fmi2Status)enter_initialization(c, "fmi2EnterInitializationMode");
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    return (fmi2Status)exit_initialization(c, "fmi2ExitInitializationMode");
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    return (fmi2Status)take_step(c, "fmi2DoStep", currentCommunicationPoint, communicationStepSize);
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    return (fmi2Status)end_run(c, "fmi2Terminate");
}

fmi2Status fmi2Reset(fmi2Component c)
{
    return (fmi2Status)begin_anew(c);
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[])
{
    return (fmi2Status)get_reals(c, "fmi2GetReal", vr, nvr, value);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[])
{
    return (fmi2Status)set_reals(c, "fmi2SetReal", vr, nvr, value);
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Boolean value[])
{
    if (!booleans_readable(c, "fmi2GetBoolean", vr, nvr, value)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < nvr; ++i) {
        value[i] = *boolean_at(c, &MODEL.variables[vr[i]]) ? fmi2True : fmi2False;
    }
    return fmi2OK;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Boolean value[])
{
    if (!booleans_settable(c, "fmi2SetBoolean", vr, nvr, value)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < nvr; ++i) {
        *boolean_at(c, &MODEL.variables[vr[i]]) = value[i] != fmi2False;
    }
    return fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    return (fmi2Status)save_state(c, "fmi2GetFMUstate", FMUstate);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate)
{
    return (fmi2Status)restore_state(c, "fmi2SetFMUstate", FMUstate);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    return (fmi2Status)free_state(c, FMUstate);
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size)
{
    return (fmi2Status)serialized_size(c, "fmi2SerializedFMUstateSize", FMUstate, size);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[], size_t size)
{
    return (fmi2Status)serialize(c, "fmi2SerializeFMUstate", FMUstate, serializedState, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate *FMUstate)
{
    return (fmi2Status)deserialize(c, "fmi2DeSerializeFMUstate", serializedState, size, FMUstate);
}
