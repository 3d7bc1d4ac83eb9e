/* What the FMU says to its importer. */

#include "instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LONGEST_MESSAGE = 2000 };

static void say(const struct Instance *instance, fmi2Status status, const char *category, const char *format,
                va_list arguments)
{
    char message[LONGEST_MESSAGE];
    vsnprintf(message, sizeof message, format, arguments);
    /* The message is no format: it may have a per cent sign in it. */
    instance->callbacks.logger(instance->callbacks.componentEnvironment, instance->name, status, category, "%s",
                               message);
}

fmi2Status refuse(const struct Instance *instance, const char *format, ...)
{
    va_list arguments;
    if (instance && instance->callbacks.logger) {
        va_start(arguments, format);
        say(instance, fmi2Error, "logStatusError", format, arguments);
        va_end(arguments);
    }
    return fmi2Error;
}

fmi2Status discard(const struct Instance *instance, const char *format, ...)
{
    va_list arguments;
    if (instance && instance->callbacks.logger && instance->logging) {
        va_start(arguments, format);
        say(instance, fmi2Discard, "logStatusDiscard", format, arguments);
        va_end(arguments);
    }
    return instance ? fmi2Discard : fmi2Error;
}

static const char *phase_name(enum Phase phase)
{
    switch (phase) {
    case INSTANTIATED: return "before fmi2EnterInitializationMode";
    case INITIALIZING: return "in the initialization";
    case RUNNING: return "after the initialization";
    case TERMINATED: return "after fmi2Terminate";
    default: return "after an error";
    }
}

bool allowed(const struct Instance *instance, const char *call, int phases)
{
    if (!instance || (instance->progress.phase & phases)) {
        return instance != NULL;
    }
    char expected[200] = "";
    for (int phase = INSTANTIATED; phase <= FAILED; phase *= 2) {
        if (phases & phase) {
            strcat(strcat(expected, *expected ? " or " : ""), phase_name((enum Phase)phase));
        }
    }
    refuse(instance, "%s %s, expected %s", call, phase_name(instance->progress.phase), expected);
    return false;
}

const char *number(double value, char *text)
{
    if (isnan(value)) {
        return strcpy(text, "nan");
    }
    if (isinf(value)) {
        return strcpy(text, value > 0.0 ? "inf" : "-inf");
    }
    int digits = 1;
    do {
        snprintf(text, NUMBER_LENGTH, "%.*e", digits - 1, value);
    } while (strtod(text, NULL) != value && ++digits <= 17);
    int exponent = atoi(strchr(text, 'e') + 1);
    if (exponent >= -4 && exponent < 16) {
        int decimals = digits - 1 - exponent;
        snprintf(text, NUMBER_LENGTH, "%.*f", decimals > 1 ? decimals : 1, value);
    }
    /* The host may have set a locale with another decimal separator. */
    for (char *at = text; *at; ++at) {
        if (*at == ',') {
            *at = '.';
        }
    }
    return text;
}

static const struct Variable *find(const char *name, size_t length)
{
    for (size_t i = 0; i < MODEL.variable_count; ++i) {
        const struct Variable *variable = &MODEL.variables[i];
        if (strlen(variable->name) == length && strncmp(variable->name, name, length) == 0) {
            return variable;
        }
    }
    return NULL;
}

/* Value of what stands in braces. */
static const char *named_value(const struct Instance *instance, const char *name, size_t length, double time,
                               double step, char *text)
{
    if (length == 4 && strncmp(name, "time", length) == 0) {
        return number(time, text);
    }
    if (length == 4 && strncmp(name, "step", length) == 0) {
        return number(step, text);
    }
    const struct Variable *variable = find(name, length);
    if (!variable) {
        return "?";   /* the build has checked that there is none */
    }
    if (variable->boolean) {
        return *boolean_at(instance, variable) ? "True" : "False";
    }
    return number(*real_at(instance, variable), text);
}

fmi2Status refuse_status(const struct Instance *instance, int64_t status, double time, double step)
{
    const char *text = "the block refused with a status that has no text";
    for (size_t i = 0; i < MODEL.refusal_count; ++i) {
        if (MODEL.refusals[i].status == status) {
            text = MODEL.refusals[i].text;
        }
    }
    char message[LONGEST_MESSAGE];
    char value[NUMBER_LENGTH];
    size_t used = 0;
    while (*text && used < sizeof message - 1) {
        const char *end = *text == '{' ? strchr(text, '}') : NULL;
        if (end) {
            int wrote = snprintf(message + used, sizeof message - used, "%s",
                                 named_value(instance, text + 1, (size_t)(end - text - 1), time, step, value));
            used += (size_t)wrote;
            text = end + 1;
        } else {
            message[used++] = *text++;
        }
    }
    message[used < sizeof message ? used : sizeof message - 1] = '\0';
    return refuse(instance, "%s", message);
}
