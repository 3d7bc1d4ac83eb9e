/* Reads programs, each a string of bytes, and carries them out as FMI calls on a few instances: in any order, with any
 * values, null pointers, references that do not exist, memory that runs out, states that are truncated or garbled.
 *
 * What has to hold is checked here, in an account of the phases of its own: a call is refused where FMI 2.0.4 (table of
 * figure 11) does not allow it, every refusal is said to the importer, numbers stay finite, and no memory is left. The
 * sanitizers, or valgrind, see the rest.
 *
 * fuzz FILE; in the file, before each program, its length: two bytes, the lower first. */

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "model.h"

enum { INSTANCES = 4, STATES = 6, MOST = 12 };

/* As FMI names them; ABSENT is one that is not there. */
enum Phase { ABSENT = 0, INSTANTIATED = 1, INITIALIZATION = 2, STEPPING = 4, TERMINATED = 8, ERROR = 16 };
enum { EVERY = INSTANTIATED | INITIALIZATION | STEPPING | TERMINATED | ERROR };

static struct Slave {
    fmi2Component component;
    int phase;
    bool logging;
    double time;
    char name[16];
} slaves[INSTANCES];

static struct Saved {
    fmi2FMUstate state;
    struct Slave from;
} saved[STATES];

static unsigned program;                    /* the one that runs */
static const unsigned char *at, *end;       /* what is left of it */
static long allocated;                      /* pieces of memory that the FMU holds */
static int until_failure;                   /* allocations until one fails; 0 for never */
static unsigned said;                       /* messages */
static int surroundings;                    /* componentEnvironment: its address is what counts */

#define REQUIRE(condition) require(condition, #condition, __LINE__)

static void require(bool condition, const char *text, int line)
{
    if (!condition) {
        fprintf(stderr, "program %u, line %d: %s\n", program, line, text);
        abort();
    }
}

/* The program's bytes */

static unsigned byte(void)
{
    return at < end ? *at++ : 0;
}

static double any_value(void)
{
    static const double SPECIAL[] = {0.0, -0.0, 1.0, -1.0, NAN, INFINITY, -INFINITY, 1e308, -1e308, 5e-324, 1e-300,
                                     9007199254740993.0, 1e18, 9.3e18, -1e19, 2147483648.5};
    unsigned kind = byte() % 4;
    if (kind == 0) {
        return SPECIAL[byte() % (sizeof SPECIAL / sizeof *SPECIAL)];
    }
    if (kind == 1) {
        unsigned char raw[sizeof(double)];
        double value;
        for (size_t i = 0; i < sizeof raw; ++i) {
            raw[i] = (unsigned char)byte();
        }
        memcpy(&value, raw, sizeof value);
        return value;
    }
    return ((int)byte() - 128) * (kind == 2 ? 1e-4 : 0.1);
}

/* A value that the variable may take. */
static double value_in_range(const struct Variable *variable)
{
    double share = byte() / 255.0;
    double low = fmax(variable->minimum, -1e3), high = fmin(variable->maximum, 1e3);
    return fmin(fmax(low + share * share * (high - low), variable->minimum), variable->maximum);
}

/* The importer's functions */

static void *give(size_t count, size_t size)
{
    if (until_failure > 0 && --until_failure == 0) {
        return NULL;
    }
    ++allocated;
    return calloc(count, size);
}

static void take(void *memory)
{
    REQUIRE(memory != NULL);
    --allocated;
    free(memory);
}

static void listen(void *environment, fmi2String instance, fmi2Status status, fmi2String category, fmi2String format,
                   ...)
{
    char text[4000];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    REQUIRE(length > 0 && length < (int)sizeof text);
    REQUIRE(environment == &surroundings && instance != NULL);
    REQUIRE(status == fmi2Error && strcmp(category, "logStatusError") == 0);
    ++said;
}

static fmi2CallbackFunctions callbacks;

