/* motion.c: a compiled model as rows of states and as a differential equation.
 *
 * In: a lamc_motion and states y = [q, u]. Out: accelerations, energies, powers, poses. Never changes the motion. */
#include "motion.h"

#include "guards.h"
#include "linearise.h"
#include "loops.h"
#include "powers.h"
#include "series.h"
#include "system.h"

#include <stddef.h>
#include <string.h>

void lamc_motion_accelerate(const lamc_motion *motion, lamc_real t, const lamc_real *q, const lamc_real *u,
                            lamc_real *udot) {
  lamc_series_put(motion, t);
  if (motion->model->acceleration != NULL) {
    motion->model->acceleration(motion->constants, t, q, u, udot);
  } else if (lamc_is_system(motion->model)) {
    lamc_system_acceleration(motion, t, q, u, udot);
  } else {
    (void)lamc_loops_acceleration(motion, t, q, u, udot, NULL);
  }
}

void lamc_motion_rates(const lamc_motion *motion, const lamc_real *q, const lamc_real *u, lamc_real *qdot) {
  if (motion->model->rates != NULL) {
    motion->model->rates(motion->constants, q, u, qdot);
  } else {
    for (int i = 0; i < motion->model->rate_count; i++) qdot[i] = u[i];
  }
}

/* dy/dt of y = [q, u] */
static void motion_rhs(const void *context, lamc_real t, const lamc_real *y, lamc_real *dydt) {
  const lamc_motion *motion = (const lamc_motion *)context;
  const int nq = motion->model->coordinate_count;
  lamc_motion_rates(motion, y, y + nq, dydt);
  lamc_motion_accelerate(motion, t, y, y + nq, dydt + nq);
}

/* The same where the model gives both as they are: most mechanisms, and the call that a run makes most often */
static void plain_rhs(const void *context, lamc_real t, const lamc_real *y, lamc_real *dydt) {
  const lamc_motion *motion = (const lamc_motion *)context;
  const int n = motion->model->rate_count;
  const lamc_real *u = y + n;
  for (int i = 0; i < n; i++) dydt[i] = u[i];
  motion->model->acceleration(motion->constants, t, y, u, dydt + n);
}

static lamc_status motion_settle(const void *context, lamc_real t, lamc_real *y, lamc_real *moved) {
  return lamc_motion_settle((const lamc_motion *)context, t, y, moved);
}

lamc_ode lamc_motion_ode(const lamc_motion *motion) {
  const lamc_model *model = motion->model;
  lamc_ode ode;
  memset(&ode, 0, sizeof ode);
  ode.n = model->coordinate_count + model->rate_count;
  ode.coordinate_count = model->coordinate_count;
  ode.is_rough = model->table_count > 0;
  const int is_plain = model->rates == NULL && model->acceleration != NULL && model->series_count == 0;
  ode.rhs = is_plain ? plain_rhs : motion_rhs;
  ode.context = motion;
  if (model->cut_count > 0 && motion->baumgarte == 0) {
    ode.settle = motion_settle;
    ode.judge = lamc_loops_judge;
    ode.doubts = lamc_loops_doubts;
  }
  if (model->cut_count > 0) ode.work = lamc_loops_counter;
  if (model->rates == NULL) {
    ode.jacobian = lamc_linearise;
  } else {
    ode.full_jacobian = lamc_linearise_fully;
  }
  ode.scratch_size = lamc_linearise_scratch(model);
  ode.jacobian_cost = lamc_linearise_cost(motion);
  ode.guard_count = model->guard_count;
  ode.guards = lamc_guards_values;
  ode.sense = lamc_guards_sense;
  ode.review = lamc_guards_review;
  ode.event = lamc_guards_event;
  if (model->power != NULL) {
    ode.integral_count = model->power_count + 1;
    ode.integrands = lamc_powers_integrands;
    ode.jump = lamc_powers_jump;
  }
  const lamc_recording *recording = lamc_series_recording(motion);
  if (model->series_count > 0 && recording != NULL) {
    ode.breaks = recording->breaks;
    ode.break_count = recording->break_count;
    ode.pass = lamc_series_pass;
  }
  if (model->cut_count > 0 && motion->work != NULL) lamc_loops_begin(motion); /* NULL: for sizes only */
  return ode;
}

long long lamc_motion_work_size(const lamc_model *model) {
  return lamc_loops_work(model) + lamc_system_work(model) + lamc_guards_work(model) +
         lamc_powers_work(model) + lamc_series_work(model);
}

lamc_real *lamc_motion_guard_work(const lamc_motion *motion) {
  return motion->work + lamc_loops_work(motion->model) + lamc_system_work(motion->model);
}

