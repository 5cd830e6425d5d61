/* powers.c, of lamc: the power of effects along a motion.
 *
 * In: states. Out: watts by effect, joules at impacts. Never: touches what the run under way keeps. */
#include "powers.h"

#include "loops.h"
#include "motion.h"

#include <stddef.h>

long long lamc_powers_work(const lamc_model *model) {
  return model->power == NULL ? 0 : (long long)model->rate_count + model->energy_count;
}

void lamc_powers(const lamc_motion *motion, double t, const double *y, double *power) {
  const lamc_model *model = motion->model;
  const double *u = y + model->coordinate_count;
  double *udot = lamc_motion_power_work(motion), kept[LAMC_LOOPS_KEPT];
  if (model->cut_count > 0) lamc_loops_keep(motion, kept);
  lamc_motion_accelerate(motion, t, y, u, udot);
  if (model->cut_count > 0) lamc_loops_put_back(motion, kept);
  model->power(motion->constants, t, y, u, udot, power);
}

void lamc_powers_integrands(const void *context, double t, const double *y, double *values) {
  const lamc_motion *motion = (const lamc_motion *)context;
  lamc_powers(motion, t, y, values);
  values[motion->model->power_count] = 0.0;
}

void lamc_powers_jump(const void *context, double t, const double *before, const double *after,
                      double *integrals) {
  const lamc_motion *motion = (const lamc_motion *)context;
  const lamc_model *model = motion->model;
  const int nq = model->coordinate_count;
  double *energies = lamc_motion_power_work(motion) + model->rate_count;
  model->energy(motion->constants, t, after, after + nq, energies);
  const double kinetic = energies[0];
  model->energy(motion->constants, t, before, before + nq, energies);
  integrals[model->power_count] += kinetic - energies[0];
}