/* Check what a call of an instance has returned; true if it was carried out. */
static bool carried_out(const struct Slave *slave, unsigned said_before, int allowed_in, fmi2Status status)
{
    REQUIRE(status == fmi2OK || status == fmi2Error);
    REQUIRE((slave->phase & allowed_in) || status == fmi2Error);
    REQUIRE(said - said_before == (unsigned)(status == fmi2Error && slave->logging && slave->phase != ABSENT));
    return status == fmi2OK;
}

#define CALL(slave, allowed_in, call) (before = said, carried_out(slave, before, allowed_in, call))

static void instantiate(struct Slave *slave, bool plainly)
{
    unsigned flaws = plainly ? 0 : byte();
    const char *name = flaws % 16 == 1 ? NULL : flaws % 16 == 2 ? "" : slave->name;
    const char *guid = flaws % 16 == 3 ? NULL : flaws % 16 == 4 ? "{another}" : MODEL.guid;
    fmi2Type type = flaws % 16 == 5 ? fmi2ModelExchange : fmi2CoSimulation;
    const fmi2CallbackFunctions *functions = flaws % 16 == 6 ? NULL : &callbacks;
    bool flawed = flaws % 16 > 0 && flaws % 16 <= 6;
    if (slave->component) {
        return;
    }
    if (flaws >= 128) {
        until_failure = 1 + (int)(flaws % 5);
    }
    snprintf(slave->name, sizeof slave->name, "slave %d", (int)(slave - slaves));
    slave->logging = flaws % 3 != 0;
    slave->component = fmi2Instantiate(name, type, guid, flaws % 2 ? NULL : "file:///", functions, fmi2False,
                                       slave->logging);
    REQUIRE(!(flawed && slave->component));
    REQUIRE(slave->component || flawed || flaws >= 128);
    until_failure = 0;
    slave->phase = slave->component ? INSTANTIATED : ABSENT;
    slave->time = 0.0;
}

static void set_up(struct Slave *slave)
{
    unsigned before, choice = byte();
    double time = choice % 8 == 0 ? any_value() : 0.0;
    if (CALL(slave, INSTANTIATED, fmi2SetupExperiment(slave->component, choice % 2, 1e-3, time, choice % 3 == 0, 1.0))) {
        REQUIRE(isfinite(time));
        slave->time = time;
    }
}

static void enter(struct Slave *slave)
{
    unsigned before;
    if (CALL(slave, INSTANTIATED, fmi2EnterInitializationMode(slave->component))) {
        slave->phase = INITIALIZATION;
    } else {
        REQUIRE(slave->phase != INSTANTIATED);
    }
}

static void leave(struct Slave *slave)
{
    unsigned before;
    if (CALL(slave, INITIALIZATION, fmi2ExitInitializationMode(slave->component))) {
        slave->phase = STEPPING;
    } else if (slave->phase == INITIALIZATION) {
        slave->phase = ERROR;
    }
}

static void get_all(struct Slave *slave)
{
    static const int READABLE = INITIALIZATION | STEPPING | TERMINATED | ERROR;
    unsigned before;
    for (fmi2ValueReference i = 0; i < MODEL.variable_count; ++i) {
        double value;
        fmi2Boolean truth;
        if (MODEL.variables[i].boolean) {
            bool done = CALL(slave, READABLE, fmi2GetBoolean(slave->component, &i, 1, &truth));
            REQUIRE(done == ((slave->phase & READABLE) != 0) && (!done || truth == fmi2False || truth == fmi2True));
        } else {
            bool done = CALL(slave, READABLE, fmi2GetReal(slave->component, &i, 1, &value));
            REQUIRE(done == ((slave->phase & READABLE) != 0));
            REQUIRE(!done || slave->phase != STEPPING || MODEL.variables[i].causality != OUTPUT || isfinite(value));
        }
    }
}

