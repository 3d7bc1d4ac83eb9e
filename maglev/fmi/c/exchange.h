/* Model exchange: states, rates, indicators, derivatives. */

#ifndef EXCHANGE_H
#define EXCHANGE_H

#include "instance.h"

/* Return true if an instance is for model exchange and a call is allowed in its phase; log the reason if not. */
bool exchanging(const struct Instance *instance, const char *call, int phases);

/* Accept a step of the solver; whether an output that only events change would change at an event here. */
enum Status complete_step(struct Instance *instance, const char *call, bool *event);
enum Status set_time(struct Instance *instance, const char *call, double time);
enum Status set_states(struct Instance *instance, const char *call, const double values[], size_t count);
enum Status get_states(struct Instance *instance, const char *call, double values[], size_t count);
enum Status get_nominals(struct Instance *instance, const char *call, double values[], size_t count);
enum Status get_rates(struct Instance *instance, const char *call, double values[], size_t count);
enum Status get_indicators(struct Instance *instance, const char *call, double values[], size_t count);

/* Derivatives of unknowns along a seed of knowns, and of a seed of unknowns by each known. */
enum Status differentiate(struct Instance *instance, const char *call, const uint32_t unknowns[], size_t unknown_count,
                          const uint32_t knowns[], size_t known_count, const double seed[], double sensitivity[]);
enum Status differentiate_adjoint(struct Instance *instance, const char *call, const uint32_t unknowns[],
                                  size_t unknown_count, const uint32_t knowns[], size_t known_count,
                                  const double seed[], double sensitivity[]);

#endif
