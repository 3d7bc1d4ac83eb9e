/* The importer of the fuzz driver: its functions, its account of the instances, and the bytes that decide. */

#ifndef FUZZ_IMPORTER_H
#define FUZZ_IMPORTER_H

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined FMI3
#include "fuzz_fmi3.h"
enum { INSTANTIATED_READABLE = 1 };   /* the start values */
#else
#include "fmi2Functions.h"
enum { INSTANTIATED_READABLE = 0 };
#endif
#include "model.h"

enum { MOST = 12 };

/* As FMI names them; ABSENT is one that is not there. */
enum Phase { ABSENT = 0, INSTANTIATED = 1, INITIALIZATION = 2, STEPPING = 4, TERMINATED = 8, ERROR = 16 };
enum { EVERY = INSTANTIATED | INITIALIZATION | STEPPING | TERMINATED | ERROR };

struct Slave {
    fmi2Component component;
    int phase;
    bool logging;
    double time;
    char name[16];
};

static unsigned program;                    /* the one that runs */
static const unsigned char *at, *end;       /* what is left of it */
static long allocated;                      /* pieces of memory that the FMU holds */
static int until_failure;                   /* allocations until one fails; 0 for never */
static unsigned said;                       /* messages */
static int surroundings;                    /* componentEnvironment: its address is what counts */

#define REQUIRE(condition) require(condition, #condition, __FILE__, __LINE__)

static void require(bool condition, const char *text, const char *file, int line)
{
    if (!condition) {
        fprintf(stderr, "program %u, %s, line %d: %s\n", program, file, line, text);
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
    REQUIRE((status == fmi2Error && strcmp(category, "logStatusError") == 0)
            || (status == fmi2Discard && strcmp(category, "logStatusDiscard") == 0));
    ++said;
}

static fmi2CallbackFunctions callbacks;

#endif
