/* Access to the variables, by their places in the table; this FMU has Real and Boolean ones. */

#include "instance.h"

static const int READABLE = INITIALIZING | RUNNING | TERMINATED | FAILED;
static const int WRITABLE = INSTANTIATED | INITIALIZING | RUNNING;

/* The variable of a reference and type; NULL, and a message, if there is none. */
static const struct Variable *variable_of(const struct Instance *instance, fmi2ValueReference reference, bool boolean)
{
    if (reference >= MODEL.variable_count) {
        refuse(instance, "value reference = %u, expected 0 to %u", (unsigned)reference,
               (unsigned)(MODEL.variable_count - 1));
        return NULL;
    }
    const struct Variable *variable = &MODEL.variables[reference];
    if (variable->boolean != boolean) {
        refuse(instance, "%s is a %s variable, expected access to it as such", variable->name,
               variable->boolean ? "Boolean" : "Real");
        return NULL;
    }
    return variable;
}

/* Whether a call with so many references and values can be carried out; says why if it cannot. */
static bool callable(const struct Instance *instance, const char *call, int phases, const void *references,
                     size_t count, const void *values)
{
    if (!allowed(instance, call, phases)) {
        return false;
    }
    if (count > 0 && (!references || !values)) {
        refuse(instance, "%s of %u variables with a null pointer, expected arrays", call, (unsigned)count);
        return false;
    }
    return true;
}

/* The variable of a reference, if it can be set now. */
static const struct Variable *settable(const struct Instance *instance, fmi2ValueReference reference, bool boolean)
{
    const struct Variable *variable = variable_of(instance, reference, boolean);
    if (!variable) {
        return NULL;
    }
    if (variable->causality == OUTPUT) {
        refuse(instance, "%s is an output, expected an input or a parameter to set", variable->name);
        return NULL;
    }
    if (variable->fixed && instance->progress.phase == RUNNING) {
        refuse(instance, "%s is a fixed parameter, expected to be set before the initialization ends", variable->name);
        return NULL;
    }
    return variable;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[])
{
    struct Instance *instance = c;
    if (!callable(instance, "fmi2GetReal", READABLE, vr, nvr, value)) {
        return fmi2Error;
    }
    refresh(instance);
    for (size_t i = 0; i < nvr; ++i) {
        const struct Variable *variable = variable_of(instance, vr[i], false);
        if (!variable) {
            return fmi2Error;
        }
        value[i] = *real_at(instance, variable);
    }
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Boolean value[])
{
    struct Instance *instance = c;
    if (!callable(instance, "fmi2GetBoolean", READABLE, vr, nvr, value)) {
        return fmi2Error;
    }
    refresh(instance);
    for (size_t i = 0; i < nvr; ++i) {
        const struct Variable *variable = variable_of(instance, vr[i], true);
        if (!variable) {
            return fmi2Error;
        }
        value[i] = *boolean_at(instance, variable) ? fmi2True : fmi2False;
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[])
{
    struct Instance *instance = c;
    if (!callable(instance, "fmi2SetReal", WRITABLE, vr, nvr, value)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < nvr; ++i) {
        if (!settable(instance, vr[i], false)) {
            return fmi2Error;   /* and nothing is set */
        }
    }
    for (size_t i = 0; i < nvr; ++i) {
        const struct Variable *variable = &MODEL.variables[vr[i]];
        *real_at(instance, variable) = value[i];
        if (!(value[i] >= variable->minimum && value[i] <= variable->maximum)) {
            instance->progress.suspect = true;   /* refused before the next step */
        }
    }
    if (instance->progress.phase != RUNNING) {
        instance->progress.stale = true;
    }
    return fmi2OK;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Boolean value[])
{
    struct Instance *instance = c;
    if (!callable(instance, "fmi2SetBoolean", WRITABLE, vr, nvr, value)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < nvr; ++i) {
        if (!settable(instance, vr[i], true)) {
            return fmi2Error;
        }
    }
    for (size_t i = 0; i < nvr; ++i) {
        *boolean_at(instance, &MODEL.variables[vr[i]]) = value[i] != fmi2False;
    }
    if (instance->progress.phase != RUNNING) {
        instance->progress.stale = true;
    }
    return fmi2OK;
}

/* Access to variables of a type that this FMU does not have. */
static fmi2Status no_such_type(const struct Instance *instance, const char *call, int phases, size_t count)
{
    if (!allowed(instance, call, phases)) {
        return fmi2Error;
    }
    return count == 0 ? fmi2OK : refuse(instance, "%s of %u variables, expected Real or Boolean variables: there are "
                                        "no others", call, (unsigned)count);
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Integer value[])
{
    (void)vr;
    (void)value;
    return no_such_type(c, "fmi2GetInteger", READABLE, nvr);
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2String value[])
{
    (void)vr;
    (void)value;
    return no_such_type(c, "fmi2GetString", READABLE, nvr);
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer value[])
{
    (void)vr;
    (void)value;
    return no_such_type(c, "fmi2SetInteger", WRITABLE, nvr);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2String value[])
{
    (void)vr;
    (void)value;
    return no_such_type(c, "fmi2SetString", WRITABLE, nvr);
}
