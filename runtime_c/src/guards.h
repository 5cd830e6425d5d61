/* guards.h, of lamc: the events of a motion: switches of forces, and impacts. */
#ifndef LAMC_GUARDS_H
#define LAMC_GUARDS_H

#include "lamc.h"

/* Sets every mode by the sign of its guard at y = [q, u]: lamc_ode.sense of a motion. */
void lamc_guards_sense(const void *motion, double t, const double *y);

/* Guards that pass from negative to positive, whatever the modes, then their rates: lamc_ode.guards of a motion. */
void lamc_guards_values(const void *motion, double t, const double *y, double *guards);

/* Modes change, and rates do where guards without a mode are struck: lamc_ode.event of a motion. */
lamc_status lamc_guards_event(const void *motion, double t, double *y, const double *struck);

/* Doubles of work that they need beyond the loops' */
long long lamc_guards_work(const lamc_model *model);

#endif /* LAMC_GUARDS_H */
