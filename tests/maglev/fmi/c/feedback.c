/* A sampled FMU of FMI 3.0 with event mode in a feedback loop: outputs are read before the inputs that follow from them
 * are set, in the initialization, at a sample, and after a state was restored in between.
 *
 * One instance is asked for everything early and set to wrong values first. Another one is set and sampled without a
 * question; with a clock it is asked once, before the clock's end. Every output at every sample, and the whole state in
 * the end, have the same bits. */

#include "fuzz_importer.h"

enum { MOST_SET = 600, SAMPLES = 400, LONGEST_STATE = 1 << 16 };

static fmi3Instance plain, asked, other;
static fmi3ValueReference knobs[MOST_SET], outputs[MOST_SET], flags[MOST_SET];
static size_t knob_count, output_count, flag_count;
static double usual[MOST_SET];
static uint64_t randomness = 88172645463325252u;

/* -1 to 1 */
static double jitter(void)
{
    randomness ^= randomness << 13;
    randomness ^= randomness >> 7;
    randomness ^= randomness << 17;
    return (double)(randomness >> 11) / 4503599627370496.0 - 1.0;
}

#define OK(call) REQUIRE((call) == fmi3OK)

static fmi3Instance begun(const char *name)
{
    fmi3Instance one = fmi3InstantiateCoSimulation(name, MODEL.guid, NULL, false, false, true, true, NULL, 0,
                                                   &surroundings, pass_on, NULL);
    REQUIRE(one != NULL);
    OK(fmi3EnterInitializationMode(one, false, 0.0, 0.0, false, 0.0));
    return one;
}

static void classify(void)
{
    for (size_t i = 0; i < MODEL.variable_count; ++i) {
        const struct Variable *variable = &MODEL.variables[i];
        fmi3ValueReference reference = (fmi3ValueReference)i;
        if (variable->boolean) {
            if (variable->causality == PARAMETER && !variable->fixed) {
                flags[flag_count++] = reference;
            }
        } else if (variable->causality == OUTPUT) {
            outputs[output_count++] = reference;
        } else if (variable->causality == INPUT || (variable->causality == PARAMETER && !variable->fixed)) {
            knobs[knob_count++] = reference;
        }
    }
    REQUIRE(knob_count > 6 && output_count > 6 && flag_count > 0);
    OK(fmi3GetFloat64(plain, knobs, knob_count, usual, knob_count));
}

static void draw(double values[])
{
    for (size_t i = 0; i < knob_count; ++i) {
        const struct Variable *variable = &MODEL.variables[knobs[i]];
        double value = usual[i] * (1.0 + 1e-3 * jitter()) + (variable->causality == INPUT ? 1e-5 * jitter() : 0.0);
        values[i] = fmin(fmax(value, variable->minimum), variable->maximum);
    }
}

static void set(fmi3Instance one, const double values[], bool flag)
{
    for (size_t i = 0; i < flag_count; ++i) {
        OK(fmi3SetBoolean(one, &flags[i], 1, &flag, 1));
    }
    OK(fmi3SetFloat64(one, knobs, knob_count, values, knob_count));
}

static void get(fmi3Instance one, double values[])
{
    OK(fmi3GetFloat64(one, outputs, output_count, values, output_count));
}

static void update(fmi3Instance one)
{
    bool more, end, nominals, values, defined;
    double time;
    OK(fmi3UpdateDiscreteStates(one, &more, &end, &nominals, &values, &defined, &time));
}

static void tick(fmi3Instance one)
{
    bool active = true;
    if (MODEL.sampling->clocked) {
        OK(fmi3SetClock(one, &MODEL.sampling->clock, 1, &active));
    }
}

static size_t written(fmi3Instance one, unsigned char bytes[])
{
    fmi3FMUState state = NULL;
    size_t size;
    OK(fmi3GetFMUState(one, &state));
    OK(fmi3SerializedFMUStateSize(one, state, &size));
    REQUIRE(size <= LONGEST_STATE);
    OK(fmi3SerializeFMUState(one, state, bytes, size));
    OK(fmi3FreeFMUState(one, &state));
    return size;
}

/* What another instance goes on with. */
static void moved(fmi3Instance from, fmi3Instance to)
{
    static unsigned char bytes[LONGEST_STATE];
    fmi3FMUState state = NULL;
    size_t size = written(from, bytes);
    OK(fmi3DeserializeFMUState(to, bytes, size, &state));
    OK(fmi3SetFMUState(to, state));
    OK(fmi3FreeFMUState(to, &state));
}

