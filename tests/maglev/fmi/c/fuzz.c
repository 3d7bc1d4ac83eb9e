/* Reads programs, each a string of bytes, and carries them out as FMI calls on a few instances: in any order, with any
 * values, null pointers, references that do not exist, memory that runs out, states that are truncated or garbled.
 *
 * What has to hold is checked here, in an account of the phases of its own: a call is refused where FMI 2.0.4 (table of
 * figure 11) does not allow it, every refusal is said to the importer, numbers stay finite, and no memory is left. The
 * sanitizers, or valgrind, see the rest.
 *
 * fuzz FILE; in the file, before each program, its length: two bytes, the lower first. */

#include "fuzz_calls.h"

static void run(void)
{
    /* Either function for memory may be missing; then the FMU has to use the C library's. */
    unsigned missing = byte() % 8;
    callbacks.allocateMemory = missing == 1 || missing == 3 ? NULL : give;
    callbacks.freeMemory = missing == 2 || missing == 3 ? NULL : take;
    instantiate(&slaves[0], true);
    while (at < end) {
        unsigned what = byte(), who = byte();
        struct Slave *slave = &slaves[who % INSTANCES];
        struct Saved *one = &saved[who / INSTANCES % STATES], *other = &saved[who / (INSTANCES * STATES) % STATES];
        switch (what % 24) {
        case 0: instantiate(slave, false); break;
        case 1: if (who >= 192) forget_instance(slave); break;
        case 2: set_up(slave); break;
        case 3: enter(slave); break;
        case 4: leave(slave); break;
        case 5:
        case 6:
            instantiate(slave, true);
            set_up(slave);
            enter(slave);
            leave(slave);
            break;
        case 7: set_reals(slave); break;
        case 8: get_some(slave); break;
        case 9: get_all(slave); break;
        case 10: other_types(slave); break;
        case 11: save(slave, one); break;
        case 12: restore(slave, one); break;
        case 13: forget(slave, one); break;
        case 14: by_post(slave, one, other); break;
        case 15: talk(slave); break;
        case 16: end_or_reset(slave); break;
        case 17: what_it_cannot_do(slave); break;
        case 18:
        case 19: set_one(slave); break;
        default: step(slave); break;
        }
    }
    for (unsigned i = 0; i < INSTANCES; ++i) {
        forget_instance(&slaves[i]);
    }
    /* States outlive instances; it takes one to free them. */
    instantiate(&slaves[0], true);
    for (unsigned i = 0; i < STATES; ++i) {
        REQUIRE(fmi2FreeFMUstate(slaves[0].component, &saved[i].state) == fmi2OK && saved[i].state == NULL);
    }
    forget_instance(&slaves[0]);
    REQUIRE(allocated == 0);
}

int main(int argc, char **argv)
{
    unsigned char length[2];
    FILE *file = argc == 2 ? fopen(argv[1], "rb") : NULL;
    REQUIRE(file != NULL);
    callbacks.logger = listen;
    callbacks.componentEnvironment = &surroundings;
    while (fread(length, 1, 2, file) == 2) {
        size_t size = length[0] + 256u * length[1];
        unsigned char *bytes = malloc(size + 1);
        REQUIRE(fread(bytes, 1, size, file) == size);
        at = bytes;
        end = bytes + size;
        run();
        free(bytes);
        ++program;
    }
    fclose(file);
    printf("%u programs, %u refusals\n", program, said);
    return 0;
}
