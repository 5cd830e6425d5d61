/* guards.c, of lamc: what happens where a guard passes zero.
 *
 * A guard with a mode switches a force on or off: the mode is a constant of the motion, 1 beyond the guard and 0 before,
 * and stands still between events, so that the equations are smooth there. A guard without one is an impact. */
#include "guards.h"

#include "cholesky.h"
#include "loops.h"
#include "motion.h"

#include <string.h>

long long lamc_guards_work(const lamc_model *model) {
  const long long n = model->rate_count, k = model->guard_count;
  if (k == 0) return 0;
  const long long impact = k + k * n + n * n + (n * (n + 1) / 2 + n) + n;
  return 2 * k > impact ? 2 * k : impact;
}

void lamc_guards_sense(const void *context, double t, const double *y) {
  const lamc_motion *motion = (const lamc_motion *)context;
  const lamc_model *model = motion->model;
  double *values = lamc_motion_guard_work(motion);
  model->guards(motion->constants, t, y, y + model->coordinate_count, values);
  for (int g = 0; g < model->guard_count; g++) {
    if (model->guard_modes[g] >= 0) motion->constants[model->guard_modes[g]] = values[g] > 0.0 ? 1.0 : 0.0;
  }
}

void lamc_guards_values(const void *context, double t, const double *y, double *guards) {
  const lamc_motion *motion = (const lamc_motion *)context;
  const lamc_model *model = motion->model;
  model->guards(motion->constants, t, y, y + model->coordinate_count, guards);
  for (int g = 0; g < model->guard_count; g++) {
    if (model->guard_modes[g] >= 0 && motion->constants[model->guard_modes[g]] > 0.5) {
      guards[g] = -guards[g];
      guards[model->guard_count + g] = -guards[model->guard_count + g];
    }
  }
}

/* u after an impact of a motion without loops */
static void bounce(const lamc_motion *motion, double t, const double *q, double *u, const double *gradient,
                   double restitution, double *work) {
  const lamc_model *model = motion->model;
  const int n = model->rate_count;
  double *l = work, *inertia = l + (ptrdiff_t)n * n, *x = inertia + (ptrdiff_t)n * (n + 1) / 2 + n;
  if (model->inertia != NULL) {
    model->inertia(motion->constants, q, inertia);
  } else {
    model->system(motion->constants, t, q, u, inertia); /* and f behind it */
  }
  lamc_cholesky(n, inertia, l);
  memcpy(x, gradient, (size_t)n * sizeof *x);
  lamc_solve_lower(n, l, x);
  const double yielding = lamc_dot(n, x, x);
  if (!(yielding > 0.0)) return;
  const double jump = -(1.0 + restitution) * lamc_dot(n, gradient, u) / yielding;
  lamc_solve_upper(n, l, x);
  for (int i = 0; i < n; i++) u[i] += jump * x[i];
}

lamc_status lamc_guards_event(const void *context, double t, double *y, int guard) {
  const lamc_motion *motion = (const lamc_motion *)context;
  const lamc_model *model = motion->model;
  const int n = model->rate_count, nq = model->coordinate_count, mode = model->guard_modes[guard];
  if (mode >= 0) {
    motion->constants[mode] = 1.0 - motion->constants[mode];
    return LAMC_OK;
  }
  double *impacts = lamc_motion_guard_work(motion);
  const double *gradient = impacts + model->guard_count + (ptrdiff_t)guard * n;
  model->impacts(motion->constants, t, y, impacts);
  if (model->cut_count == 0) {
    bounce(motion, t, y, y + nq, gradient, impacts[guard], impacts + (ptrdiff_t)model->guard_count * (n + 1));
  } else {
    lamc_loops_bounce(motion, t, y, y + nq, gradient, impacts[guard]);
  }
  return LAMC_OK;
}
