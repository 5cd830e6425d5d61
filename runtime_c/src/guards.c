/* guards.c, of lamc: what happens where a guard passes zero.
 *
 * A guard with a mode switches a force on or off: the mode is a constant of the motion, 1 beyond the guard and 0 before,
 * and stands still between events, so that the equations are smooth there. A guard without one is an impact. */
#include "guards.h"

#include "impacts.h"
#include "motion.h"
#include "series.h"

long long lamc_guards_work(const lamc_model *model) {
  const long long k = model->guard_count, impacts = lamc_impacts_work(model);
  return 2 * k > impacts ? 2 * k : impacts;
}

void lamc_guards_sense(const void *context, lamc_real t, const lamc_real *y) {
  const lamc_motion *motion = (const lamc_motion *)context;
  const lamc_model *model = motion->model;
  lamc_real *values = lamc_motion_guard_work(motion);
  lamc_series_put(motion, t);
  model->guards(motion->constants, t, y, y + model->coordinate_count, values);
  for (int g = 0; g < model->guard_count; g++) {
    if (model->guard_modes[g] >= 0) motion->constants[model->guard_modes[g]] = values[g] > 0 ? 1 : 0;
  }
}

void lamc_guards_values(const void *context, lamc_real t, const lamc_real *y, lamc_real *guards) {
  const lamc_motion *motion = (const lamc_motion *)context;
  const lamc_model *model = motion->model;
  lamc_series_put(motion, t);
  model->guards(motion->constants, t, y, y + model->coordinate_count, guards);
  for (int g = 0; g < model->guard_count; g++) {
    if (model->guard_modes[g] >= 0 && motion->constants[model->guard_modes[g]] > LAMC_R(0.5)) {
      guards[g] = -guards[g];
      guards[model->guard_count + g] = -guards[model->guard_count + g];
    }
  }
}

lamc_status lamc_guards_event(const void *context, lamc_real t, lamc_real *y, const lamc_real *struck) {
  const lamc_motion *motion = (const lamc_motion *)context;
  const lamc_model *model = motion->model;
  int impacts = 0;
  for (int g = 0; g < model->guard_count; g++) {
    const int mode = model->guard_modes[g];
    if (!(struck[g] > 0)) continue;
    if (mode >= 0) {
      motion->constants[mode] = 1 - motion->constants[mode];
    } else {
      impacts++;
    }
  }
  if (impacts > 0) lamc_impacts(motion, t, y, struck);
  return LAMC_OK;
}
