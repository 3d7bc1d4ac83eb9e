/* The memory of instances, and their whole states: saved, restored, written as bytes. */

#ifndef STATE_H
#define STATE_H

#include "instance.h"

/* Memory by the importer's functions, or the C library's if it gives none; zeroed. */
void *allocate(const struct Importer *importer, size_t size);
void release(const struct Importer *importer, void *memory);

enum Status save_state(struct Instance *instance, const char *call, void **place);
enum Status restore_state(struct Instance *instance, const char *call, const void *state);
enum Status free_state(struct Instance *instance, void **place);
enum Status serialized_size(struct Instance *instance, const char *call, const void *state, size_t *size);
enum Status serialize(struct Instance *instance, const char *call, const void *state, void *bytes, size_t size);
enum Status deserialize(struct Instance *instance, const char *call, const void *bytes, size_t size, void **place);

#endif
