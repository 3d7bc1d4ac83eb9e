/* As fuzz.c for one instance of what samples, with event mode of FMI 3.0, by time or by a clock.
 *
 * What has to hold: a call is carried out or refused with a message, a sample is never passed over, a step ends early only
 * if that is allowed, and a state gives back what was there. */

#include "fuzz_importer.h"

static fmi3Instance one;
static bool early;
static double now, sample_time, next;   /* s; next is the sample that is due */
static fmi3FMUState kept;

static bool done(fmi3Status status, unsigned said_before)
{
    REQUIRE(status == fmi3OK || status == fmi3Error);
    REQUIRE(said - said_before == (unsigned)(status == fmi3Error));
    return status == fmi3OK;
}

#define DONE(call) (before = said, done(call, before))

static void begin(void)
{
    unsigned before, choice = byte();
    early = choice % 2;
    one = fmi3InstantiateCoSimulation("one", MODEL.guid, NULL, false, true, true, early, NULL, 0, &surroundings, pass_on,
                                      NULL);
    REQUIRE(one != NULL);
    now = choice % 3 ? 0.0 : 1e3;
    REQUIRE(DONE(fmi3EnterInitializationMode(one, false, 0.0, now, false, 0.0)));
    if (MODEL.sampling->clocked) {
        fmi3IntervalQualifier qualifier;
        REQUIRE(DONE(fmi3GetIntervalDecimal(one, &MODEL.sampling->clock, 1, &sample_time, &qualifier)));
        REQUIRE(qualifier == fmi3IntervalChanged && sample_time > 0.0);
    }
    REQUIRE(DONE(fmi3ExitInitializationMode(one)));
    next = now;
}

static void step(unsigned choice)
{
    unsigned before;
    bool event = true, end = true, returned = true;
    double last = NAN, size = choice % 4 ? 1e-5 * (byte() % 64) : any_value();
    if (DONE(fmi3DoStep(one, choice % 16 ? now : any_value(), size, false, &event, &end, &returned, &last))) {
        REQUIRE(!end && last >= now - 1e-9 && last <= now + size + 1e-9 && (early || !returned));
        REQUIRE(!event || !MODEL.sampling->clocked);
        REQUIRE(last <= next * (1.0 + 1e-9) + 2e-6 || isnan(next));   /* no sample is passed over */
        now = last;
    }
}

static void finish(void)
{
    unsigned before;
    bool more = true, end = true, nominals = true, values = true, defined = true;
    double time = NAN;
    if (DONE(fmi3UpdateDiscreteStates(one, &more, &end, &nominals, &values, &defined, &time))) {
        REQUIRE(!more && !end && defined == !MODEL.sampling->clocked);
        next = defined ? time : NAN;
        REQUIRE(!defined || time > now - 1e-6);
    }
}

static void access(unsigned choice)
{
    unsigned before;
    fmi3ValueReference reference = (choice + 256u * byte()) % (unsigned)(MODEL.variable_count + 2);
    const struct Variable *which = &MODEL.variables[reference % MODEL.variable_count];
    double value = which->causality <= INPUT && !which->boolean && choice % 8 ? value_in_range(which) : any_value();
    bool truth = choice % 2;
    if (choice % 3 == 0) {
        DONE(fmi3SetFloat64(one, &reference, 1, &value, 1));
        DONE(fmi3SetBoolean(one, &reference, 1, &truth, 1));
    } else {
        DONE(fmi3GetFloat64(one, &reference, 1, &value, 1));
        DONE(fmi3GetBoolean(one, &reference, 1, &truth, 1));
    }
}

static void clock(unsigned choice)
{
    unsigned before;
    fmi3ValueReference reference = choice % 8 ? MODEL.sampling->clock : byte();
    fmi3IntervalQualifier qualifier;
    bool active = choice % 16 != 1;
    double value;
    DONE(fmi3SetClock(one, choice % 32 == 2 ? NULL : &reference, 1, &active));
    DONE(fmi3GetClock(one, &reference, 1, &active));
    DONE(fmi3GetIntervalDecimal(one, &reference, 1, &value, choice % 32 == 3 ? NULL : &qualifier));
    DONE(fmi3GetShiftDecimal(one, &reference, 1, &value));
    DONE(fmi3SetIntervalDecimal(one, &reference, 1, &value));
}

static void keep(unsigned choice)
{
    static double at_kept, next_kept;
    unsigned before;
    if (choice % 2 || !kept) {
        REQUIRE(DONE(fmi3GetFMUState(one, &kept)));
        at_kept = now;
        next_kept = next;
    } else {
        REQUIRE(DONE(fmi3SetFMUState(one, kept)));
        now = at_kept;
        next = next_kept;
    }
}

static void run(void)
{
    unsigned before;
    begin();
    while (at < end) {
        unsigned what = byte(), choice = byte();
        switch (what % 12) {
        case 0: DONE(fmi3EnterEventMode(one)); break;
        case 1: DONE(fmi3EnterStepMode(one)); break;
        case 2: finish(); break;
        case 3: clock(choice); break;
        case 4: access(choice); break;
        case 5: keep(choice); break;
        case 6:   /* a whole event */
        case 7:
            DONE(fmi3EnterEventMode(one));
            if (MODEL.sampling->clocked) {
                clock(8 + choice / 16 * 16);
            }
            access(choice);
            finish();
            DONE(fmi3EnterStepMode(one));
            break;
        default: step(choice); break;
        }
    }
    REQUIRE(fmi3FreeFMUState(one, &kept) == fmi3OK);
    fmi3FreeInstance(one);
}

int main(int argc, char **argv)
{
    unsigned char length[2];
    FILE *file = argc == 2 ? fopen(argv[1], "rb") : NULL;
    REQUIRE(file != NULL);
    callbacks.logger = listen;
    callbacks.componentEnvironment = &surroundings;
    given = &callbacks;
    while (fread(length, 1, 2, file) == 2) {
        size_t size = length[0] + 256u * length[1];
        unsigned char *bytes = malloc(size + 1);
        REQUIRE(fread(bytes, 1, size, file) == size);
        at = bytes;
        end = bytes + size;
        run();
        free(bytes);
        ++program;
    }
    fclose(file);
    printf("%u programs, %u refusals\n", program, said);
    return 0;
}
