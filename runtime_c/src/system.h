/* system.h, of lamc: M udot = f of a motion without loops whose model leaves the solution to the runtime. */
#ifndef LAMC_SYSTEM_H
#define LAMC_SYSTEM_H

#include "lamc.h"

/* 1 if the motion is of that kind */
int lamc_is_system(const lamc_model *model);

/* Numbers of work that it needs; 0 for others */
long long lamc_system_work(const lamc_model *model);

/* udot (nu,); NaN where M is not positive */
void lamc_system_acceleration(const lamc_motion *motion, lamc_real t, const lamc_real *q, const lamc_real *u,
                              lamc_real *udot);

/* After an acceleration, at the same place: x (nu,) replaced by M^-1 x */
void lamc_system_response(const lamc_motion *motion, lamc_real *x);

#endif /* LAMC_SYSTEM_H */
