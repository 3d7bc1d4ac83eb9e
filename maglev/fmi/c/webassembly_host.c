/* Functions that a host not written in C cannot provide: FMI's callbacks, with a logger that keeps the last message. */

#include "prefix.h"

#include <stdarg.h>
#include <stdio.h>

#include "fmi2Functions.h"

static char message[2000];

static void keep(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                 fmi2String format, ...)
{
    va_list arguments;
    (void)environment;
    (void)name;
    (void)status;
    (void)category;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
}

/* Without functions for memory: instances take the C library's. */
static const fmi2CallbackFunctions CALLBACKS = {.logger = keep};

/* Callbacks for fmi2Instantiate. */
FMI2_Export const fmi2CallbackFunctions *maglevCallbacks(void);

const fmi2CallbackFunctions *maglevCallbacks(void)
{
    return &CALLBACKS;
}

/* The last message of any instance of this module, in UTF-8; empty if there was none. */
FMI2_Export const char *maglevMessage(void);

const char *maglevMessage(void)
{
    return message;
}
