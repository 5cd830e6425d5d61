/* series.h, of lamc: inputs that follow tables over time. */
#ifndef LAMC_SERIES_H
#define LAMC_SERIES_H

#include "lamc.h"

/* Numbers of work: which of the breaks ends the step under way */
long long lamc_series_work(const lamc_model *model);

/* What the inputs follow: of the motion, or else of its model; NULL: nothing */
const lamc_recording *lamc_series_recording(const lamc_motion *motion);

/* Writes values and derivatives at t into the constants */
void lamc_series_write(const lamc_motion *motion, lamc_real t);

/* lamc_ode.pass of a motion */
void lamc_series_pass(const void *motion, long long next);

/* Before anything of the model is evaluated at t */
static inline void lamc_series_put(const lamc_motion *motion, lamc_real t) {
  if (motion->model->series_count > 0) lamc_series_write(motion, t);
}

#endif /* LAMC_SERIES_H */
