/* motion.h, of lamc: accelerations of a motion, whichever way its model gives them. */
#ifndef LAMC_MOTION_H
#define LAMC_MOTION_H

#include "lamc.h"

/* udot (nu,) of any motion */
void lamc_motion_accelerate(const lamc_motion *motion, lamc_real t, const lamc_real *q, const lamc_real *u,
                            lamc_real *udot);

/* dq/dt (nq,) */
void lamc_motion_rates(const lamc_motion *motion, const lamc_real *q, const lamc_real *u, lamc_real *qdot);

/* The parts of the work: of guards, of powers, and of series */
lamc_real *lamc_motion_guard_work(const lamc_motion *motion);
lamc_real *lamc_motion_power_work(const lamc_motion *motion);
lamc_real *lamc_motion_series_work(const lamc_motion *motion);

#endif /* LAMC_MOTION_H */
