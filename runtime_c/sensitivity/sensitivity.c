/* sensitivity.c, of lamc: a run with the derivatives of its states, step by step.
 *
 * In: a lamc_sensitivity. Out: rows of states and of derivatives. Never: takes a step itself, or lets a derivative decide. */
#include "lamc_sensitivity.h"

#include "collocation.h"
#include "finely.h"
#include "guards.h"
#include "jumps.h"
#include "layout.h"
#include "rows.h"
#include "series.h"

#include <limits.h>

long long lamc_sensitivity_work_size(const lamc_model *model, const lamc_tangents *tangents,
                                     int column_count) {
  if (model == NULL || tangents == NULL || column_count < 1 || column_count > INT_MAX / 64) return 0;
  if (tangents->column_count < 0 || tangents->column_count > column_count) return 0;
  return lamc_lay_out(NULL, model, tangents, column_count, NULL);
}

static size_t block_bytes(const lamc_sensitivity *s) {
  return (size_t)s->run.ode.n * (size_t)s->width * sizeof(lamc_real);
}

/* 1 if an interior row of the last step is due */
static int wants_rows_within(const lamc_run *run) {
  return run->t_eval_next < run->t_eval_count && run->t_eval[run->t_eval_next] < run->t;
}

static int is_block_finite(const lamc_sensitivity *s, const lamc_real *block) {
  lamc_real sum = 0;
  for (ptrdiff_t i = 0; i < (ptrdiff_t)s->run.ode.n * s->width; i++) sum += fabs(block[i]);
  return is_finite(sum);
}

/* 1 if the step that was replayed is too long for S: its error, over its size, for the worst column */
static int is_too_long(const lamc_sensitivity *s) {
  static const lamc_real RK45_E[7] = {71.0 / 57600.0,      0.0,          -71.0 / 16695.0, 71.0 / 1920.0,
                                      -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0};
  const int n = s->run.ode.n, is_five = s->run.method == LAMC_RK45, count = is_five ? 7 : 12;
  const lamc_real h = s->run.h_last, enough = LAMC_S_PER_RTOL * s->run.options.rtol;
  const lamc_real *fifth = is_five ? RK45_E : DOP853_E5, *third = is_five ? NULL : DOP853_E3;
  return !lamc_s_is_exact(n, s->width, h, s->slopes, count, fifth, third, s->end, enough) &&
         lamc_s_error(n, s->width, h, s->slopes, count, fifth, third, s->end) > enough;
}

/* S over the last step of the run, whose end no event has changed yet */
static void follow(lamc_sensitivity *s) {
  lamc_run *run = &s->run;
  const lamc_room r = s->room;
  lamc_take_constants(s);
  memcpy(s->start, s->here, block_bytes(s));
  int is_known = 1;
  if (lamc_is_replayed(run->method)) {
    lamc_replay(s, r.argument, r.y);
    s->is_fine = is_too_long(s);
    if (s->is_fine) {
      is_known = lamc_follow_finely(s, r.argument);
      lamc_replay_end(s, r.y); /* the next step begins with the slope of this S */
    }
  } else {
    s->is_fine = 0;
    is_known = lamc_collocate(s, r.collocation, r.argument);
  }
  s->method = run->method;
  s->h = run->h_last;
  s->t = run->t;
  if (!is_known || !is_block_finite(s, s->end)) lamc_lose(s, run->t_old, LAMC_LOST_NOT_FINITE, -1);
  memcpy(s->here, s->end, block_bytes(s));
}

