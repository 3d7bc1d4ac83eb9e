/* Interface of a block for the FMI layer: tables that the build generates, one set for each FMU. */

#ifndef MODEL_H
#define MODEL_H

#include "prefix.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum Causality { PARAMETER, INPUT, OUTPUT, LOCAL, INDEPENDENT };

/* An FMI variable; its value reference is its place in the table. */
struct Variable {
    const char *name;
    const char *unit;            /* empty for ratios and Booleans */
    size_t offset;               /* of the value in struct RunState: a double, or a bool */
    bool boolean;
    bool discrete;               /* at events alone it changes */
    bool fixed;                  /* a parameter that cannot change once the initialization has ended */
    enum Causality causality;
    double minimum, maximum;     /* of inputs and parameters */
    const char *hint;            /* end of the message about a value that is out of range */
};

/* Text for a status of the block; names of variables, time and step are in braces. */
struct Refusal {
    int64_t status;
    const char *text;
};

/* A block as a continuous model, whose states an importer integrates. */
struct Continuous {
    const uint32_t *states, *rates;       /* references of the states, and of their derivatives */
    const double *nominals;               /* of the states */
    size_t state_count;
    const uint32_t *indicators;           /* references of values that change their sign at an event */
    size_t indicator_count;
    int64_t (*derive)(void *block);       /* all that is continuous; 0, or the status of a refusal */
    bool (*settle)(void *block);          /* take in an event; whether a state jumps */
    /* Derivatives along a direction, itself a block: of continuous values, of the start, of encoder readings. */
    int64_t (*differentiate)(void *block, void *direction);
    int64_t (*differentiate_start)(void *block, void *direction);
    void (*differentiate_measurement)(void *block, void *direction);
};

/* A block that samples: at the start time, then one after each interval. */
struct Sampling {
    bool clocked;                         /* a clock of the importer's says when; inputs and outputs are of that clock */
    uint32_t clock;                       /* its reference */
};

struct Model {
    const char *name;
    const char *guid;                                          /* in FMI 3.0 the instantiation token */
    size_t block_size;
    const void *initial;                                       /* the initial block */
    int64_t (*start)(void *block);                             /* 0, or the status of a refusal */
    int64_t (*step)(void *block, double time, double step);    /* the same; s, s */
    bool variable_step;                                        /* any step fits */
    size_t interval;                                           /* offset of the sample time in struct RunState, or 0 */
    const struct Variable *variables;
    size_t variable_count;
    const uint8_t *sizes;                                      /* of the arrays that begin there; NULL without arrays */
    const struct Refusal *refusals;
    size_t refusal_count;
    int64_t failed;                                            /* status: this and the number, from 1 on, of a failure */
    const char *const *failures;
    size_t failure_count;
    const struct Continuous *continuous;                       /* NULL if it is for co-simulation alone */
    const struct Sampling *sampling;                           /* NULL if it has no event mode in co-simulation */
};

extern const struct Model MODEL;

#endif
