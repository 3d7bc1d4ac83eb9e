/* The whole state of an instance: saved, restored, written as bytes. */

#include "instance.h"

#include <string.h>

static size_t state_size(void)
{
    return sizeof(struct RunState) + MODEL.block_size;
}

/* As bytes: the GUID, so that no other FMU takes it, the checksum of what follows, and the state. */
static size_t guid_size(void)
{
    return strlen(MODEL.guid) + 1;
}

static size_t bytes_size(void)
{
    return guid_size() + sizeof(uint64_t) + state_size();
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

/* Whether a state is of an instance for the same purpose. */
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
        *place = allocate(&instance->importer, state_size());
    }
    if (!*place) {
        return refuse(instance, "out of memory");
    }
    memcpy(*place, instance->state, state_size());
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
    memcpy(instance->state, state, state_size());
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
    *size = bytes_size();
    return DONE;
}

enum Status serialize(struct Instance *instance, const char *call, const void *state, void *bytes, size_t size)
{
    char *to = bytes;
    if (!instance || !state || !bytes) {
        return refuse(instance, "%s with a null pointer, expected a state and a place for its bytes", call);
    }
    if (size < bytes_size()) {
        return refuse(instance, "room for a serialized state = %u bytes, expected %u", (unsigned)size,
                      (unsigned)bytes_size());
    }
    uint64_t hash = checksum(state, state_size());
    memcpy(to, MODEL.guid, guid_size());
    memcpy(to + guid_size(), &hash, sizeof hash);
    memcpy(to + guid_size() + sizeof hash, state, state_size());
    return DONE;
}

enum Status deserialize(struct Instance *instance, const char *call, const void *bytes, size_t size, void **place)
{
    const char *from = bytes;
    uint64_t hash;
    if (!instance || !bytes || !place) {
        return refuse(instance, "%s with a null pointer, expected bytes and a place for the state", call);
    }
    bool own = size >= bytes_size() && memcmp(from, MODEL.guid, guid_size()) == 0;
    if (own) {
        memcpy(&hash, from + guid_size(), sizeof hash);
        own = hash == checksum(from + guid_size() + sizeof hash, state_size());
    }
    if (!own) {
        return refuse(instance, "serialized state of %u bytes, expected %u bytes that this FMU has written",
                      (unsigned)size, (unsigned)bytes_size());
    }
    if (!*place) {
        *place = allocate(&instance->importer, state_size());
    }
    if (!*place) {
        return refuse(instance, "out of memory");
    }
    memcpy(*place, from + guid_size() + sizeof hash, state_size());
    return DONE;
}
