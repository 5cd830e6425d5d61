/* motion.c: a compiled model as rows of states and as a differential equation.
 *
 * In: a lamc_motion and states y = [q, u]. Out: accelerations, energies, poses. Never changes the motion. */
#include "lamc.h"

#include "guards.h"
#include "linearise.h"
#include "loops.h"

#include <stddef.h>
#include <string.h>

/* udot of a tree, or under the closure of loops */
static void accelerate(const lamc_motion *motion, double t, const double *q, const double *u, double *udot) {
  if (motion->model->cut_count == 0) {
    motion->model->acceleration(motion->constants, t, q, u, udot);
  } else {
    (void)lamc_loops_acceleration(motion, t, q, u, udot, NULL);
  }
}

/* dy/dt of y = [q, u] is [u, udot] */
static void motion_rhs(const void *context, double t, const double *y, double *dydt) {
  const lamc_motion *motion = (const lamc_motion *)context;
  const int n = motion->model->joint_count;
  const double *u = y + n;
  for (int i = 0; i < n; i++) dydt[i] = u[i];
  accelerate(motion, t, y, u, dydt + n);
}

static lamc_status motion_settle(const void *context, double t, double *y, double *moved) {
  return lamc_motion_settle((const lamc_motion *)context, t, y, moved);
}

lamc_ode lamc_motion_ode(const lamc_motion *motion) {
  const lamc_model *model = motion->model;
  lamc_ode ode;
  memset(&ode, 0, sizeof ode);
  ode.n = 2 * model->joint_count;
  ode.rhs = motion_rhs;
  ode.context = motion;
  if (model->cut_count > 0 && motion->baumgarte == 0.0) {
    ode.settle = motion_settle;
    ode.judge = lamc_loops_judge;
    ode.doubts = lamc_loops_doubts;
  }
  ode.jacobian = lamc_linearise;
  ode.scratch_size = lamc_linearise_scratch(model);
  ode.jacobian_cost = lamc_linearise_cost(motion);
  ode.guard_count = model->guard_count;
  ode.guards = lamc_guards_values;
  ode.sense = lamc_guards_sense;
  ode.event = lamc_guards_event;
  if (model->cut_count > 0) lamc_loops_begin(motion);
  return ode;
}

long long lamc_motion_work_size(const lamc_model *model) {
  return lamc_loops_work(model) + lamc_guards_work(model);
}

double *lamc_motion_guard_work(const lamc_motion *motion) {
  return motion->work + lamc_loops_work(motion->model);
}

/* Before something is evaluated at a state outside a run: the modes of the guards there */
static void sense(const lamc_motion *motion, double t, const double *y) {
  if (motion->model->guard_count > 0) lamc_guards_sense(motion, t, y);
}

/* 1 if there is a model with constants to read, and rows to read and write */
static int is_usable(const lamc_motion *motion, long long count, const double *in, const double *out) {
  return motion != NULL && motion->model != NULL && motion->constants != NULL && count >= 0 && in != NULL &&
         out != NULL;
}

lamc_status lamc_motion_accelerations(const lamc_motion *motion, long long count, const double *t,
                                      const double *y, double *udot) {
  if (!is_usable(motion, count, y, udot) || t == NULL) return LAMC_BAD_ARGUMENT;
  const lamc_model *model = motion->model;
  const int n = model->joint_count;
  for (long long row = 0; row < count; row++) {
    const double *q = y + 2 * n * row;
    sense(motion, t[row], q);
    accelerate(motion, t[row], q, q + n, udot + n * row);
  }
  return LAMC_OK;
}

lamc_status lamc_motion_energies(const lamc_motion *motion, long long count, const double *t, const double *y,
                                 double *energies) {
  if (!is_usable(motion, count, y, energies) || t == NULL) return LAMC_BAD_ARGUMENT;
  const lamc_model *model = motion->model;
  const int n = model->joint_count;
  for (long long row = 0; row < count; row++) {
    const double *q = y + 2 * n * row;
    sense(motion, t[row], q);
    model->energy(motion->constants, t[row], q, q + n, energies + model->energy_count * row);
  }
  return LAMC_OK;
}

long long lamc_motion_jacobian_scratch(const lamc_model *model) {
  return lamc_linearise_scratch(model);
}

lamc_status lamc_motion_jacobian(const lamc_motion *motion, double t, const double *y, double *by_q,
                                 double *by_u, double *by_t, double *scratch) {
  if (!is_usable(motion, 1, y, by_q) || by_u == NULL || by_t == NULL || scratch == NULL)
    return LAMC_BAD_ARGUMENT;
  sense(motion, t, y);
  lamc_linearise(motion, t, y, by_q, by_u, by_t, scratch);
  return LAMC_OK;
}

lamc_status lamc_motion_poses(const lamc_motion *motion, long long count, const double *y, double *poses) {
  if (!is_usable(motion, count, y, poses)) return LAMC_BAD_ARGUMENT;
  const lamc_model *model = motion->model;
  for (long long row = 0; row < count; row++) {
    model->poses(motion->constants, y + 2 * model->joint_count * row, poses + 12 * model->body_count * row);
  }
  return LAMC_OK;
}

lamc_status lamc_motion_closures(const lamc_motion *motion, long long count, const double *y,
                                 double *closures) {
  if (!is_usable(motion, count, y, closures)) return LAMC_BAD_ARGUMENT;
  const lamc_model *model = motion->model;
  const int n = model->joint_count;
  const long long width = (long long)model->closure_count * (n + 1);
  for (long long row = 0; row < count && model->cut_count > 0; row++) {
    model->closure(motion->constants, y + 2 * n * row, closures + width * row);
  }
  return LAMC_OK;
}

lamc_status lamc_motion_cuts(const lamc_motion *motion, long long count, const double *y, double *cuts) {
  if (!is_usable(motion, count, y, cuts)) return LAMC_BAD_ARGUMENT;
  const lamc_model *model = motion->model;
  const int n = model->joint_count;
  for (long long row = 0; row < count && model->cut_count > 0; row++) {
    const double *q = y + 2 * n * row;
    model->cuts(motion->constants, q, q + n, cuts + 2 * model->cut_count * row);
  }
  return LAMC_OK;
}