static void step(struct Slave *slave)
{
    static const double SIZES[] = {5e-4, 2e-4, 1e-4, 2.5e-4, 1e-3, 5e-4, 2e-4};
    unsigned before, choice = byte();
    double size = choice % 8 < 7 ? SIZES[choice % 8] : any_value();
    double time = choice % 32 == 31 ? any_value() : slave->time;
    if (size > 0.1 && isfinite(size)) {
        size = 0.1;   /* a plant computes for as long as the step is */
    }
    if (CALL(slave, STEPPING, fmi2DoStep(slave->component, time, size, choice % 2))) {
        REQUIRE(isfinite(time) && isfinite(size) && size > 0.0);
        slave->time = time + size;
        get_all(slave);
    } else if (slave->phase == STEPPING) {
        slave->phase = ERROR;
    }
}

static void set_reals(struct Slave *slave)
{
    fmi2ValueReference references[MOST];
    double values[MOST];
    unsigned before, choice = byte(), count = byte() % MOST;
    for (unsigned i = 0; i < count; ++i) {
        references[i] = byte() % (unsigned)(MODEL.variable_count + (choice % 8 == 0 ? 3 : 0));
        bool sensible = choice % 4 && references[i] < MODEL.variable_count && !MODEL.variables[references[i]].boolean;
        values[i] = sensible ? value_in_range(&MODEL.variables[references[i]]) : any_value();
    }
    CALL(slave, INSTANTIATED | INITIALIZATION | STEPPING,
         fmi2SetReal(slave->component, choice % 16 == 1 ? NULL : references, count, choice % 16 == 2 ? NULL : values));
}

/* One variable, which goes through more often than several do. */
static void set_one(struct Slave *slave)
{
    static const int WRITABLE = INSTANTIATED | INITIALIZATION | STEPPING;
    unsigned before;
    fmi2ValueReference reference = byte() % (unsigned)MODEL.variable_count;
    const struct Variable *variable = &MODEL.variables[reference];
    bool done;
    if (variable->boolean) {
        fmi2Boolean value = (int)byte() - 1;
        done = CALL(slave, WRITABLE, fmi2SetBoolean(slave->component, &reference, 1, &value));
    } else {
        double value = value_in_range(variable);
        done = CALL(slave, WRITABLE, fmi2SetReal(slave->component, &reference, 1, &value));
    }
    REQUIRE(done == ((slave->phase & WRITABLE) && variable->causality != OUTPUT
                     && !(variable->fixed && slave->phase == STEPPING)));
}

static void get_some(struct Slave *slave)
{
    fmi2ValueReference references[MOST];
    double values[MOST];
    fmi2Boolean truths[MOST];
    unsigned before, choice = byte(), count = byte() % MOST;
    for (unsigned i = 0; i < count; ++i) {
        references[i] = choice % 8 ? byte() % (unsigned)MODEL.variable_count : byte() * 16777217u;
    }
    const fmi2ValueReference *given = choice % 16 == 1 ? NULL : references;
    const int phases = INITIALIZATION | STEPPING | TERMINATED | ERROR;
    CALL(slave, phases, fmi2GetReal(slave->component, given, count, choice % 16 == 2 ? NULL : values));
    CALL(slave, phases, fmi2GetBoolean(slave->component, given, count, choice % 16 == 2 ? NULL : truths));
}

static void other_types(struct Slave *slave)
{
    fmi2ValueReference reference = byte();
    fmi2Integer integer = 0;
    fmi2String text = "";
    unsigned before, count = byte() % 2;
    CALL(slave, EVERY, fmi2GetInteger(slave->component, &reference, count, &integer));
    CALL(slave, EVERY, fmi2SetInteger(slave->component, &reference, count, &integer));
    CALL(slave, EVERY, fmi2GetString(slave->component, &reference, count, &text));
    CALL(slave, EVERY, fmi2SetString(slave->component, &reference, count, &text));
}

