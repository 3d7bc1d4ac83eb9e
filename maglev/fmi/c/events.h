/* Event mode: of model exchange, and of sampled FMUs in co-simulation. */

#ifndef EVENTS_H
#define EVENTS_H

#include "instance.h"

void begin_event(struct Instance *instance);
enum Status enter_event(struct Instance *instance, const char *call);

/* End an instant; `next` is the time of the next event (s), infinite if the importer knows it or there is none. */
enum Status take_event(struct Instance *instance, const char *call, bool *states_changed, double *next);

/* Leave event mode, of model exchange and of co-simulation. */
enum Status leave_event(struct Instance *instance, const char *call);
enum Status enter_steps(struct Instance *instance, const char *call);

/* Let time pass until the end of a step (s), in which no sample is taken: `end` becomes where it ends. */
enum Status hold(struct Instance *instance, double *end);

/* Return true if a call is about the clock, and allowed in these phases. */
enum Status clocks_known(const struct Instance *instance, const char *call, int phases, const uint32_t references[],
                         size_t count, const void *values);

/* Access to the clock; values are whether it is active. */
enum Status set_clocks(struct Instance *instance, const char *call, const uint32_t references[], size_t count,
                       const bool values[]);
enum Status get_clocks(struct Instance *instance, const char *call, const uint32_t references[], size_t count,
                       bool values[]);

/* Interval of the clock, s, and whether it is still new to the importer; refusal of a call that sets it. */
enum { INTERVAL_READABLE = INITIALIZING | AT_EVENT };
double told_interval(struct Instance *instance, bool *changed);
enum Status set_interval(const struct Instance *instance, const char *call);

#endif
