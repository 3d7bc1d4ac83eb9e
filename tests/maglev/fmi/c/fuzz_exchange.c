/* Reads programs, as fuzz.c does, and carries them out as calls of model exchange: in any order, with any values.
 *
 * What has to hold: a call is done, discarded or refused, and what is not done is said; rates and derivatives of states
 * that are in reach are finite; states go through bytes and come back; no memory is left. */

#include "fuzz_importer.h"

enum { ROOM = 128 };

static struct Slave one = {.name = "one"};
static bool tame;   /* no state was set that is out of reach */

#if defined FMI3
#define fmi2EnterEventMode fmi3EnterEventMode
#define fmi2EnterContinuousTimeMode fmi3EnterContinuousTimeMode
#define fmi2CompletedIntegratorStep fmi3CompletedIntegratorStep
#define fmi2SetTime fmi3SetTime
#define fmi2SetContinuousStates fmi3SetContinuousStates
#define fmi2GetContinuousStates fmi3GetContinuousStates
#define fmi2GetDerivatives fmi3GetContinuousStateDerivatives
#define fmi2GetEventIndicators fmi3GetEventIndicators
#define fmi2GetNominalsOfContinuousStates fmi3GetNominalsOfContinuousStates

static fmi3Status take_event(fmi3Instance instance)
{
    fmi3Boolean more, end, nominals, values, timed;
    fmi3Float64 time;
    return fmi3UpdateDiscreteStates(instance, &more, &end, &nominals, &values, &timed, &time);
}

static fmi3Status differentiate(const fmi3ValueReference *unknowns, size_t unknown_count,
                                const fmi3ValueReference *knowns, size_t known_count, const double *seed,
                                double *sensitivity, bool adjoint)
{
    return (adjoint ? fmi3GetAdjointDerivative : fmi3GetDirectionalDerivative)(
        one.component, unknowns, unknown_count, knowns, known_count, seed, adjoint ? unknown_count : known_count,
        sensitivity, adjoint ? known_count : unknown_count);
}

static fmi3Status set_up(double time)
{
    return fmi3EnterInitializationMode(one.component, false, 0.0, time, false, 0.0);
}
#else
static fmi2Status take_event(fmi2Component instance)
{
    fmi2EventInfo info;
    return fmi2NewDiscreteStates(instance, &info);
}

static fmi2Status differentiate(const fmi2ValueReference *unknowns, size_t unknown_count,
                                const fmi2ValueReference *knowns, size_t known_count, const double *seed,
                                double *sensitivity, bool adjoint)
{
    (void)adjoint;
    return fmi2GetDirectionalDerivative(one.component, unknowns, unknown_count, knowns, known_count, seed, sensitivity);
}

static fmi2Status set_up(double time)
{
    fmi2Status status = fmi2SetupExperiment(one.component, fmi2False, 0.0, time, fmi2False, 0.0);
    return status == fmi2OK ? fmi2EnterInitializationMode(one.component) : status;
}
#endif

/* Whether a call was done; if not, it has said so. */
static bool done(unsigned before, fmi2Status status)
{
    REQUIRE(status == fmi2OK || status == fmi2Discard || status == fmi2Error);
    REQUIRE(said - before == (unsigned)(status == fmi2Error || (status == fmi2Discard && one.logging)));
    return status == fmi2OK;
}

#define DONE(call) (before = said, done(before, call))

static void begin(void)
{
    unsigned before;
    if (!one.component) {
        one.logging = byte() % 2;
        one.component = fmi2Instantiate(one.name, fmi2ModelExchange, MODEL.guid, NULL, &callbacks, fmi2False,
                                        one.logging);
        REQUIRE(one.component != NULL);
    } else {
        REQUIRE(DONE(fmi2Reset(one.component)));
    }
    tame = true;
    REQUIRE(DONE(set_up(0.0)));
    REQUIRE(DONE(fmi2ExitInitializationMode(one.component)));
}

static void set_states(unsigned choice)
{
    double x[ROOM];
    size_t count = MODEL.continuous->state_count;
    unsigned before;
    if (!DONE(fmi2GetContinuousStates(one.component, x, count))) {
        return;
    }
    x[byte() % count] += choice % 8 == 0 ? any_value() : 1e-3 * (byte() - 128.0);
    if (DONE(fmi2SetContinuousStates(one.component, choice % 16 == 1 ? NULL : x, count - (choice % 16 == 2)))) {
        tame = tame && choice % 8;
    }
}

static void look(unsigned choice)
{
    double values[ROOM];
    size_t states = MODEL.continuous->state_count, indicators = MODEL.continuous->indicator_count;
    unsigned before;
    size_t count = choice % 3 == 1 ? indicators : states;
    bool got = choice % 3 == 0 ? DONE(fmi2GetDerivatives(one.component, values, count))
               : choice % 3 == 1 ? DONE(fmi2GetEventIndicators(one.component, values, count))
                                 : DONE(fmi2GetNominalsOfContinuousStates(one.component, values, count));
    for (size_t i = 0; got && tame && i < count; ++i) {
        REQUIRE(isfinite(values[i]) && (choice % 3 < 2 || values[i] > 0.0));
    }
    DONE(fmi2GetDerivatives(one.component, choice % 2 ? NULL : values, states + choice % 2));
}

