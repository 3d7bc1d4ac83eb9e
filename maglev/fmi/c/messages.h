/* Messages of the FMU to its importer; without an instance nothing is logged. */

#ifndef MESSAGES_H
#define MESSAGES_H

#include "instance.h"

/* Log a message, formatted as by printf, and return REFUSED. */
enum Status refuse(const struct Instance *instance, const char *format, ...);

/* The same for values that the FMU cannot tell: DISCARDED, logged only if the importer has asked for that. */
enum Status discard(const struct Instance *instance, const char *format, ...);

/* For a function that the model description says the FMU does not have. */
enum Status absent(const struct Instance *instance, const char *call);

/* Log that a call is not allowed in the instance's phase, but in these, and return false. */
bool refuse_phase(const struct Instance *instance, const char *call, int phases);

/* Log that a value of an input or parameter is not a number within its range, and return REFUSED. */
enum Status refuse_value(const struct Instance *instance, const struct Variable *variable, double value);

/* Log the text of a status of the block other than 0, in a step from a time (s) over a step size (s). Return REFUSED or
 * DISCARDED. */
enum Status refuse_status(const struct Instance *instance, enum Status as, int64_t status, double time, double step);

/* A double in the fewest digits that give it back, as Python writes it; text has room for NUMBER_LENGTH. */
enum { NUMBER_LENGTH = 40 };
const char *number(double value, char *text);

/* Return true if a call is allowed in the instance's phase; log the reason if not. */
static inline bool allowed(const struct Instance *instance, const char *call, int phases)
{
    return instance && ((instance->state->progress.phase & phases) || refuse_phase(instance, call, phases));
}

#endif