/* The event of the run, and what it does to S */
static lamc_status meet(const void *context, lamc_real t, lamc_real *y, const lamc_real *struck) {
  lamc_sensitivity *s = (lamc_sensitivity *)context; /* whose first member is the motion */
  const lamc_room r = s->room;
  if (s->run.t > s->t) {
    follow(s);
    if (wants_rows_within(&s->run) && lamc_is_replayed(s->method)) lamc_replay_extend(s, r.argument, r.y);
  } else {
    lamc_take_constants(s);
  }
  s->has_slope = 0;
  int guard = -1, impacts = 0, ticks = 0, count = 0;
  for (int g = s->motion.model->guard_count - 1; g >= 0; g--) {
    if (!(struck[g] > 0)) continue;
    guard = g;
    count++;
    impacts += s->motion.model->guard_modes[g] == -1;
    ticks += s->motion.model->guard_modes[g] < -1;
  }
  if (ticks > 0 && ticks == count) { /* at their times, whatever the columns: S is continuous */
    lamc_sample(s, t, y, struck);
    const lamc_status status = lamc_guards_event(context, t, y, struck);
    lamc_take_constants(s);
    return status;
  }
  if (count > 1 && impacts + ticks > 0) lamc_lose(s, t, LAMC_LOST_TOGETHER, guard);
  if (s->lost != LAMC_NOT_LOST) return lamc_guards_event(context, t, y, struck);
  const lamc_status status =
      count == 1 ? lamc_meet_one(s, &r, t, y, guard, struck) : lamc_meet_switches(s, &r, t, y, struck);
  lamc_vary_settle(s, t, y, s->here, r.argument);
  return status;
}

/* A step that ended at a break of a series is followed before the run looks at what comes after it. Breaks stand still: S
 * does not jump there. */
static void pass(const void *context, long long next) {
  lamc_sensitivity *s = (lamc_sensitivity *)context; /* whose first member is the motion */
  if (s->run.t > s->t) {
    const lamc_room r = s->room;
    follow(s);
    if (wants_rows_within(&s->run) && lamc_is_replayed(s->method)) lamc_replay_extend(s, r.argument, r.y);
  }
  s->has_slope = 0;
  s->t_break = s->run.t;
  lamc_series_pass(context, next);
  lamc_series_pass(&s->beside, next);
}

/* ---- A run ------------------------------------------------------------------------------------------------- */

lamc_status lamc_sensitivity_start(lamc_sensitivity *s, const lamc_motion *motion,
                                   const lamc_tangents *tangents, const lamc_real *inputs,
                                   const lamc_real *directions, int column_count, lamc_method which,
                                   const lamc_options *options, lamc_real t0, const lamc_real *y0,
                                   const lamc_real *s0, lamc_real t_end, const lamc_real *t_eval,
                                   long long t_eval_count, lamc_real *run_work, lamc_real *work) {
  if (s == NULL || motion == NULL || tangents == NULL || s0 == NULL || work == NULL) return LAMC_BAD_ARGUMENT;
  const long long size = lamc_sensitivity_work_size(motion->model, tangents, column_count);
  if (size == 0 || (tangents->column_count > 0 && (inputs == NULL || directions == NULL)))
    return LAMC_BAD_ARGUMENT;
  memset(s, 0, sizeof *s);
  memset(work, 0, (size_t)size * sizeof *work);
  s->motion = s->beside = *motion;
  s->tangents = tangents;
  s->inputs = inputs;
  s->directions = directions;
  s->column_count = column_count;
  s->width = lamc_columns_width(column_count);
  s->t = t0;
  s->t_lost = HUGE_VAL;
  s->t_break = -HUGE_VAL;
  (void)lamc_lay_out(s, motion->model, tangents, column_count, work);
  if (motion->model->cut_count > 0) lamc_loops_begin(&s->beside);
  lamc_memory_begin(s);
  lamc_ode ode = lamc_motion_ode(&s->motion);
  s->rhs = ode.rhs;
  ode.rhs = lamc_remember;
  ode.integral_count = 0;
  if (ode.guard_count > 0) ode.event = meet;
  if (ode.pass != NULL) ode.pass = pass;
  const lamc_status status =
      lamc_run_start(&s->run, &ode, which, options, t0, y0, t_end, t_eval, t_eval_count, run_work);
  for (int i = 0; i < ode.n; i++)
    memcpy(s->here + (ptrdiff_t)i * s->width, s0 + (ptrdiff_t)i * column_count,
           (size_t)column_count * sizeof *s0);
  if (status != LAMC_OK) return status;
  lamc_take_constants(s);
  s->beside.baumgarte = 0;                                /* a start is closed whatever comes of it */
  lamc_vary_settle(s, t0, y0, s->here, s->room.argument); /* differences of starts know it to some 1e-9 */
  s->beside.baumgarte = motion->baumgarte;
  lamc_sample(s, t0, y0, NULL);
  return status;
}