static void derive(unsigned choice)
{
    const struct Continuous *model = MODEL.continuous;
    fmi2ValueReference unknowns[MOST], knowns[MOST];
    double seed[MOST], sensitivity[MOST];
    unsigned before, unknown_count = byte() % MOST, known_count = byte() % MOST;
    for (unsigned i = 0; i < MOST; ++i) {
        unknowns[i] = choice % 8 ? model->unknowns[byte() % model->unknown_count] : byte() * 3u;
        knowns[i] = choice % 8 ? model->states[byte() % model->state_count] : byte() * 3u;
        seed[i] = (byte() - 128.0) / 64.0;
    }
    bool adjoint = choice % 2;
    if (DONE(differentiate(unknowns, unknown_count, choice % 16 == 1 ? NULL : knowns, known_count, seed, sensitivity,
                           adjoint))) {
#if !defined FMI3
        adjoint = false;
#endif
        for (unsigned i = 0; tame && i < (adjoint ? known_count : unknown_count); ++i) {
            REQUIRE(isfinite(sensitivity[i]));
        }
    }
}

static bool continuous_state(fmi2ValueReference reference)
{
    bool found = false;
    for (size_t i = 0; i < MODEL.continuous->state_count; ++i) {
        found = found || MODEL.continuous->states[i] == reference;
    }
    return found;
}

static void variable(unsigned choice)
{
    fmi2ValueReference reference = (choice + 256u * byte()) % (unsigned)MODEL.variable_count;
    const struct Variable *which = &MODEL.variables[reference];
    unsigned before;
    double value = which->causality < OUTPUT ? value_in_range(which) : 0.0;
    fmi2Boolean truth = fmi2True;
    if (which->boolean) {
        DONE(fmi2SetBoolean(one.component, &reference, 1, &truth));
        DONE(fmi2GetBoolean(one.component, &reference, 1, &truth));
    } else {
        if (choice % 16 == 0) {
            value = any_value();
        }
        if (DONE(fmi2SetReal(one.component, &reference, 1, &value))) {
            REQUIRE(which->causality < OUTPUT || continuous_state(reference));
            tame = false;   /* masses and constants of any size, and times of none */
        }
        DONE(fmi2GetReal(one.component, &reference, 1, &value));
    }
}

static void keep(unsigned choice)
{
    static char bytes[100000];
    fmi2FMUstate state = NULL, back = NULL;
    double before_states[ROOM], states[ROOM];
    size_t size = 0, count = MODEL.continuous->state_count;
    unsigned before;
    bool readable = DONE(fmi2GetContinuousStates(one.component, before_states, count));
    REQUIRE(DONE(fmi2GetFMUstate(one.component, &state)));
    REQUIRE(DONE(fmi2SerializedFMUstateSize(one.component, state, &size)) && size < sizeof bytes);
    REQUIRE(DONE(fmi2SerializeFMUstate(one.component, state, bytes, size)));
    REQUIRE(DONE(fmi2DeSerializeFMUstate(one.component, bytes, size, &back)));
    if (choice % 2) {
        set_states(choice);
    }
    REQUIRE(DONE(fmi2SetFMUstate(one.component, back)));
    if (readable && DONE(fmi2GetContinuousStates(one.component, states, count))) {
        REQUIRE(memcmp(before_states, states, count * sizeof *states) == 0);
    }
    REQUIRE(DONE(fmi2FreeFMUstate(one.component, &state)) && DONE(fmi2FreeFMUstate(one.component, &back)));
    /* A state of an instance for co-simulation is none of this one. */
    fmi2Component other = fmi2Instantiate("other", fmi2CoSimulation, MODEL.guid, NULL, &callbacks, fmi2False, fmi2True);
    REQUIRE(other != NULL && DONE(fmi2GetFMUstate(other, &state)));
    REQUIRE(!DONE(fmi2SetFMUstate(one.component, state)));
    REQUIRE(DONE(fmi2FreeFMUstate(other, &state)));
    fmi2FreeInstance(other);
}

static void run(void)
{
    unsigned before;
    fmi2Boolean event, over;
    begin();
    while (at < end) {
        unsigned what = byte(), choice = byte();
        switch (what % 16) {
        case 0: DONE(fmi2EnterEventMode(one.component)); break;
        case 1: DONE(take_event(one.component)); break;
        case 2: case 3: DONE(fmi2EnterContinuousTimeMode(one.component)); break;
        case 4: DONE(fmi2CompletedIntegratorStep(one.component, fmi2True, &event, &over)); break;
        case 5: DONE(fmi2SetTime(one.component, choice % 8 ? 1e-3 * choice : any_value())); break;
        case 6: case 7: set_states(choice); break;
        case 8: case 9: look(choice); break;
        case 10: case 11: derive(choice); break;
        case 12: variable(choice); break;
        case 13: keep(choice); break;
        case 14: if (choice % 4 == 0) begin(); break;
        default:
            if (choice % 16 == 0) {
                DONE(fmi2Terminate(one.component));
            }
            REQUIRE(!DONE(fmi2DoStep(one.component, 0.0, 1e-4, fmi2True)));
        }
    }
    fmi2FreeInstance(one.component);
    one.component = NULL;
    REQUIRE(allocated == 0);
}

int main(int argc, char **argv)
{
    unsigned char length[2], bytes[65536];
    FILE *file = argc == 2 ? fopen(argv[1], "rb") : NULL;
    REQUIRE(file != NULL && MODEL.continuous->state_count < ROOM && MODEL.continuous->indicator_count < ROOM);
    callbacks = (fmi2CallbackFunctions){.logger = listen, .allocateMemory = give, .freeMemory = take,
                                        .componentEnvironment = &surroundings};
    while (fread(length, 1, 2, file) == 2) {
        size_t size = length[0] + 256u * length[1];
        REQUIRE(fread(bytes, 1, size, file) == size);
        at = bytes;
        end = bytes + size;
        run();
        ++program;
    }
    fclose(file);
    printf("%u programs, %u refusals\n", program, said);
    return 0;
}
