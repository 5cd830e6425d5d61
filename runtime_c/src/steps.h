/* steps.h, of lamc: one step of a run in parts, for those who take several runs' steps side by side.
 *
 * In:    a run that was started. Out: the step to take; after someone took it, what becomes of it.
 * Never: evaluates dy/dt at a stage; that is the caller's, whose numbers must be those of the run's method. */
#ifndef LAMC_STEPS_H
#define LAMC_STEPS_H

#include "method.h"

/* Where the step under way ends at most, s */
lamc_real lamc_run_stop(const lamc_run *run);

/* The length of the next step, and whether it is the last. LAMC_OK, or what ends the run before it. */
lamc_status lamc_run_next(lamc_run *run, lamc_real *h, int *is_last);

/* After a step of length h led to the other side, with this squared error: moves there and brings the state to what must hold.
 * LAMC_PAUSED: the step is refused. LAMC_OK: the state stands; *wants_slope: dy/dt there is still to be evaluated. */
lamc_status lamc_run_land(lamc_run *run, lamc_real h, int is_last, lamc_real squared, int *wants_slope);

/* With dy/dt there: LAMC_OK, or LAMC_PAUSED where it is not finite, and the run stands where it was. */
lamc_status lamc_run_stand(lamc_run *run);

/* What follows from all that, `taken`, for the steps to come. LAMC_OK, LAMC_PAUSED: another is to be tried; or the end. */
lamc_status lamc_run_conclude(lamc_run *run, lamc_status taken, lamc_real h, lamc_real squared);

#endif /* LAMC_STEPS_H */
