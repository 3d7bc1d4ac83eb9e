/* FMI 2.0 for model exchange, and directional derivatives: its functions over an instance. */

#include "events.h"
#include "exchange.h"
#include "messages.h"

#include "fmi2Functions.h"

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    return (fmi2Status)enter_event(c, "fmi2EnterEventMode");
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *eventInfo)
{
    bool changed;
    if (!eventInfo) {
        return (fmi2Status)refuse(c, "fmi2NewDiscreteStates with a null pointer, expected a place for its result");
    }
    double next;
    enum Status status = take_event(c, "fmi2NewDiscreteStates", &changed, &next);
    *eventInfo = (fmi2EventInfo){.valuesOfContinuousStatesChanged = changed ? fmi2True : fmi2False};
    return (fmi2Status)status;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    return (fmi2Status)leave_event(c, "fmi2EnterContinuousTimeMode");
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi2Boolean *enterEventMode, fmi2Boolean *terminateSimulation)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!enterEventMode || !terminateSimulation) {
        return (fmi2Status)refuse(c, "fmi2CompletedIntegratorStep with a null pointer, expected places for its "
                                  "results");
    }
    bool event;
    enum Status status = complete_step(c, "fmi2CompletedIntegratorStep", &event);
    *enterEventMode = event ? fmi2True : fmi2False;
    *terminateSimulation = fmi2False;
    return (fmi2Status)status;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    return (fmi2Status)set_time(c, "fmi2SetTime", time);
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx)
{
    return (fmi2Status)set_states(c, "fmi2SetContinuousStates", x, nx);
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx)
{
    return (fmi2Status)get_rates(c, "fmi2GetDerivatives", derivatives, nx);
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni)
{
    return (fmi2Status)get_indicators(c, "fmi2GetEventIndicators", eventIndicators, ni);
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx)
{
    return (fmi2Status)get_states(c, "fmi2GetContinuousStates", x, nx);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx)
{
    return (fmi2Status)get_nominals(c, "fmi2GetNominalsOfContinuousStates", x_nominal, nx);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown_ref[], size_t nUnknown,
                                        const fmi2ValueReference vKnown_ref[], size_t nKnown,
                                        const fmi2Real dvKnown[], fmi2Real dvUnknown[])
{
    return (fmi2Status)differentiate(c, "fmi2GetDirectionalDerivative", vUnknown_ref, nUnknown, vKnown_ref, nKnown,
                                     dvKnown, dvUnknown);
}