static void save(struct Slave *slave, struct Saved *to)
{
    unsigned before, choice = byte();
    until_failure = choice % 4 == 0;
    if (CALL(slave, EVERY, fmi2GetFMUstate(slave->component, choice % 16 == 1 ? NULL : &to->state))
        && choice % 16 != 1) {
        to->from = *slave;
    }
    until_failure = 0;
}

static void restore(struct Slave *slave, const struct Saved *from)
{
    unsigned before;
    bool done = CALL(slave, EVERY, fmi2SetFMUstate(slave->component, from->state));
    REQUIRE(done == (slave->phase != ABSENT && from->state != NULL));
    if (done) {
        slave->phase = from->from.phase;
        slave->time = from->from.time;
    }
}

static void forget(struct Slave *slave, struct Saved *which)
{
    unsigned before;
    bool named = byte() % 8;
    if (CALL(slave, EVERY, fmi2FreeFMUstate(slave->component, named ? &which->state : NULL))) {
        REQUIRE(!named || which->state == NULL);
    }
}

/* Through bytes into another place: whole, truncated, with one byte changed, or into too little room. */
static void by_post(struct Slave *slave, const struct Saved *from, struct Saved *to)
{
    size_t size = 0;
    unsigned before, flaw = byte() % 8;
    bool sized = CALL(slave, EVERY, fmi2SerializedFMUstateSize(slave->component, from->state, flaw == 7 ? NULL : &size));
    if (!sized || !from->state || slave->phase == ABSENT) {
        return;
    }
    /* Of the very length that is told, so that a byte read beyond it is seen. */
    size_t told = flaw == 1 ? (byte() + 256 * byte()) % size : size;
    char *bytes = malloc(told ? told : 1);
    bool written = CALL(slave, EVERY, fmi2SerializeFMUstate(slave->component, from->state, bytes, told));
    REQUIRE(written == (told == size));
    if (!written) {
        memset(bytes, 0, told);
        if (told >= strlen(MODEL.guid)) {
            memcpy(bytes, MODEL.guid, strlen(MODEL.guid));
        }
    } else if (flaw == 2) {
        bytes[(byte() + 256 * byte()) % size] ^= (char)(1 << byte() % 8);
    }
    until_failure = flaw == 3;
    bool read = CALL(slave, EVERY, fmi2DeSerializeFMUstate(slave->component, bytes, told, &to->state));
    REQUIRE(!(read && (flaw == 1 || flaw == 2)));
    if (read) {
        to->from = from->from;
    }
    until_failure = 0;
    free(bytes);
}

static void talk(struct Slave *slave)
{
    static const fmi2String CATEGORIES[] = {"logAll", "logStatusError", "logStatusWarning", "logStatusDiscard",
                                            "logStatusFatal", "logEvents", "", NULL};
    fmi2String chosen[3];
    unsigned before, choice = byte(), count = choice % 4;
    bool errors = count == 0, known = true;
    for (unsigned i = 0; i < count; ++i) {
        unsigned which = byte() % 8;
        chosen[i] = CATEGORIES[which];
        errors = errors || which < 2;
        known = known && which < 5;
    }
    bool on = choice >= 64;
    if (CALL(slave, EVERY, fmi2SetDebugLogging(slave->component, on, count, chosen))) {
        REQUIRE(known);
        slave->logging = on ? errors : slave->logging && !errors;
    }
}

static void end_or_reset(struct Slave *slave)
{
    unsigned before;
    if (byte() % 2) {
        bool done = CALL(slave, STEPPING, fmi2Terminate(slave->component));
        REQUIRE(done == (slave->phase == STEPPING));
        slave->phase = done ? TERMINATED : slave->phase;
    } else if (CALL(slave, EVERY, fmi2Reset(slave->component))) {
        slave->phase = INSTANTIATED;
        slave->time = 0.0;
    } else {
        REQUIRE(slave->phase == ABSENT);
    }
}

