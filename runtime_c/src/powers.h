/* powers.h, of lamc: the power of effects and its integral, their work, along a run. */
#ifndef LAMC_POWERS_H
#define LAMC_POWERS_H

#include "lamc.h"

/* Doubles of work that they need; 0 where the model tells none */
long long lamc_powers_work(const lamc_model *model);

/* power (power_count,), W, at y = [q, u]; leaves no trace in a run under way */
void lamc_powers(const lamc_motion *motion, double t, const double *y, double *power);

/* The same, and 0 for impacts: lamc_ode.integrands of a motion */
void lamc_powers_integrands(const void *motion, double t, const double *y, double *values);

/* Adds the energy that an impact brings to the last of the integrals, and to those of the effects what they gave of what
 * they store at that instant, as a fluid does that moves with a body: lamc_ode.jump of a motion */
void lamc_powers_jump(const void *motion, double t, const double *before, const double *after,
                      double *integrals);

#endif /* LAMC_POWERS_H */
