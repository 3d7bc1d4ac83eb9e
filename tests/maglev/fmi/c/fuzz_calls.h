/* The FMI calls of the fuzz driver, each with what has to hold after it. */

#ifndef FUZZ_CALLS_H
#define FUZZ_CALLS_H

#include "fuzz_importer.h"

enum { INSTANCES = 4, STATES = 6 };

static struct Slave slaves[INSTANCES];

static struct Saved {
    fmi2FMUstate state;
    struct Slave from;
} saved[STATES];

/* Check what a call of an instance has returned; true if it was carried out. */
static bool carried_out(const struct Slave *slave, unsigned said_before, int allowed_in, fmi2Status status)
{
    REQUIRE(status == fmi2OK || status == fmi2Error);
    REQUIRE((slave->phase & allowed_in) || status == fmi2Error);
    REQUIRE(said - said_before == (unsigned)(status == fmi2Error && slave->phase != ABSENT));
    return status == fmi2OK;
}

#if !defined FMI3
/* Check what a call for a status has returned: it is told, or discarded, which is said if the importer wants it. */
static void told(const struct Slave *slave, unsigned said_before, bool expected, fmi2Status status)
{
    bool discarded = slave->phase != ABSENT && !expected;
    REQUIRE(status == (slave->phase == ABSENT ? fmi2Error : expected ? fmi2OK : fmi2Discard));
    REQUIRE(said - said_before == (unsigned)(discarded && slave->logging));
}
#endif

#define CALL(slave, allowed_in, call) (before = said, carried_out(slave, before, allowed_in, call))
#define ASK(slave, expected, call) (before = said, told(slave, before, expected, call))

static void instantiate(struct Slave *slave, bool plainly)
{
    unsigned flaws = plainly ? 0 : byte();
    const char *name = flaws % 16 == 1 ? NULL : flaws % 16 == 2 ? "" : slave->name;
    const char *guid = flaws % 16 == 3 ? NULL : flaws % 16 == 4 ? "{another}" : MODEL.guid;
    bool exchange = flaws % 16 == 5 && !MODEL.continuous;   /* of those that can, see fuzz_exchange.c */
    fmi2Type type = exchange ? fmi2ModelExchange : fmi2CoSimulation;
    const fmi2CallbackFunctions *functions = flaws % 16 == 6 ? NULL : &callbacks;
    bool flawed = flaws % 16 > 0 && flaws % 16 <= 6 && (flaws % 16 != 5 || exchange);
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

#if defined FMI3
static void set_up(struct Slave *slave)
{
    unsigned before;
    CALL(slave, 0, fmi3EnterEventMode(slave->component));   /* there is nothing to set up */
}

static void enter(struct Slave *slave)
{
    unsigned before, choice = byte();
    double time = choice % 8 == 0 ? any_value() : 0.0;
    if (CALL(slave, INSTANTIATED,
             fmi3EnterInitializationMode(slave->component, choice % 2, 1e-3, time, choice % 3 == 0, 1.0))) {
        REQUIRE(isfinite(time));
        slave->time = time;
        slave->phase = INITIALIZATION;
    } else {
        REQUIRE(slave->phase != INSTANTIATED || !isfinite(time));
    }
}
#else
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
#endif

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
    static const int READABLE = (INSTANTIATED_READABLE ? INSTANTIATED : 0) | INITIALIZATION | STEPPING | TERMINATED | ERROR;
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
    REQUIRE(done == ((slave->phase & WRITABLE) && variable->causality < OUTPUT   /* INDEPENDENT comes after it */
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
    const int phases = (INSTANTIATED_READABLE ? INSTANTIATED : 0) | INITIALIZATION | STEPPING | TERMINATED | ERROR;
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
    bool discards = count == 0, known = true;
    for (unsigned i = 0; i < count; ++i) {
        unsigned which = byte() % 8;
        chosen[i] = CATEGORIES[which];
        discards = discards || which == 0 || which == 3;
        known = known && which < 5;
    }
    bool on = choice >= 64;
    if (CALL(slave, EVERY, fmi2SetDebugLogging(slave->component, on, count, chosen))) {
        REQUIRE(known);
        slave->logging = on ? discards : slave->logging && !discards;
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

#if defined FMI3
static void what_it_cannot_do(struct Slave *slave)
{
    fmi3ValueReference reference = byte();
    fmi3Float64 value = 0.0;
    fmi3Boolean flag = false;
    fmi3Clock clock = false;
    size_t number = 0;
    unsigned before, count = byte() % 2;
    CALL(slave, 0, fmi3GetDirectionalDerivative(slave->component, &reference, 1, &reference, 1, &value, 1, &value, 1));
    CALL(slave, 0, fmi3GetAdjointDerivative(slave->component, &reference, 1, &reference, 1, &value, 1, &value, 1));
    CALL(slave, 0, fmi3UpdateDiscreteStates(slave->component, &flag, &flag, &flag, &flag, &flag, &value));
    CALL(slave, 0, fmi3GetNumberOfContinuousStates(slave->component, &number));
    CALL(slave, 0, fmi3EnterConfigurationMode(slave->component));
    CALL(slave, 0, fmi3DoStep(slave->component, slave->time, 1e-4, true, &flag, &flag, NULL, &value));
    CALL(slave, 0, fmi3GetFloat64(slave->component, &reference, 1, &value, 2));
    CALL(slave, EVERY, fmi3GetClock(slave->component, &reference, count, &clock));
}
#else
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
    ASK(slave, false, fmi2GetStatus(slave->component, kind, &status));
    ASK(slave, kind == fmi2LastSuccessfulTime, fmi2GetRealStatus(slave->component, kind, &value));
    ASK(slave, false, fmi2GetIntegerStatus(slave->component, kind, &integer));
    ASK(slave, kind == fmi2Terminated, fmi2GetBooleanStatus(slave->component, kind, &truth));
    ASK(slave, false, fmi2GetStringStatus(slave->component, kind, &text));
    CALL(slave, 0, fmi2GetRealStatus(slave->component, kind, NULL));
}
#endif

static void forget_instance(struct Slave *slave)
{
    fmi2FreeInstance(slave->component);
    *slave = (struct Slave){.component = NULL};
}

#endif
