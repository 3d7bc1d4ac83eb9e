/* Functions of FMI 2.0 that this FMU does not support, as its model description says: derivatives by time, integers and
 * texts, and steps that return before they are done. */

#include "messages.h"
#include "variables.h"

#include "fmi2Functions.h"

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    (void)vr;
    (void)nvr;
    (void)order;
    (void)value;
    return (fmi2Status)absent(c, "fmi2SetRealInputDerivatives");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[])
{
    (void)vr;
    (void)nvr;
    (void)order;
    (void)value;
    return (fmi2Status)absent(c, "fmi2GetRealOutputDerivatives");
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    return (fmi2Status)absent(c, "fmi2CancelStep");
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Integer value[])
{
    (void)vr;
    (void)value;
    return (fmi2Status)get_none(c, "fmi2GetInteger", nvr);
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2String value[])
{
    (void)vr;
    (void)value;
    return (fmi2Status)get_none(c, "fmi2GetString", nvr);
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer value[])
{
    (void)vr;
    (void)value;
    return (fmi2Status)set_none(c, "fmi2SetInteger", nvr);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2String value[])
{
    (void)vr;
    (void)value;
    return (fmi2Status)set_none(c, "fmi2SetString", nvr);
}

/* The status of a step has nothing to tell (FMI 2.0.5, section 4.2.3): each step is done when fmi2DoStep returns. */
static fmi2Status untold(const struct Instance *instance, const char *call, fmi2StatusKind kind, const void *value)
{
    static const char *const KINDS[] = {"fmi2DoStepStatus", "fmi2PendingStatus", "fmi2LastSuccessfulTime",
                                        "fmi2Terminated"};
    if (!value) {
        return (fmi2Status)refuse(instance, "%s with a null pointer, expected a place for the value", call);
    }
    return (fmi2Status)discard(instance, "%s of %s: there is no such status, no step of this FMU is ever pending", call,
                               (unsigned)kind < sizeof KINDS / sizeof *KINDS ? KINDS[kind] : "an unknown kind");
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind s, fmi2Status *value)
{
    return untold(c, "fmi2GetStatus", s, value);
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value)
{
    const struct Instance *instance = c;
    if (instance && s == fmi2LastSuccessfulTime && value) {
        *value = instance->state->progress.next_time;
        return fmi2OK;
    }
    return untold(instance, "fmi2GetRealStatus", s, value);
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind s, fmi2Integer *value)
{
    return untold(c, "fmi2GetIntegerStatus", s, value);
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value)
{
    const struct Instance *instance = c;
    if (instance && s == fmi2Terminated && value) {
        *value = fmi2False;   /* this FMU never asks for the end of the simulation */
        return fmi2OK;
    }
    return untold(instance, "fmi2GetBooleanStatus", s, value);
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind s, fmi2String *value)
{
    return untold(c, "fmi2GetStringStatus", s, value);
}