static void what_it_cannot_do(struct Slave *slave)
{
    fmi2ValueReference reference = byte();
    fmi2Integer order = 1, integer;
    fmi2Real value = 0.0;
    fmi2Boolean truth;
    fmi2Status status;
    fmi2String text;
    fmi2StatusKind kind = (fmi2StatusKind)(byte() % 4);
    unsigned before;
    CALL(slave, 0, fmi2GetDirectionalDerivative(slave->component, &reference, 1, &reference, 1, &value, &value));
    CALL(slave, 0, fmi2SetRealInputDerivatives(slave->component, &reference, 1, &order, &value));
    CALL(slave, 0, fmi2GetRealOutputDerivatives(slave->component, &reference, 1, &order, &value));
    CALL(slave, 0, fmi2CancelStep(slave->component));
    CALL(slave, 0, fmi2GetStatus(slave->component, kind, &status));
    CALL(slave, kind == fmi2LastSuccessfulTime ? EVERY : 0, fmi2GetRealStatus(slave->component, kind, &value));
    CALL(slave, 0, fmi2GetIntegerStatus(slave->component, kind, &integer));
    CALL(slave, kind == fmi2Terminated ? EVERY : 0, fmi2GetBooleanStatus(slave->component, kind, &truth));
    CALL(slave, 0, fmi2GetStringStatus(slave->component, kind, &text));
}

static void forget_instance(struct Slave *slave)
{
    fmi2FreeInstance(slave->component);
    *slave = (struct Slave){.component = NULL};
}

static void run(void)
{
    /* Either function for memory may be missing; then the FMU has to use the C library's. */
    unsigned missing = byte() % 8;
    callbacks.allocateMemory = missing == 1 || missing == 3 ? NULL : give;
    callbacks.freeMemory = missing == 2 || missing == 3 ? NULL : take;
    instantiate(&slaves[0], true);
    while (at < end) {
        unsigned what = byte(), who = byte();
        struct Slave *slave = &slaves[who % INSTANCES];
        struct Saved *one = &saved[who / INSTANCES % STATES], *other = &saved[who / (INSTANCES * STATES) % STATES];
        switch (what % 24) {
        case 0: instantiate(slave, false); break;
        case 1: if (who >= 192) forget_instance(slave); break;
        case 2: set_up(slave); break;
        case 3: enter(slave); break;
        case 4: leave(slave); break;
        case 5:
        case 6:
            instantiate(slave, true);
            set_up(slave);
            enter(slave);
            leave(slave);
            break;
        case 7: set_reals(slave); break;
        case 8: get_some(slave); break;
        case 9: get_all(slave); break;
        case 10: other_types(slave); break;
        case 11: save(slave, one); break;
        case 12: restore(slave, one); break;
        case 13: forget(slave, one); break;
        case 14: by_post(slave, one, other); break;
        case 15: talk(slave); break;
        case 16: end_or_reset(slave); break;
        case 17: what_it_cannot_do(slave); break;
        case 18:
        case 19: set_one(slave); break;
        default: step(slave); break;
        }
    }
    for (unsigned i = 0; i < INSTANCES; ++i) {
        forget_instance(&slaves[i]);
    }
    /* States outlive instances; it takes one to free them. */
    instantiate(&slaves[0], true);
    for (unsigned i = 0; i < STATES; ++i) {
        REQUIRE(fmi2FreeFMUstate(slaves[0].component, &saved[i].state) == fmi2OK && saved[i].state == NULL);
    }
    forget_instance(&slaves[0]);
    REQUIRE(allocated == 0);
}

int main(int argc, char **argv)
{
    unsigned char length[2];
    FILE *file = argc == 2 ? fopen(argv[1], "rb") : NULL;
    REQUIRE(file != NULL);
    callbacks.logger = listen;
    callbacks.componentEnvironment = &surroundings;
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