/* An instant of the instance that is asked: whatever comes before, `values` and `flag` are set last, and `early` is what
 * it says before the update; in the initialization there is none. */
static void ask(unsigned order, const double values[], bool flag, double early[])
{
    static double wrong[MOST_SET], first[MOST_SET], again[MOST_SET];
    fmi3FMUState state = NULL;
    draw(wrong);
    if (order == 0) {   /* get, set, get */
        get(asked, first);
    } else if (order == 1) {   /* set, get, set, get */
        set(asked, wrong, !flag);
        get(asked, first);
    } else if (order == 2) {   /* get, and what is restored before it, between set and get */
        OK(fmi3GetFMUState(asked, &state));
        get(asked, first);
        set(asked, wrong, !flag);
        get(asked, again);
        OK(fmi3SetFMUState(asked, state));
        get(asked, again);
        REQUIRE(memcmp(first, again, output_count * sizeof *first) == 0);
    } else if (order == 3) {   /* get, and what is restored after it */
        get(asked, first);
        OK(fmi3GetFMUState(asked, &state));
        set(asked, wrong, !flag);
        get(asked, again);
        OK(fmi3SetFMUState(asked, state));
        get(asked, again);
        REQUIRE(memcmp(first, again, output_count * sizeof *first) == 0);
    } else {   /* get, and another instance goes on */
        fmi3Instance one = asked;
        get(asked, first);
        moved(asked, other);
        asked = other;
        other = one;
    }
    OK(fmi3FreeFMUState(asked, &state));
    set(asked, values, flag);
    get(asked, early);
}

int main(void)
{
    static unsigned char of_plain[LONGEST_STATE], of_asked[LONGEST_STATE];
    double values[MOST_SET], expected[MOST_SET], early[MOST_SET], late[MOST_SET];
    unsigned changes = 0;
    callbacks.logger = listen;
    callbacks.componentEnvironment = &surroundings;
    given = &callbacks;
    plain = begun("plain");
    asked = begun("asked");
    other = begun("other");
    classify();
    for (unsigned order = 0; order < 5; ++order) {
        draw(values);
        set(plain, values, true);
        get(plain, expected);
        ask(order, values, true, early);
        REQUIRE(memcmp(expected, early, output_count * sizeof *early) == 0);
    }
    double sample_time = 0.0;
    for (size_t i = 0; i < MODEL.variable_count; ++i) {
        if (strcmp(MODEL.variables[i].name, "sample_time") == 0) {
            OK(fmi3GetFloat64(plain, &(fmi3ValueReference){(fmi3ValueReference)i}, 1, &sample_time, 1));
        }
    }
    REQUIRE(sample_time > 0.0);
    fmi3Instance all[] = {plain, asked, other};
    for (size_t i = 0; i < 3; ++i) {
        OK(fmi3ExitInitializationMode(all[i]));
    }
    for (unsigned k = 0; k < SAMPLES; ++k) {
        bool flag = k / 7 % 2;
        draw(values);
        for (size_t i = 0; i < 3; ++i) {
            tick(all[i]);
        }
        set(plain, values, flag);
        memcpy(late, expected, sizeof late);
        if (MODEL.sampling->clocked) {   /* outputs are there as long as the clock is active */
            get(plain, expected);
            update(plain);
        } else {
            update(plain);
            get(plain, expected);
        }
        changes += memcmp(late, expected, output_count * sizeof *late) != 0;
        ask(k % 5, values, flag, early);
        REQUIRE(memcmp(expected, early, output_count * sizeof *early) == 0);
        update(asked);
        if (!MODEL.sampling->clocked) {
            get(asked, late);
            REQUIRE(memcmp(expected, late, output_count * sizeof *late) == 0);
        }
        moved(asked, other);   /* so that the clock of both is the same */
        for (size_t i = 0; i < 3; ++i) {
            bool event, last, early_return;
            double time;
            OK(fmi3EnterStepMode(all[i]));
            OK(fmi3DoStep(all[i], k * sample_time, sample_time, false, &event, &last, &early_return, &time));
            OK(fmi3EnterEventMode(all[i]));
        }
    }
    REQUIRE(changes == SAMPLES);
    size_t size = written(plain, of_plain);
    REQUIRE(written(asked, of_asked) == size && memcmp(of_plain, of_asked, size) == 0);
    for (size_t i = 0; i < 3; ++i) {
        fmi3FreeInstance(all[i]);
    }
    printf("%d samples\n", SAMPLES);
    return 0;
}
