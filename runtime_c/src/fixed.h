/* fixed.h, of lamc: the end of a step whose length the caller chose. */
#ifndef LAMC_FIXED_H
#define LAMC_FIXED_H

#include "method.h"

/* Doubles that the function below takes for `guards` */
long long lamc_fixed_guards(const lamc_ode *ode);

/* y at the end t of a step, brought back to what must hold; then events, each guard's once */
lamc_status lamc_fixed_end(const lamc_ode *ode, double t, double *y, double *guards);

/* LAMC_ANGLE_WRAPPED where the equation does not allow a step between two states */
lamc_status lamc_fixed_allow(const lamc_ode *ode, double t_old, const double *y_old, double t,
                             const double *y);

#endif /* LAMC_FIXED_H */