/* S (n, column_count) of a row */
static void write_row(lamc_sensitivity *s, lamc_real t, const lamc_real *y, lamc_real *out) {
  const int n = s->run.ode.n;
  const lamc_real *block = s->here;
  if (t < s->run.t && s->run.h_last > 0) {
    const lamc_room r = s->room;
    const lamc_real x = (t - s->run.t_old) / s->h;
    if (s->is_fine && lamc_finely_at(s, t, r.collocation, r.argument)) {
      /* there it is */
    } else if (lamc_is_replayed(s->method)) {
      lamc_replay_extend(s, r.argument, r.y);
      lamc_replay_at(s, x, r.argument);
    } else {
      lamc_collocated_at(s, x, r.argument);
    }
    lamc_vary_settle(s, t, y, r.argument, r.collocation);
    block = r.argument;
  }
  const int is_lost = s->lost != LAMC_NOT_LOST && t >= s->t_lost;
  for (int i = 0; i < n; i++) {
    for (int c = 0; c < s->column_count; c++)
      out[(ptrdiff_t)i * s->column_count + c] = is_lost ? NAN : block[(ptrdiff_t)i * s->width + c];
  }
}

/* The slopes of the continuous extension that rows within the last step take are there */
static void make_ready(lamc_sensitivity *s, lamc_real *y) {
  lamc_run *run = &s->run;
  if (run->dense == LAMC_DENSE_READY || run->t_event == run->t) return;
  const int dense = run->dense;
  (void)lamc_run_interpolate(run, LAMC_R(0.5) * (run->t_old + run->t), y);
  run->dense = dense;
}

static lamc_status write_rows(lamc_sensitivity *s, lamc_rows *rows, lamc_real *sensitivities) {
  const long long first = rows->count;
  const int n = s->run.ode.n;
  const lamc_status status = lamc_rows_write(&s->run, rows);
  for (long long k = first; k < rows->count; k++) {
    if (rows->t[k] < s->run.t && s->run.h_last > 0) make_ready(s, s->room.y);
    write_row(s, rows->t[k], rows->y + k * n, sensitivities + k * n * s->column_count);
  }
  return status;
}

lamc_status lamc_sensitivity_advance(lamc_sensitivity *s, lamc_rows *rows, lamc_real *sensitivities,
                                     long long budget, const volatile int *cancel) {
  if (s == NULL || rows == NULL || sensitivities == NULL || budget < 0) return LAMC_BAD_ARGUMENT;
  if (rows->t == NULL || rows->y == NULL || rows->capacity <= 0 || rows->count < 0) return LAMC_BAD_ARGUMENT;
  lamc_run *run = &s->run;
  if (run->status < 0) return run->status;
  const long long end = budget > 0 ? run->evaluations + budget : LLONG_MAX;
  for (;;) {
    run->status = write_rows(s, rows, sensitivities);
    if (run->status != LAMC_OK || run->t >= run->t_end) return run->status;
    run->status = LAMC_PAUSED;
    if (cancel != NULL && *cancel) return run->status = LAMC_CANCELLED;
    if (run->evaluations >= end) return run->status;
    const long long singular = lamc_motion_singular_steps(&s->motion);
    const lamc_status status = lamc_run_step(run);
    if (status < 0) return status;
    if (run->t > s->t) follow(s);
    if (lamc_motion_singular_steps(&s->motion) > singular) lamc_lose(s, run->t_old, LAMC_LOST_SINGULAR, -1);
  }
}
