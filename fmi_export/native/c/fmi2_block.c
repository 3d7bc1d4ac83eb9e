/* FMI 2.0 for co-simulation over a block: instances, phases and steps. */

#include "instance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Share of a communication step by which the importer's clock may miss the end of the one before. */
#define CONTINUITY 1.0e-3

/* One of the importer's functions alone is no use: memory has to go back to where it came from. */
static bool manages_memory(const fmi2CallbackFunctions *callbacks)
{
    return callbacks->allocateMemory && callbacks->freeMemory;
}

void *allocate(const fmi2CallbackFunctions *callbacks, size_t size)
{
    return manages_memory(callbacks) ? callbacks->allocateMemory(1, size) : calloc(1, size);
}

void release(const fmi2CallbackFunctions *callbacks, void *memory)
{
    if (!manages_memory(callbacks)) {
        free(memory);
    } else if (memory) {
        callbacks->freeMemory(memory);
    }
}

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

static void renew(struct Instance *instance)
{
    memset(instance->block, 0, MODEL.block_size);   /* padding too, so that equal states are equal bytes */
    MODEL.construct(instance->block);
    instance->progress = (struct Progress){.phase = INSTANTIATED, .stale = true, .stop_time = INFINITY};
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
    const char *name = instanceName ? instanceName : "";
    /* Until there is an instance, this one does the talking. */
    struct Instance nobody = {.callbacks = *functions, .name = (char *)name};
    if (!*name) {
        refuse(&nobody, "instance name = '', expected one");
        return NULL;
    }
    if (fmuType != fmi2CoSimulation) {
        refuse(&nobody, "FMU type = %d, expected fmi2CoSimulation", (int)fmuType);
        return NULL;
    }
    if (!fmuGUID || strcmp(fmuGUID, MODEL.guid) != 0) {
        refuse(&nobody, "GUID = %s, expected %s: model description and binary are not of the same FMU",
               fmuGUID ? fmuGUID : "(none)", MODEL.guid);
        return NULL;
    }
    struct Instance *instance = allocate(functions, sizeof *instance);
    char *kept_name = allocate(functions, strlen(name) + 1);
    void *block = allocate(functions, MODEL.block_size);
    if (!instance || !kept_name || !block) {
        refuse(&nobody, "out of memory");
        release(functions, block);
        release(functions, kept_name);
        release(functions, instance);
        return NULL;
    }
    instance->callbacks = *functions;
    instance->name = strcpy(kept_name, name);
    instance->logging = loggingOn != fmi2False;
    instance->block = block;
    renew(instance);
    return instance;
}

void fmi2FreeInstance(fmi2Component c)
{
    struct Instance *instance = c;
    if (!instance) {
        return;
    }
    fmi2CallbackFunctions callbacks = instance->callbacks;
    release(&callbacks, instance->block);
    release(&callbacks, instance->name);
    release(&callbacks, instance);
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[])
{
    struct Instance *instance = c;
    if (!instance) {
        return fmi2Error;
    }
    bool discards = nCategories == 0;
    for (size_t i = 0; i < nCategories; ++i) {
        const char *category = categories && categories[i] ? categories[i] : "(none)";
        if (strcmp(category, "logAll") == 0 || strcmp(category, "logStatusDiscard") == 0) {
            discards = true;
        } else if (strcmp(category, "logStatusWarning") != 0 && strcmp(category, "logStatusError") != 0
                   && strcmp(category, "logStatusFatal") != 0) {
            return refuse(instance, "log category = %s, expected one of the model description", category);
        }
    }
    /* Errors are said in any case. On is: what is named is said; off: what is not named stays as it was. */
    instance->logging = loggingOn ? discards : instance->logging && !discards;
    return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance,
                               fmi2Real startTime, fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    struct Instance *instance = c;
    char text[NUMBER_LENGTH];
    (void)toleranceDefined;
    (void)tolerance;
    if (!allowed(instance, "fmi2SetupExperiment", INSTANTIATED)) {
        return fmi2Error;
    }
    if (!isfinite(startTime)) {
        return refuse(instance, "start time = %s s, expected a finite time", number(startTime, text));
    }
    instance->progress.timed = true;
    instance->progress.next_time = startTime;
    instance->progress.stop_time = stopTimeDefined ? stopTime : INFINITY;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    struct Instance *instance = c;
    if (!allowed(instance, "fmi2EnterInitializationMode", INSTANTIATED)) {
        return fmi2Error;
    }
    instance->progress.phase = INITIALIZING;
    return fmi2OK;
}

