/* The memory of instances, and their whole states: saved, restored, written as bytes. */

#include "state.h"

#include "messages.h"

#include <stdlib.h>
#include <string.h>

/* A single memory function of the importer cannot be used: memory has to return to its allocator. */
static bool manages_memory(const struct Importer *importer)
{
    return importer->allocate && importer->release;
}

void *allocate(const struct Importer *importer, size_t size)
{
    return manages_memory(importer) ? importer->allocate(1, size) : calloc(1, size);
}

void release(const struct Importer *importer, void *memory)
{
    if (!manages_memory(importer)) {
        free(memory);
    } else if (memory) {
        importer->release(memory);
    }
}

/* Serialized: the GUID, so that no other FMU takes it, the checksum of the rest, and the state. */
static size_t guid_size(void)
{
    return strlen(MODEL.guid) + 1;
}

static size_t head_size(void)
{
    return guid_size() + sizeof(uint64_t);
}

static size_t bytes_size(bool events)
{
    return head_size() + state_size(events);
}

/* FNV-1a. */
static uint64_t checksum(const void *bytes, size_t size)
{
    uint64_t hash = UINT64_C(14695981039346656037);
    for (size_t i = 0; i < size; ++i) {
        hash = (hash ^ ((const unsigned char *)bytes)[i]) * UINT64_C(1099511628211);
    }
    return hash;
}

/* Return true if a state is of an instance for the same purpose. */
static bool fits(const struct Instance *instance, const struct RunState *state)
{
    if (state->progress.exchange != instance->exchange) {
        refuse(instance, "state of an instance for %s, expected one for %s",
               instance->exchange ? "co-simulation" : "model exchange",
               instance->exchange ? "model exchange" : "co-simulation");
    }
    if (state->progress.events != instance->events) {
        refuse(instance, "state of an instance %s event mode, expected one %s it", instance->events ? "without" : "with",
               instance->events ? "with" : "without");
    }
    return state->progress.exchange == instance->exchange && state->progress.events == instance->events;
}

enum Status save_state(struct Instance *instance, const char *call, void **place)
{
    if (!instance || !place) {
        return refuse(instance, "%s with a null pointer, expected a place for the state", call);
    }
    if (!*place) {
        *place = allocate(&instance->importer, state_room());
    }
    if (!*place) {
        return refuse(instance, "out of memory");
    }
    memcpy(*place, instance->state, state_size(instance->events));
    if (instance->events && !sample_tried(&instance->state->progress)) {
        memset(before_sample(*place), 0, MODEL.block_size);   /* so that equal states are equal bytes */
    }
    return DONE;
}

enum Status restore_state(struct Instance *instance, const char *call, const void *state)
{
    if (!instance || !state) {
        return refuse(instance, "%s with a null pointer, expected a state", call);
    }
    if (!fits(instance, state)) {
        return REFUSED;
    }
    memcpy(instance->state, state, state_size(instance->events));
    return DONE;
}

enum Status free_state(struct Instance *instance, void **place)
{
    if (!instance) {
        return REFUSED;
    }
    if (place && *place) {
        release(&instance->importer, *place);
        *place = NULL;
    }
    return DONE;
}

enum Status serialized_size(struct Instance *instance, const char *call, const void *state, size_t *size)
{
    if (!instance || !state || !size) {
        return refuse(instance, "%s with a null pointer, expected a state and a place for its size", call);
    }
    *size = bytes_size(((const struct RunState *)state)->progress.events);
    return DONE;
}

enum Status serialize(struct Instance *instance, const char *call, const void *state, void *bytes, size_t size)
{
    char *to = bytes;
    const struct RunState *from = state;
    if (!instance || !state || !bytes) {
        return refuse(instance, "%s with a null pointer, expected a state and a place for its bytes", call);
    }
    bool events = from->progress.events;
    if (size < bytes_size(events)) {
        return refuse(instance, "room for a serialized state = %u bytes, expected %u", (unsigned)size,
                      (unsigned)bytes_size(events));
    }
    uint64_t hash = checksum(state, state_size(events));
    memcpy(to, MODEL.guid, guid_size());
    memcpy(to + guid_size(), &hash, sizeof hash);
    memcpy(to + head_size(), state, state_size(events));
    return DONE;
}

enum Status deserialize(struct Instance *instance, const char *call, const void *bytes, size_t size, void **place)
{
    const char *from = bytes;
    uint64_t hash;
    if (!instance || !bytes || !place) {
        return refuse(instance, "%s with a null pointer, expected bytes and a place for the state", call);
    }
    bool events = false;
    bool own = size >= bytes_size(false) && memcmp(from, MODEL.guid, guid_size()) == 0;
    if (own) {
        memcpy(&hash, from + guid_size(), sizeof hash);
        events = MODEL.sampling && from[head_size() + offsetof(struct RunState, progress.events)] != 0;
        own = size >= bytes_size(events) && hash == checksum(from + head_size(), state_size(events));
    }
    if (!own) {
        return refuse(instance, "serialized state of %u bytes, expected %u bytes that this FMU has written",
                      (unsigned)size, (unsigned)bytes_size(instance->events));
    }
    if (!*place) {
        *place = allocate(&instance->importer, state_room());
    }
    if (!*place) {
        return refuse(instance, "out of memory");
    }
    memcpy(*place, from + head_size(), state_size(events));
    return DONE;
}
