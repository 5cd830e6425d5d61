/* powers.c, of lamc: the power of effects along a motion.
 *
 * In: states. Out: watts by effect, joules at impacts. Never: touches what the run under way keeps. */
#include "powers.h"

#include "loops.h"
#include "motion.h"
#include "series.h"

#include <stddef.h>
#include <string.h>

long long lamc_powers_work(const lamc_model *model) {
  return model->power == NULL ? 0 : (long long)model->rate_count + 2 * model->energy_count;
}

void lamc_powers(const lamc_motion *motion, lamc_real t, const lamc_real *y, lamc_real *power) {
  const lamc_model *model = motion->model;
  const lamc_real *u = y + model->coordinate_count;
  lamc_real *udot = lamc_motion_power_work(motion), kept[LAMC_LOOPS_KEPT];
  if (model->cut_count > 0) lamc_loops_keep(motion, kept);
  lamc_motion_accelerate(motion, t, y, u, udot);
  if (model->cut_count > 0) lamc_loops_put_back(motion, kept);
  model->power(motion->constants, t, y, u, udot, power);
}

void lamc_powers_integrands(const void *context, lamc_real t, const lamc_real *y, lamc_real *values) {
  const lamc_motion *motion = (const lamc_motion *)context;
  lamc_powers(motion, t, y, values);
  values[motion->model->power_count] = 0;
}

void lamc_powers_jump(const void *context, lamc_real t, const lamc_real *before, const lamc_real *after,
                      lamc_real *integrals) {
  const lamc_motion *motion = (const lamc_motion *)context;
  const lamc_model *model = motion->model;
  const int nq = model->coordinate_count;
  lamc_real *old = lamc_motion_power_work(motion) + model->rate_count, *now = old + model->energy_count;
  lamc_series_put(motion, t);
  model->energy(motion->constants, t, before, before + nq, old);
  model->energy(motion->constants, t, after, after + nq, now);
  for (int e = 0; e < model->energy_count; e++) integrals[model->power_count] += now[e] - old[e];
  for (int e = 1; e < model->energy_count; e++) {
    for (int p = 0; p < model->power_count; p++)
      if (strcmp(model->energy_names[e], model->power_names[p]) == 0) integrals[p] -= now[e] - old[e];
  }
}
