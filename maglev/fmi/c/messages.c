/* Messages of the FMU to its importer. */

#include "messages.h"


#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LONGEST_MESSAGE = 2000 };

static void say(const struct Instance *instance, enum Status status, const char *category, const char *format,
                va_list arguments)
{
    char message[LONGEST_MESSAGE];
    vsnprintf(message, sizeof message, format, arguments);
    tell(instance, status, category, message);
}

enum Status refuse(const struct Instance *instance, const char *format, ...)
{
    va_list arguments;
    if (instance && instance->importer.logger) {
        va_start(arguments, format);
        say(instance, REFUSED, "logStatusError", format, arguments);
        va_end(arguments);
    }
    return REFUSED;
}

enum Status discard(const struct Instance *instance, const char *format, ...)
{
    va_list arguments;
    if (instance && instance->importer.logger && instance->logging) {
        va_start(arguments, format);
        say(instance, DISCARDED, "logStatusDiscard", format, arguments);
        va_end(arguments);
    }
    return instance ? DISCARDED : REFUSED;
}

enum Status absent(const struct Instance *instance, const char *call)
{
    return refuse(instance, "%s: not supported, as the model description says", call);
}

bool refuse_phase(const struct Instance *instance, const char *call, int phases)
{
    char expected[200] = "";
    /* Phases of them that an instance of this interface can have, if any. */
    int own = phases & (instance->exchange ? ~RUNNING : instance->events ? ~BETWEEN_EVENTS : ~(AT_EVENT | BETWEEN_EVENTS));
    if (own) {
        phases = own;
    }
    for (int phase = INSTANTIATED; phase <= BETWEEN_EVENTS; phase *= 2) {
        if (phases & phase) {
            strcat(strcat(expected, *expected ? " or " : ""), phase_name((enum Phase)phase));
        }
    }
    refuse(instance, "%s %s, expected %s", call, phase_name(instance->state->progress.phase), expected);
    return false;
}

/* Return true if the text, or the text with a last digit larger by one, is read as the value. The function leaves the
 * text that is. Below a power of two the next number is half as far away as above it. */
static bool is_read_as(double value, char *text)
{
    char *last = strchr(text, 'e') - 1;
    if (strtod(text, NULL) != value && *last >= '0' && *last < '9') {
        ++*last;
        if (strtod(text, NULL) != value) {
            --*last;
        }
    }
    return strtod(text, NULL) == value;
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
    } while (!is_read_as(value, text) && ++digits <= 17);
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

enum Status refuse_value(const struct Instance *instance, const struct Variable *variable, double value)
{
    char text[NUMBER_LENGTH], minimum[NUMBER_LENGTH], maximum[NUMBER_LENGTH];
    const char *space = *variable->unit ? " " : "";
    return refuse(instance, "%s = %s%s%s, expected a number from %s to %s%s%s%s", variable->name, number(value, text),
                  space, variable->unit, number(variable->minimum, minimum), number(variable->maximum, maximum), space,
                  variable->unit, variable->hint);
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

/* Return the text of the value that a name in braces stands for. */
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

enum Status refuse_status(const struct Instance *instance, enum Status as, int64_t status, double time, double step)
{
    const char *text = "the block refused with a status that has no text";
    for (size_t i = 0; i < MODEL.refusal_count; ++i) {
        if (MODEL.refusals[i].status == status) {
            text = MODEL.refusals[i].text;
        }
    }
    if (status > MODEL.failed && status - MODEL.failed <= (int64_t)MODEL.failure_count) {
        text = MODEL.failures[status - MODEL.failed - 1];
        return as == DISCARDED ? discard(instance, "%s", text) : refuse(instance, "%s", text);
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
    return as == DISCARDED ? discard(instance, "%s", message) : refuse(instance, "%s", message);
}
