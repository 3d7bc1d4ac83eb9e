/* FMI 3.0: event mode, and the clock of a sampled FMU. */

#include "events.h"
#include "messages.h"

#include <math.h>

#include "fmi3Functions.h"

fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    return (fmi3Status)enter_event(instance, "fmi3EnterEventMode");
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    return (fmi3Status)leave_event(instance, "fmi3EnterContinuousTimeMode");
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    return (fmi3Status)enter_steps(instance, "fmi3EnterStepMode");
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation, fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged, fmi3Boolean *nextEventTimeDefined,
                                    fmi3Float64 *nextEventTime)
{
    if (!discreteStatesNeedUpdate || !terminateSimulation || !nominalsOfContinuousStatesChanged
        || !valuesOfContinuousStatesChanged || !nextEventTimeDefined || !nextEventTime) {
        return (fmi3Status)refuse(instance, "fmi3UpdateDiscreteStates with a null pointer, expected places for its "
                                  "results");
    }
    *discreteStatesNeedUpdate = false;
    *terminateSimulation = false;
    *nominalsOfContinuousStatesChanged = false;
    fmi3Status status = (fmi3Status)take_event(instance, "fmi3UpdateDiscreteStates", valuesOfContinuousStatesChanged,
                                               nextEventTime);
    *nextEventTimeDefined = isfinite(*nextEventTime);
    return status;
}

fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Clock values[])
{
    return (fmi3Status)set_clocks(instance, "fmi3SetClock", valueReferences, nValueReferences, values);
}

fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Clock values[])
{
    return (fmi3Status)get_clocks(instance, "fmi3GetClock", valueReferences, nValueReferences, values);
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                  size_t nValueReferences, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
{
    bool changed;
    enum Status status = clocks_known(instance, "fmi3GetIntervalDecimal", INTERVAL_READABLE, valueReferences,
                                      nValueReferences, qualifiers ? intervals : NULL);
    for (size_t i = 0; status == DONE && i < nValueReferences; ++i) {
        intervals[i] = told_interval(instance, &changed);
        qualifiers[i] = changed ? fmi3IntervalChanged : fmi3IntervalUnchanged;
    }
    return (fmi3Status)status;
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                               size_t nValueReferences, fmi3Float64 shifts[])
{
    enum Status status = clocks_known(instance, "fmi3GetShiftDecimal", INTERVAL_READABLE, valueReferences,
                                      nValueReferences, shifts);
    for (size_t i = 0; status == DONE && i < nValueReferences; ++i) {
        shifts[i] = 0.0;   /* the first sample is at the start time */
    }
    return (fmi3Status)status;
}

/* The parameters are those of FMI, and only the instance is of use. */
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

#define NOT_SET(function, ...)                                                                                         \
    fmi3Status fmi3##function(fmi3Instance instance, __VA_ARGS__)                                                      \
    {                                                                                                                  \
        return (fmi3Status)set_interval(instance, "fmi3" #function);                                                   \
    }

NOT_SET(SetIntervalDecimal, const fmi3ValueReference valueReferences[], size_t nValueReferences,
        const fmi3Float64 intervals[])
NOT_SET(SetIntervalFraction, const fmi3ValueReference valueReferences[], size_t nValueReferences,
        const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
NOT_SET(SetShiftDecimal, const fmi3ValueReference valueReferences[], size_t nValueReferences,
        const fmi3Float64 shifts[])
NOT_SET(SetShiftFraction, const fmi3ValueReference valueReferences[], size_t nValueReferences,
        const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])

#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif
