/* What metrics.py measures on a recorded run, measured while it is made: the same numbers, bit for bit, for sums go in
   the order of the samples there, too. AXES, BANDS, MOTORS, AMOUNTS, FLAGS, KEPT and the numbers of amounts of each
   motor, first its currents, then its commands, are defined before; measuring.py has the structs as well. */

#define COPPER_RISE {copper}
#define BEYOND_STEADY {transient}

struct seen {
    double position[AXES], reference[AXES];
    double amount[AMOUNTS];     /* A */
    double rise[MOTORS];        /* K */
    double flag[FLAGS];
    double kept[KEPT];
};

/* What is to be measured. */
struct given {
    int64_t points;             /* communication points */
    double step;                /* s */
    const double *bands;        /* half widths, BANDS of each axis */
    int64_t windows;            /* each from a step of any reference, or a disturbance after one, to the next */
    const int64_t *starts;      /* their first samples, and the one behind the last */
    const int64_t *steady;      /* first samples of their steady shares */
    int64_t tracking;           /* first sample of steady tracking, `points` without it */
    double *errors;             /* room for |e| of each axis at all points, where that is measured */
    int64_t events;
    const int64_t *event_starts, *event_ends;
    const double *resistances;  /* of a cold phase of each motor, ohm */
    int64_t every;              /* points from one row that is kept to the next */
    double *kept;               /* rows of so many */
    int64_t keeping;
};

struct window {
    double highest[AXES], lowest[AXES], steady[AXES];   /* of the position minus the reference at its start */
    double outside[AXES * BANDS];                       /* last sample, from its first one on; -1 for none */
    double end[AXES];                                   /* error at its last sample */
    double flagged[FLAGS], flag_at_end[FLAGS];
};

struct event {
    double peak[AXES], integral[AXES];
    double outside[AXES * BANDS];
    double squares[MOTORS], loss[MOTORS];
    double changes[AMOUNTS];
};

struct whole {
    double squares[AXES], end[AXES], tracking[AXES], peak[AXES], beyond[AXES];
    double highest[AMOUNTS], sum[AMOUNTS];
    double flag[FLAGS];                       /* first sample with it, -1 for none */
    double flag_position[FLAGS * AXES], flag_error[FLAGS * AXES];   /* there */
    double before[AXES], flag_before[FLAGS];  /* at the sample before the first step */
};

struct meter {
    int64_t window;             /* number of the present one, -1 before the first */
    struct window present;      /* near the loop: it becomes one of all when it ends */
    double target[AXES];
    double size[AXES], amount[AMOUNTS], loss[MOTORS];   /* at the sample before */
};

static const int64_t amounts_of[MOTORS][3] = AMOUNTS_OF;   /* first current, first command, behind the last */

static inline void begin_window(struct meter *meter, const struct seen *seen)
{
    struct window *const window = &meter->present;
    for (int a = 0; a < AXES; ++a) {
        meter->target[a] = seen->reference[a];
        window->highest[a] = -INFINITY;
        window->lowest[a] = INFINITY;
        window->steady[a] = 0.0;
    }
    for (int i = 0; i < AXES * BANDS; ++i) {
        window->outside[i] = -1.0;
    }
    for (int i = 0; i < FLAGS; ++i) {
        window->flagged[i] = 0.0;
    }
}

static inline void measure_window(const struct given *given, struct meter *meter, struct window *windows, int64_t k,
                                  const struct seen *seen)
{
    struct window *const window = &meter->present;
    const int64_t start = given->starts[meter->window], last = given->starts[meter->window + 1] - 1;
    const bool steady = k >= given->steady[meter->window];
    for (int a = 0; a < AXES; ++a) {
        const double off = seen->position[a] - meter->target[a], size = fabs(off);
        window->highest[a] = off > window->highest[a] ? off : window->highest[a];
        window->lowest[a] = off < window->lowest[a] ? off : window->lowest[a];
        if (steady) {
            window->steady[a] += size;
        }
        for (int b = 0; b < BANDS; ++b) {
            if (size > given->bands[a * BANDS + b]) {
                window->outside[a * BANDS + b] = (double)(k - start);
            }
        }
        if (k == last) {
            window->end[a] = seen->position[a] - seen->reference[a];
        }
    }
    for (int i = 0; i < FLAGS; ++i) {
        window->flagged[i] = seen->flag[i] != 0.0 ? 1.0 : window->flagged[i];
        window->flag_at_end[i] = seen->flag[i];
    }
    if (k == last) {
        windows[meter->window] = *window;
    }
}

static inline void measure_event(const struct given *given, const struct meter *meter, struct event *event, int64_t start,
                                 int64_t k, const struct seen *seen, const double *size, const double *square, const double *loss)
{
    const double apart = (double)k * given->step - (double)(k - 1) * given->step;
    const bool first = k == start;
    for (int a = 0; a < AXES; ++a) {
        event->peak[a] = first || size[a] > event->peak[a] ? size[a] : event->peak[a];
        event->integral[a] = first ? 0.0 : event->integral[a] + (size[a] + meter->size[a]) * apart;
        for (int b = 0; b < BANDS; ++b) {
            double *const outside = &event->outside[a * BANDS + b];
            *outside = size[a] > given->bands[a * BANDS + b] ? (double)(k - start) : first ? -1.0 : *outside;
        }
    }
    for (int m = 0; m < MOTORS; ++m) {
        event->squares[m] = first ? square[m] : event->squares[m] + square[m];
        event->loss[m] = first ? 0.0 : event->loss[m] + (loss[m] + meter->loss[m]) * apart;
    }
    for (int i = 0; i < AMOUNTS; ++i) {
        const double change = seen->amount[i] - meter->amount[i];
        event->changes[i] = first ? 0.0 : event->changes[i] + change * change;
    }
}

