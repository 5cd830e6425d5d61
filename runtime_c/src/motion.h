/* motion.h, of lamc: accelerations of a motion, whichever way its model gives them. */
#ifndef LAMC_MOTION_H
#define LAMC_MOTION_H

#include "lamc.h"

/* udot (nu,) of any motion */
void lamc_motion_accelerate(const lamc_motion *motion, double t, const double *q, const double *u,
                            double *udot);

/* dq/dt (nq,) */
void lamc_motion_rates(const lamc_motion *motion, const double *q, const double *u, double *qdot);

/* The parts of the work: of guards, and of powers */
double *lamc_motion_guard_work(const lamc_motion *motion);
double *lamc_motion_power_work(const lamc_motion *motion);

#endif /* LAMC_MOTION_H */