lamc_real *lamc_motion_power_work(const lamc_motion *motion) {
  return lamc_motion_guard_work(motion) + lamc_guards_work(motion->model);
}

lamc_real *lamc_motion_series_work(const lamc_motion *motion) {
  return lamc_motion_power_work(motion) + lamc_powers_work(motion->model);
}

/* Before something is evaluated at a state outside a run: the modes of the guards there */
static void sense(const lamc_motion *motion, lamc_real t, const lamc_real *y) {
  if (motion->model->guard_count > 0) lamc_guards_sense(motion, t, y);
}

/* 1 if there is a model with constants to read, and rows to read and write */
static int is_usable(const lamc_motion *motion, long long count, const lamc_real *in, const lamc_real *out) {
  return motion != NULL && motion->model != NULL && motion->constants != NULL && count >= 0 && in != NULL &&
         out != NULL;
}

static int state_size(const lamc_model *model) {
  return model->coordinate_count + model->rate_count;
}

lamc_status lamc_motion_accelerations(const lamc_motion *motion, long long count, const lamc_real *t,
                                      const lamc_real *y, lamc_real *udot) {
  if (!is_usable(motion, count, y, udot) || t == NULL) return LAMC_BAD_ARGUMENT;
  const lamc_model *model = motion->model;
  for (long long row = 0; row < count; row++) {
    const lamc_real *q = y + state_size(model) * row;
    sense(motion, t[row], q);
    lamc_motion_accelerate(motion, t[row], q, q + model->coordinate_count, udot + model->rate_count * row);
  }
  return LAMC_OK;
}

lamc_status lamc_motion_energies(const lamc_motion *motion, long long count, const lamc_real *t,
                                 const lamc_real *y, lamc_real *energies) {
  if (!is_usable(motion, count, y, energies) || t == NULL) return LAMC_BAD_ARGUMENT;
  const lamc_model *model = motion->model;
  for (long long row = 0; row < count; row++) {
    const lamc_real *q = y + state_size(model) * row;
    sense(motion, t[row], q);
    lamc_series_put(motion, t[row]);
    model->energy(motion->constants, t[row], q, q + model->coordinate_count,
                  energies + model->energy_count * row);
  }
  return LAMC_OK;
}

lamc_status lamc_motion_powers(const lamc_motion *motion, long long count, const lamc_real *t,
                               const lamc_real *y, lamc_real *powers) {
  if (!is_usable(motion, count, y, powers) || t == NULL) return LAMC_BAD_ARGUMENT;
  const lamc_model *model = motion->model;
  for (long long row = 0; row < count && model->power != NULL; row++) {
    const lamc_real *q = y + state_size(model) * row;
    sense(motion, t[row], q);
    lamc_powers(motion, t[row], q, powers + model->power_count * row);
  }
  return LAMC_OK;
}

long long lamc_motion_jacobian_scratch(const lamc_model *model) {
  return lamc_linearise_scratch(model);
}

lamc_status lamc_motion_jacobian(const lamc_motion *motion, lamc_real t, const lamc_real *y, lamc_real *by_q,
                                 lamc_real *by_u, lamc_real *by_t, lamc_real *scratch) {
  if (!is_usable(motion, 1, y, by_q) || by_u == NULL || by_t == NULL || scratch == NULL)
    return LAMC_BAD_ARGUMENT;
  sense(motion, t, y);
  lamc_linearise(motion, t, y, by_q, by_u, by_t, scratch);
  return LAMC_OK;
}

lamc_status lamc_motion_poses(const lamc_motion *motion, long long count, const lamc_real *t,
                              const lamc_real *y, lamc_real *poses) {
  if (!is_usable(motion, count, y, poses) || t == NULL) return LAMC_BAD_ARGUMENT;
  const lamc_model *model = motion->model;
  for (long long row = 0; row < count; row++) {
    lamc_series_put(motion, t[row]);
    model->poses(motion->constants, t[row], y + state_size(model) * row,
                 poses + 12 * model->body_count * row);
  }
  return LAMC_OK;
}

lamc_status lamc_motion_closures(const lamc_motion *motion, long long count, const lamc_real *y,
                                 lamc_real *closures) {
  if (!is_usable(motion, count, y, closures)) return LAMC_BAD_ARGUMENT;
  const lamc_model *model = motion->model;
  const long long width = (long long)model->closure_count * (model->rate_count + 1);
  for (long long row = 0; row < count && model->cut_count > 0; row++) {
    lamc_loops_closure(motion, y + state_size(model) * row, closures + width * row);
  }
  return LAMC_OK;
}
