/* Access to the variables; `call`, here and elsewhere, is the name of the function of FMI. */

#ifndef VARIABLES_H
#define VARIABLES_H

#include "instance.h"

enum Status get_reals(struct Instance *instance, const char *call, const uint32_t references[], size_t count,
                      double values[]);
enum Status set_reals(struct Instance *instance, const char *call, const uint32_t references[], size_t count,
                      const double values[]);

/* Return true if Boolean variables can be read, or set, now; the type of a Boolean differs from version to version. */
bool booleans_readable(struct Instance *instance, const char *call, const uint32_t references[], size_t count,
                       const void *values);
bool booleans_settable(struct Instance *instance, const char *call, const uint32_t references[], size_t count,
                       const void *values);

/* Access to variables of a type that this FMU does not have. */
enum Status get_none(const struct Instance *instance, const char *call, size_t count);
enum Status set_none(const struct Instance *instance, const char *call, size_t count);

/* Return true if a call with these numbers of references and values can be carried out; log the reason if not. */
bool callable(const struct Instance *instance, const char *call, int phases, const void *references, size_t count,
              const void *values);

/* Whether a reference is in a list; whether it is of a continuous state. */
bool listed(const uint32_t references[], size_t count, uint32_t reference);
bool is_state(uint32_t reference);

#endif
