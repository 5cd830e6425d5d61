/* linearise.h, of lamc: the Jacobian of a motion, for implicit methods. */
#ifndef LAMC_LINEARISE_H
#define LAMC_LINEARISE_H

#include "lamc.h"

/* Doubles of scratch, and the cost of one call in evaluations of the accelerations */
long long lamc_linearise_scratch(const lamc_model *model);
double lamc_linearise_cost(const lamc_motion *motion);

/* d(udot)/dq (n, n), d(udot)/du (n, n), d(udot)/dt (n,) at y = [q, u]: lamc_ode.jacobian of a motion */
void lamc_linearise(const void *motion, double t, const double *y, double *by_q, double *by_u, double *by_t,
                    double *scratch);

#endif /* LAMC_LINEARISE_H */
