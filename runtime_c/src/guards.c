/* guards.c, of lamc: what happens where a guard passes zero.
 *
 * A guard with a mode switches a force on or off: the mode is a constant of the motion, 1 beyond the guard and 0 before,
 * and stands still between events, so that the equations are smooth there. A guard without one is an impact.
 *
 * A guard may depend on rates, such as that of a motor at its limit; its rate then takes the accelerations, with the modes as
 * they are. An impact makes it jump, and its mode is looked at anew; so does a sample, which a clock takes at each multiple
 * of its period and holds as a constant. */
#include "guards.h"

#include "impacts.h"
#include "loops.h"
#include "motion.h"
#include "series.h"
#include "tolerances.h"

#include <math.h>
#include <stddef.h>

static const lamc_real AS_ZERO =
    64 * LAMC_EPSILON; /* of the time, at a guard's rate: round-off of an event */

/* Where guards may jump: room for all guards as they were (2 k), what accelerations add (k), these (nu,), and samples */
static long long jumping_work(const lamc_model *model) {
  if (model->guard_changes == NULL && model->clock_count == 0) return 0;
  return 3LL * model->guard_count + model->rate_count + model->clock_count + model->held_count;
}

static long long common_work(const lamc_model *model) {
  const long long k = model->guard_count, impacts = lamc_impacts_work(model);
  return 2 * k > impacts ? 2 * k : impacts;
}

long long lamc_guards_work(const lamc_model *model) {
  return common_work(model) + jumping_work(model);
}

static lamc_real *jumping_room(const lamc_motion *motion) {
  return lamc_motion_guard_work(motion) + common_work(motion->model);
}

/* Samples of the clocks whose guards are struck, or of all (NULL), and when they sample next */
static void sample(const lamc_motion *motion, lamc_real t, const lamc_real *y, const lamc_real *struck) {
  const lamc_model *model = motion->model;
  if (model->clock_count == 0) return;
  lamc_real *samples = jumping_room(motion) + 3 * (ptrdiff_t)model->guard_count + model->rate_count;
  lamc_series_put(motion, t);
  model->samples(motion->constants, t, y, y + model->coordinate_count, samples);
  for (int c = 0; c < model->clock_count; c++) {
    if (struck != NULL && !(struck[model->clock_guards[c]] > 0)) continue;
    const lamc_real passed = t / samples[c] + AS_ZERO * (1 + fabs(t / samples[c]));
    const long long count = fabs(passed) < LAMC_R(1e15) ? (long long)passed : 0;
    const lamc_real whole = (lamc_real)count > passed ? (lamc_real)(count - 1) : (lamc_real)count;
    motion->constants[model->clock_ticks[c]] = (whole + 1) * samples[c];
    for (int h = 0; h < model->held_count; h++)
      if (model->held_clocks[h] == c) motion->constants[model->held[h]] = samples[model->clock_count + h];
  }
}

/* Guards as the model has them, whatever the modes, with their rates */
static void plain_values(const lamc_motion *motion, lamc_real t, const lamc_real *y, lamc_real *guards) {
  lamc_series_put(motion, t);
  motion->model->guards(motion->constants, t, y, y + motion->model->coordinate_count, guards);
}

/* Adds what accelerations do to the rates */
static void add_changes(const lamc_motion *motion, lamc_real t, const lamc_real *y, lamc_real *rates) {
  const lamc_model *model = motion->model;
  const lamc_real *u = y + model->coordinate_count;
  lamc_real *changes = jumping_room(motion) + 2 * (ptrdiff_t)model->guard_count;
  lamc_real *udot = changes + model->guard_count, kept[LAMC_LOOPS_KEPT];
  if (model->cut_count > 0) lamc_loops_keep(motion, kept);
  lamc_motion_accelerate(motion, t, y, u, udot);
  if (model->cut_count > 0) lamc_loops_put_back(motion, kept);
  model->guard_changes(motion->constants, t, y, u, udot, changes);
  for (int g = 0; g < model->guard_count; g++) rates[g] += changes[g];
}

void lamc_guards_sense(const void *context, lamc_real t, const lamc_real *y) {
  const lamc_motion *motion = (const lamc_motion *)context;
  const lamc_model *model = motion->model;
  lamc_real *values = lamc_motion_guard_work(motion);
  sample(motion, t, y, NULL);
  plain_values(motion, t, y, values);
  for (int g = 0; g < model->guard_count; g++) {
    if (model->guard_modes[g] >= 0) motion->constants[model->guard_modes[g]] = values[g] > 0 ? 1 : 0;
  }
}

void lamc_guards_values(const void *context, lamc_real t, const lamc_real *y, lamc_real *guards) {
  const lamc_motion *motion = (const lamc_motion *)context;
  const lamc_model *model = motion->model;
  plain_values(motion, t, y, guards);
  if (model->guard_changes != NULL) add_changes(motion, t, y, guards + model->guard_count);
  for (int g = 0; g < model->guard_count; g++) {
    if (model->guard_modes[g] >= 0 && motion->constants[model->guard_modes[g]] > LAMC_R(0.5)) {
      guards[g] = -guards[g];
      guards[model->guard_count + g] = -guards[model->guard_count + g];
    }
  }
}

void lamc_guards_review(const void *context, lamc_real t, const lamc_real *y) {
  const lamc_motion *motion = (const lamc_motion *)context;
  const lamc_model *model = motion->model;
  lamc_real *values = lamc_motion_guard_work(motion);
  lamc_guards_values(context, t, y, values);
  for (int g = 0; g < model->guard_count; g++) {
    const int mode = model->guard_modes[g];
    const lamc_real least = AS_ZERO * fabs(t) * fabs(values[model->guard_count + g]);
    if (mode >= 0 && values[g] > least) motion->constants[mode] = 1 - motion->constants[mode];
  }
}

/* Modes of the guards that are no longer what they were: `before` (2 k,), of the same instant */
static void review_changed(const lamc_motion *motion, lamc_real t, const lamc_real *y,
                           const lamc_real *before) {
  const lamc_model *model = motion->model;
  lamc_real *now = lamc_motion_guard_work(motion);
  plain_values(motion, t, y, now);
  for (int g = 0; g < model->guard_count; g++) {
    const int mode = model->guard_modes[g];
    if (mode >= 0 && now[g] != before[g]) motion->constants[mode] = now[g] > 0 ? 1 : 0;
  }
}

lamc_status lamc_guards_event(const void *context, lamc_real t, lamc_real *y, const lamc_real *struck) {
  const lamc_motion *motion = (const lamc_motion *)context;
  const lamc_model *model = motion->model;
  lamc_real *before = jumping_room(motion);
  int impacts = 0, ticks = 0;
  for (int g = 0; g < model->guard_count; g++) {
    const int mode = model->guard_modes[g];
    if (!(struck[g] > 0)) continue;
    if (mode >= 0) motion->constants[mode] = 1 - motion->constants[mode];
    impacts += mode == -1;
    ticks += mode < -1;
  }
  const int may_jump = ticks > 0 || (impacts > 0 && jumping_work(model) > 0);
  if (may_jump) plain_values(motion, t, y, before);
  if (impacts > 0) lamc_impacts(motion, t, y, struck);
  if (ticks > 0) sample(motion, t, y, struck);
  if (may_jump) review_changed(motion, t, y, before);
  return LAMC_OK;
}
