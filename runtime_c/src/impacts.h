/* impacts.h, of lamc: rates after impacts. */
#ifndef LAMC_IMPACTS_H
#define LAMC_IMPACTS_H

#include "lamc.h"

/* Numbers of a motion's work for guards that impacts take; 0 without guards */
long long lamc_impacts_work(const lamc_model *model);

/* u of y = [q, u] after impacts on all guards without a mode whose struck (guard_count,) is above 0, at one instant. */
void lamc_impacts(const lamc_motion *motion, lamc_real t, lamc_real *y, const lamc_real *struck);

#endif /* LAMC_IMPACTS_H */