/* First input or parameter that is not a finite number within its range; NULL if there is none. */
static const struct Variable *out_of_range(const struct Instance *instance)
{
    for (size_t i = 0; i < MODEL.variable_count; ++i) {
        const struct Variable *variable = &MODEL.variables[i];
        if (variable->boolean || variable->causality == OUTPUT) {
            continue;
        }
        double value = *real_at(instance, variable);
        if (!(value >= variable->minimum && value <= variable->maximum && isfinite(value))) {
            return variable;
        }
    }
    return NULL;
}

static fmi2Status check_ranges(struct Instance *instance)
{
    const struct Variable *wrong = out_of_range(instance);
    if (wrong) {
        char value[NUMBER_LENGTH], minimum[NUMBER_LENGTH], maximum[NUMBER_LENGTH];
        const char *space = *wrong->unit ? " " : "";
        return refuse(instance, "%s = %s%s%s, expected a number from %s to %s%s%s%s", wrong->name,
                      number(*real_at(instance, wrong), value), space, wrong->unit, number(wrong->minimum, minimum),
                      number(wrong->maximum, maximum), space, wrong->unit, wrong->hint);
    }
    instance->progress.suspect = false;
    return fmi2OK;
}

/* Leave the instance as one that can only be reset, restored or freed. */
static fmi2Status fail(struct Instance *instance)
{
    instance->progress.phase = FAILED;
    return fmi2Error;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    struct Instance *instance = c;
    if (!allowed(instance, "fmi2ExitInitializationMode", INITIALIZING)) {
        return fmi2Error;
    }
    if (check_ranges(instance) != fmi2OK) {
        return fail(instance);
    }
    int64_t status = MODEL.start(instance->block);
    if (status != 0) {
        refuse_status(instance, status, 0.0, 0.0);
        return fail(instance);
    }
    instance->progress.stale = false;
    instance->progress.phase = RUNNING;
    return fmi2OK;
}

void refresh(struct Instance *instance)
{
    if (instance->progress.stale && !out_of_range(instance)) {
        MODEL.start(instance->block);
        instance->progress.stale = false;
    }
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    struct Instance *instance = c;
    char text[NUMBER_LENGTH], expected[NUMBER_LENGTH];
    double end = currentCommunicationPoint + communicationStepSize;
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!allowed(instance, "fmi2DoStep", RUNNING)) {
        return fmi2Error;
    }
    struct Progress *progress = &instance->progress;
    if (progress->suspect && check_ranges(instance) != fmi2OK) {
        return fail(instance);
    }
    if (!(communicationStepSize > 0.0 && isfinite(communicationStepSize))) {
        refuse(instance, "communication step = %s s, expected a positive, finite step",
               number(communicationStepSize, text));
        return fail(instance);
    }
    double tolerance = CONTINUITY * communicationStepSize + 1e-12 * fabs(progress->next_time);
    if (progress->timed && !(fabs(currentCommunicationPoint - progress->next_time) <= tolerance)) {
        refuse(instance, "communication point = %s s, expected %s s, where the step before ended",
               number(currentCommunicationPoint, text), number(progress->next_time, expected));
        return fail(instance);
    }
    if (end > progress->stop_time + tolerance) {   /* FMI 2.0.4, fmi2SetupExperiment: an error */
        refuse(instance, "communication step to %s s, expected none beyond the stop time, %s s", number(end, text),
               number(progress->stop_time, expected));
        return fail(instance);
    }
    int64_t status = MODEL.step(instance->block, currentCommunicationPoint, communicationStepSize);
    if (status != 0) {
        refuse_status(instance, status, currentCommunicationPoint, communicationStepSize);
        return fail(instance);
    }
    progress->timed = true;
    progress->next_time = end;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    struct Instance *instance = c;
    if (!allowed(instance, "fmi2Terminate", RUNNING)) {
        return fmi2Error;
    }
    instance->progress.phase = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    if (!c) {
        return fmi2Error;
    }
    renew(c);
    return fmi2OK;
}
