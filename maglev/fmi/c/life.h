/* Instances from their beginning to their end: phases and steps. */

#ifndef LIFE_H
#define LIFE_H

#include "instance.h"

/* A new instance, or NULL and a message. The key of the FMU (GUID, instantiation token) has a name for the message. */
struct Instance *created(const struct Importer *importer, const char *name, bool exchange, bool logging,
                         const char *key_name, const char *key);
void freed(struct Instance *instance);

/* Let a new instance of a sampled FMU use event mode, and perhaps end its steps early. */
void use_events(struct Instance *instance, bool early);
enum Status set_logging(struct Instance *instance, bool on, size_t count, const char *const categories[]);

/* Start and stop time, s; the latter infinite if there is none. */
enum Status set_times(struct Instance *instance, const char *call, double start, double stop);
enum Status enter_initialization(struct Instance *instance, const char *call);
enum Status exit_initialization(struct Instance *instance, const char *call);
enum Status take_step(struct Instance *instance, const char *call, double time, double size);
enum Status end_run(struct Instance *instance, const char *call);
enum Status begin_anew(struct Instance *instance);

#endif
