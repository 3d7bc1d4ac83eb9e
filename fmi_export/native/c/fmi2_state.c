/* The whole state of an instance: saved, restored, written as bytes. */

#include "instance.h"

#include <string.h>

/* A saved state; the block follows it. */
struct State {
    struct Progress progress;
    double block[];   /* of the alignment that a block needs */
};

static size_t state_size(void)
{
    return sizeof(struct State) + MODEL.block_size;
}

/* As bytes: the GUID, so that no other FMU takes it, the checksum of what follows, and the state. */
static size_t guid_size(void)
{
    return strlen(MODEL.guid) + 1;
}

static size_t serialized_size(void)
{
    return guid_size() + sizeof(uint64_t) + state_size();
}

/* FNV-1a. */
static uint64_t checksum(const fmi2Byte *bytes, size_t size)
{
    uint64_t hash = UINT64_C(14695981039346656037);
    for (size_t i = 0; i < size; ++i) {
        hash = (hash ^ (unsigned char)bytes[i]) * UINT64_C(1099511628211);
    }
    return hash;
}

static void save(const struct Instance *instance, struct State *state)
{
    /* Member by member: padding stays zero, so that equal states are equal bytes. */
    state->progress.phase = instance->progress.phase;
    state->progress.stale = instance->progress.stale;
    state->progress.suspect = instance->progress.suspect;
    state->progress.timed = instance->progress.timed;
    state->progress.next_time = instance->progress.next_time;
    state->progress.stop_time = instance->progress.stop_time;
    memcpy(state->block, instance->block, MODEL.block_size);
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    struct Instance *instance = c;
    if (!instance || !FMUstate) {
        return refuse(instance, "fmi2GetFMUstate with a null pointer, expected a place for the state");
    }
    if (!*FMUstate) {
        *FMUstate = allocate(&instance->callbacks, state_size());
    }
    if (!*FMUstate) {
        return refuse(instance, "out of memory");
    }
    save(instance, *FMUstate);
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate)
{
    struct Instance *instance = c;
    const struct State *state = FMUstate;
    if (!instance || !state) {
        return refuse(instance, "fmi2SetFMUstate with a null pointer, expected a state");
    }
    instance->progress = state->progress;
    memcpy(instance->block, state->block, MODEL.block_size);
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    struct Instance *instance = c;
    if (!instance) {
        return fmi2Error;
    }
    if (FMUstate && *FMUstate) {
        release(&instance->callbacks, *FMUstate);
        *FMUstate = NULL;
    }
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size)
{
    if (!c || !FMUstate || !size) {
        return refuse(c, "fmi2SerializedFMUstateSize with a null pointer, expected a state and a place for its size");
    }
    *size = serialized_size();
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[], size_t size)
{
    if (!c || !FMUstate || !serializedState) {
        return refuse(c, "fmi2SerializeFMUstate with a null pointer, expected a state and a place for its bytes");
    }
    if (size < serialized_size()) {
        return refuse(c, "room for a serialized state = %u bytes, expected %u", (unsigned)size,
                      (unsigned)serialized_size());
    }
    uint64_t hash = checksum(FMUstate, state_size());
    memcpy(serializedState, MODEL.guid, guid_size());
    memcpy(serializedState + guid_size(), &hash, sizeof hash);
    memcpy(serializedState + guid_size() + sizeof hash, FMUstate, state_size());
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate *FMUstate)
{
    struct Instance *instance = c;
    uint64_t hash;
    if (!instance || !serializedState || !FMUstate) {
        return refuse(instance,
                      "fmi2DeSerializeFMUstate with a null pointer, expected bytes and a place for the state");
    }
    bool own = size >= serialized_size() && memcmp(serializedState, MODEL.guid, guid_size()) == 0;
    if (own) {
        memcpy(&hash, serializedState + guid_size(), sizeof hash);
        own = hash == checksum(serializedState + guid_size() + sizeof hash, state_size());
    }
    if (!own) {
        return refuse(instance, "serialized state of %u bytes, expected %u bytes that this FMU has written",
                      (unsigned)size, (unsigned)serialized_size());
    }
    if (!*FMUstate) {
        *FMUstate = allocate(&instance->callbacks, state_size());
    }
    if (!*FMUstate) {
        return refuse(instance, "out of memory");
    }
    memcpy(*FMUstate, serializedState + guid_size() + sizeof hash, state_size());
    return fmi2OK;
}
