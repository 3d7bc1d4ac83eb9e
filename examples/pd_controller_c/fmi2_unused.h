/* Functions that FMI 2.0 requires, and that the FMUs of these examples do not use. An FMU that computes at the end of
 * its initialization, or has a Boolean, defines these functions itself, and HAS_START or HAS_BOOLEAN before this. */

#define UNUSED(result, name, ...) fmi2Status name(__VA_ARGS__) { return result; }
#define NAMES fmi2Component c, const fmi2ValueReference vr[], size_t n
const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }
UNUSED(fmi2OK, fmi2SetDebugLogging, fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[])
UNUSED(fmi2OK, fmi2SetupExperiment, fmi2Component c, fmi2Boolean tolerant, fmi2Real tolerance, fmi2Real start,
       fmi2Boolean stops, fmi2Real stop)
UNUSED(fmi2OK, fmi2EnterInitializationMode, fmi2Component c)
#ifndef HAS_START
UNUSED(fmi2OK, fmi2ExitInitializationMode, fmi2Component c)
#endif
UNUSED(fmi2OK, fmi2Terminate, fmi2Component c)
UNUSED(n ? fmi2Error : fmi2OK, fmi2GetInteger, NAMES, fmi2Integer value[])
UNUSED(n ? fmi2Error : fmi2OK, fmi2SetInteger, NAMES, const fmi2Integer value[])
#ifndef HAS_BOOLEAN
UNUSED(n ? fmi2Error : fmi2OK, fmi2GetBoolean, NAMES, fmi2Boolean value[])
#endif
UNUSED(n ? fmi2Error : fmi2OK, fmi2SetBoolean, NAMES, const fmi2Boolean value[])
UNUSED(n ? fmi2Error : fmi2OK, fmi2GetString, NAMES, fmi2String value[])
UNUSED(n ? fmi2Error : fmi2OK, fmi2SetString, NAMES, const fmi2String value[])
UNUSED(fmi2Error, fmi2GetFMUstate, fmi2Component c, fmi2FMUstate *state)
UNUSED(fmi2Error, fmi2SetFMUstate, fmi2Component c, fmi2FMUstate state)
UNUSED(fmi2Error, fmi2FreeFMUstate, fmi2Component c, fmi2FMUstate *state)
UNUSED(fmi2Error, fmi2SerializedFMUstateSize, fmi2Component c, fmi2FMUstate state, size_t *size)
UNUSED(fmi2Error, fmi2SerializeFMUstate, fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
UNUSED(fmi2Error, fmi2DeSerializeFMUstate, fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
UNUSED(fmi2Error, fmi2GetDirectionalDerivative, fmi2Component c, const fmi2ValueReference of[], size_t nof,
       const fmi2ValueReference by[], size_t nby, const fmi2Real seed[], fmi2Real result[])
UNUSED(fmi2Error, fmi2SetRealInputDerivatives, NAMES, const fmi2Integer order[], const fmi2Real value[])
UNUSED(fmi2Error, fmi2GetRealOutputDerivatives, NAMES, const fmi2Integer order[], fmi2Real value[])
UNUSED(fmi2Error, fmi2CancelStep, fmi2Component c)
UNUSED(fmi2Error, fmi2GetStatus, fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
UNUSED(fmi2Error, fmi2GetRealStatus, fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
UNUSED(fmi2Error, fmi2GetIntegerStatus, fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
UNUSED(fmi2Error, fmi2GetBooleanStatus, fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
UNUSED(fmi2Error, fmi2GetStringStatus, fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
