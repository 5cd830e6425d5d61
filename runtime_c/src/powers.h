/* powers.h, of lamc: the power of effects and its integral, their work, along a run. */
#ifndef LAMC_POWERS_H
#define LAMC_POWERS_H

#include "lamc.h"

/* Numbers of work that they need; 0 where the model tells none */
long long lamc_powers_work(const lamc_model *model);

/* power (power_count,), W, at y = [q, u]; leaves no trace in a run under way */
void lamc_powers(const lamc_motion *motion, lamc_real t, const lamc_real *y, lamc_real *power);

/* The same, and 0 for impacts: lamc_ode.integrands of a motion */
void lamc_powers_integrands(const void *motion, lamc_real t, const lamc_real *y, lamc_real *values);

/* Adds the energy that an impact brings to the last of the integrals, and to those of the effects what they gave of what
 * they store at that instant, as a fluid does that moves with a body: lamc_ode.jump of a motion */
void lamc_powers_jump(const void *motion, lamc_real t, const lamc_real *before, const lamc_real *after,
                      lamc_real *integrals);

#endif /* LAMC_POWERS_H */
