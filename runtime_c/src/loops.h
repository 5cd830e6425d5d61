/* loops.h, of lamc: what motion.c asks of loops.c. */
#ifndef LAMC_LOOPS_H
#define LAMC_LOOPS_H

#include "lamc.h"

/* udot (n,) of a motion with loops */
void lamc_loops_acceleration(const lamc_motion *motion, double t, const double *q, const double *u,
                             double *udot);

#endif /* LAMC_LOOPS_H */
