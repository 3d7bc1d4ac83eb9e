/* Places of the values of @NAME@ that an emulator's host sets and reads. */

#include <stddef.h>

struct Place {
    uint16_t offset;
    bool boolean;
};

static const struct Place SETTABLE[] = {
@SETTABLE@
};

static const struct {
    struct Place place;
    uint16_t settable;
} INPUTS[] = {
@INPUTS@
};

static const struct Place READABLE[] = {
@READABLE@
};

static const struct Place OUTPUTS[] = {
@OUTPUTS@
};
