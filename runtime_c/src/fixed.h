/* fixed.h, of lamc: the end of a step whose length the caller chose. */
#ifndef LAMC_FIXED_H
#define LAMC_FIXED_H

#include "method.h"

/* Numbers that the function below takes for `guards` */
long long lamc_fixed_guards(const lamc_ode *ode);

/* Before a step of length h from t: at a break where it ends, inputs are what they are before; the time that it begins at,
 * which is that of a break where t differs from one by round-off. Breaks inside a step are not looked at. */
lamc_real lamc_fixed_begin(const lamc_ode *ode, lamc_real t, lamc_real h);

/* At the start of a step: modes that do not fit the state there, or an equation that has changed */
void lamc_fixed_review(const lamc_ode *ode, lamc_real t, const lamc_real *y);

/* y at the end t of a step, brought back to what must hold; then events, each guard's once */
lamc_status lamc_fixed_end(const lamc_ode *ode, lamc_real t, lamc_real *y, lamc_real *guards);

#endif /* LAMC_FIXED_H */
