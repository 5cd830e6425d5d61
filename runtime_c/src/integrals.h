/* integrals.h, of lamc: integrals along a run, such as the work of forces. */
#ifndef LAMC_INTEGRALS_H
#define LAMC_INTEGRALS_H

#include "method.h"

/* Numbers that they take in the work array, at its end */
long long lamc_integrals_size(const lamc_ode *ode);

/* Zero at the start of a run. */
void lamc_integrals_start(lamc_run *run, lamc_real *memory);

/* After a step that holds, and before its event: over that step. */
void lamc_integrals_step(lamc_run *run);

/* After an event that changed y from what lamc_integrals_before was shown. */
void lamc_integrals_before(lamc_run *run);
void lamc_integrals_after(lamc_run *run);

/* (integral_count,) at a time within the last step, or where the run stands */
void lamc_integrals_at(const lamc_run *run, lamc_real t, lamc_real *integrals);

#endif /* LAMC_INTEGRALS_H */
