/* guards.h, of lamc: the events of a motion: switches of forces, and impacts. */
#ifndef LAMC_GUARDS_H
#define LAMC_GUARDS_H

#include "lamc.h"

/* Sets every mode by the sign of its guard at y = [q, u]: lamc_ode.sense of a motion. */
void lamc_guards_sense(const void *motion, lamc_real t, const lamc_real *y);

/* Turns the modes that do not fit where the run stands, but for round-off: lamc_ode.review of a motion. */
void lamc_guards_review(const void *motion, lamc_real t, const lamc_real *y);

/* Guards that pass from negative to positive, whatever the modes, then their rates: lamc_ode.guards of a motion. */
void lamc_guards_values(const void *motion, lamc_real t, const lamc_real *y, lamc_real *guards);

/* Modes change, and rates do where guards without a mode are struck: lamc_ode.event of a motion. */
lamc_status lamc_guards_event(const void *motion, lamc_real t, lamc_real *y, const lamc_real *struck);

/* Numbers of work that they need beyond the loops' */
long long lamc_guards_work(const lamc_model *model);

#endif /* LAMC_GUARDS_H */