static inline void measure_events(const struct given *given, struct meter *meter, struct event *events, int64_t k,
                                  const struct seen *seen, const double *size)
{
    double square[MOTORS], loss[MOTORS];
    for (int m = 0; m < MOTORS; ++m) {
        square[m] = 0.0;
        for (int64_t i = amounts_of[m][0]; i < amounts_of[m][1]; ++i) {
            square[m] = square[m] + seen->amount[i] * seen->amount[i];
        }
        loss[m] = given->resistances[m] * (1.0 + COPPER_RISE * seen->rise[m]) * square[m];
    }
    for (int64_t i = 0; i < given->events; ++i) {
        if (k >= given->event_starts[i] && k < given->event_ends[i]) {
            measure_event(given, meter, &events[i], given->event_starts[i], k, seen, size, square, loss);
        }
    }
    for (int a = 0; a < AXES; ++a) {
        meter->size[a] = size[a];
    }
    for (int i = 0; i < AMOUNTS; ++i) {
        meter->amount[i] = seen->amount[i];
    }
    for (int m = 0; m < MOTORS; ++m) {
        meter->loss[m] = loss[m];
    }
}

/* Last sample at which |e| was beyond the transient of tracking; -1 for none. */
static inline double last_beyond(const struct given *given, int axis, double peak)
{
    int64_t k = given->points - 1;
    while (k >= 0 && !(given->errors[axis * given->points + k] > BEYOND_STEADY * peak)) {
        --k;
    }
    return (double)k;
}

static inline void begin_measuring(struct meter *meter, struct whole *whole)
{
    meter->window = -1;
    for (int a = 0; a < AXES; ++a) {
        whole->squares[a] = whole->tracking[a] = 0.0;
        whole->peak[a] = -INFINITY;
    }
    for (int i = 0; i < AMOUNTS; ++i) {
        whole->highest[i] = whole->sum[i] = 0.0;
    }
    for (int i = 0; i < FLAGS; ++i) {
        whole->flag[i] = -1.0;
    }
    for (int i = 0; i < FLAGS * AXES; ++i) {
        whole->flag_position[i] = whole->flag_error[i] = 0.0;
    }
}

/* Take in what is seen at a communication point. */
static inline void measure(const struct given *given, struct meter *meter, struct whole *whole, struct window *windows,
                           struct event *events, int64_t k, const struct seen *seen)
{
    double size[AXES];
    for (int a = 0; a < AXES; ++a) {
        const double error = seen->position[a] - seen->reference[a];
        size[a] = fabs(error);
        whole->squares[a] += error * error;
        whole->end[a] = error;
        if (k >= given->tracking) {
            whole->tracking[a] += size[a];
            whole->peak[a] = size[a] > whole->peak[a] ? size[a] : whole->peak[a];
        }
        if (given->errors) {
            given->errors[a * given->points + k] = size[a];
        }
    }
    for (int i = 0; i < AMOUNTS; ++i) {
        const double amount = fabs(seen->amount[i]);
        whole->highest[i] = amount > whole->highest[i] ? amount : whole->highest[i];
        whole->sum[i] += amount;
    }
    for (int i = 0; i < FLAGS; ++i) {
        if (seen->flag[i] != 0.0 && whole->flag[i] < 0.0) {
            whole->flag[i] = (double)k;
            for (int a = 0; a < AXES; ++a) {
                whole->flag_position[i * AXES + a] = seen->position[a];
                whole->flag_error[i * AXES + a] = seen->position[a] - seen->reference[a];
            }
        }
    }
    if (meter->window + 1 < given->windows && k == given->starts[meter->window + 1]) {
        ++meter->window;
        begin_window(meter, seen);
    }
    if (meter->window >= 0) {
        measure_window(given, meter, windows, k, seen);
    } else if (k == given->starts[0] - 1) {
        for (int a = 0; a < AXES; ++a) {
            whole->before[a] = seen->position[a] - seen->reference[a];
        }
        for (int i = 0; i < FLAGS; ++i) {
            whole->flag_before[i] = seen->flag[i];
        }
    }
    if (given->events) {
        measure_events(given, meter, events, k, seen, size);
    }
    if (given->keeping && k % given->every == 0) {
        for (int i = 0; i < KEPT; ++i) {
            given->kept[k / given->every * KEPT + i] = seen->kept[i];
        }
    }
    if (given->errors && k == given->points - 1) {
        for (int a = 0; a < AXES; ++a) {
            whole->beyond[a] = last_beyond(given, a, whole->peak[a]);
        }
    }
}

/* The struct Observer of measuring.py. */
struct observer {
    struct given given;
    struct meter *meter;
    struct whole *whole;
    struct window *windows;
    struct event *events;
};

static inline void observe(struct observer *observer, int64_t k, const struct seen *seen)
{
    if (k == 0) {
        begin_measuring(observer->meter, observer->whole);
    }
    measure(&observer->given, observer->meter, observer->whole, observer->windows, observer->events, k, seen);
}
