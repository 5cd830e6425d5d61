/* linearise.h, of lamc: the Jacobian of a motion, for implicit methods. */
#ifndef LAMC_LINEARISE_H
#define LAMC_LINEARISE_H

#include "lamc.h"

/* Numbers of scratch, and the cost of one call in evaluations of the accelerations */
long long lamc_linearise_scratch(const lamc_model *model);
lamc_real lamc_linearise_cost(const lamc_motion *motion);

/* d(udot)/dq (nu, nq), d(udot)/du (nu, nu), d(udot)/dt (nu,) at y = [q, u]: lamc_ode.jacobian of a motion with dq/dt = u */
void lamc_linearise(const void *motion, lamc_real t, const lamc_real *y, lamc_real *by_q, lamc_real *by_u,
                    lamc_real *by_t, lamc_real *scratch);

/* Derivatives of dy/dt by y and by t: lamc_ode.full_jacobian of other motions */
void lamc_linearise_fully(const void *motion, lamc_real t, const lamc_real *y, lamc_real *by_y,
                          lamc_real *by_t, lamc_real *scratch);

#endif /* LAMC_LINEARISE_H */
