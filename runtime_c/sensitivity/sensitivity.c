/* sensitivity.c, of lamc: a run with the derivatives of its states, step by step.
 *
 * In: a lamc_sensitivity. Out: rows of states and of derivatives. Never: takes a step itself, or lets a derivative decide.
 *
 * At an event, at t* where a guard g passes zero, the derivatives jump: with tau = -dg / g', how much later the event comes, a
 * map h of the event and slopes f before and after it, S+ = dh(S- + f- tau) - f+ tau. */
#include "lamc_sensitivity.h"

#include "collocation.h"
#include "finely.h"
#include "guards.h"
#include "impacts.h"
#include "rows.h"
#include "series.h"

#include <limits.h>

/* Numbers that S needs: (n, width) of here, start, end, of an argument, and slopes; the scratch of a variation, which may be
 * at a broader S; y (n,) twice; constants twice; a motion's work; what collocation takes */
typedef struct room {
  lamc_real *argument, *y, *after, *constants, *inputs, *collocation, *fine;
} room;

enum { SLOPES = 16 };

static int largest_of(int a, int b) {
  return a > b ? a : b;
}

static long long whole(long long size) {
  return (size + LANES - 1) / LANES * LANES;
}

/* Where the parts lie; returns how many numbers they take. s NULL: for the size only */
static long long lay_out(lamc_sensitivity *s, room *r, const lamc_model *model, int k, int columns,
                         lamc_real *work) {
  const int n = model->coordinate_count + model->rate_count, width = padded(columns);
  const long long block = (long long)n * width;
  const int broad = largest_of(width, lamc_collocation_width(n, columns));
  const long long inputs = (long long)model->parameter_count + model->geometry_count;
  const long long sizes[] = {block,
                             block,
                             block,
                             SLOPES * block,
                             block,
                             whole(n),
                             whole(n),
                             whole(model->constant_count) + LANES,
                             whole(model->constant_count) + LANES,
                             whole(inputs) + LANES,
                             whole(lamc_collocation_size(n, columns, width)),
                             whole(lamc_motion_work_size(model)) + LANES,
                             whole(lamc_variation_size(model, k, broad)),
                             whole(lamc_fine_size(n, width)),
                             2LL * model->held_count * width};
  enum { PARTS = sizeof sizes / sizeof sizes[0] };
  long long at[PARTS + 1] = {0};
  for (int i = 0; i < PARTS; i++) at[i + 1] = at[i] + sizes[i];
  if (s != NULL) {
    lamc_real **const of_run[] = {&s->here, &s->start, &s->end, &s->slopes};
    for (int i = 0; i < 4; i++) *of_run[i] = work + at[i];
    s->beside.constants = work + at[7];
    s->beside.work = work + at[11];
    s->scratch = work + at[12];
    r->argument = work + at[4];
    r->y = work + at[5];
    r->after = work + at[6];
    r->constants = work + at[8];
    r->inputs = work + at[9];
    r->collocation = work + at[10];
    r->fine = work + at[13];
    s->held = work + at[14];
    s->held_width = width;
  }
  return at[PARTS];
}

long long lamc_sensitivity_work_size(const lamc_model *model, const lamc_tangents *tangents,
                                     int column_count) {
  if (model == NULL || tangents == NULL || column_count < 1 || column_count > INT_MAX / 64) return 0;
  if (tangents->column_count < 0 || tangents->column_count > column_count) return 0;
  return lay_out(NULL, NULL, model, tangents->column_count, column_count, NULL);
}

static room room_of(lamc_sensitivity *s) {
  room r;
  (void)lay_out(s, &r, s->motion.model, s->tangents->column_count, s->column_count, s->here);
  return r;
}

static size_t block_bytes(const lamc_sensitivity *s) {
  return (size_t)s->run.ode.n * (size_t)s->width * sizeof(lamc_real);
}

static void lose(lamc_sensitivity *s, lamc_real t, lamc_lost why, int guard) {
  if (s->lost != LAMC_NOT_LOST) return;
  s->lost = (int)why;
  s->t_lost = t;
  s->lost_guard = guard;
}

/* The modes of guards as the run has them now */
static void take_constants(lamc_sensitivity *s) {
  memcpy(s->beside.constants, s->motion.constants,
         (size_t)s->motion.model->constant_count * sizeof(lamc_real));
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

/* The error of S in the step that was replayed, over its size, for the worst column */
static lamc_real replay_error(const lamc_sensitivity *s) {
  static const lamc_real RK45_E[7] = {71.0 / 57600.0,      0.0,          -71.0 / 16695.0, 71.0 / 1920.0,
                                      -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0};
  const int n = s->run.ode.n, is_five = s->run.method == LAMC_RK45;
  return lamc_s_error(n, s->width, s->run.h_last, s->slopes, is_five ? 7 : 12, is_five ? RK45_E : DOP853_E5,
                      is_five ? NULL : DOP853_E3, s->end);
}

/* S over the last step of the run, whose end no event has changed yet */
static void follow(lamc_sensitivity *s) {
  lamc_run *run = &s->run;
  const room r = room_of(s);
  take_constants(s);
  memcpy(s->start, s->here, block_bytes(s));
  int is_known = 1;
  if (lamc_is_replayed(run->method)) {
    lamc_replay(s, r.argument, r.y);
    if (replay_error(s) > LAMC_S_PER_RTOL * run->options.rtol) lamc_follow_finely(s, r.fine, r.argument);
  } else {
    is_known = lamc_collocate(s, r.collocation, r.argument);
  }
  s->method = run->method;
  s->h = run->h_last;
  s->t = run->t;
  if (!is_known || !is_block_finite(s, s->end)) lose(s, run->t_old, LAMC_LOST_NOT_FINITE, -1);
  memcpy(s->here, s->end, block_bytes(s));
}

/* ---- Events ------------------------------------------------------------------------------------------------ */

/* How much later the event comes, by column, into the first row of `out`. 0: the guard is touched and not passed */
static int delay(lamc_sensitivity *s, lamc_real t, const lamc_real *y, const lamc_real *slope, int guard,
                 lamc_real *out) {
  for (int c = 0; c < s->width; c++) out[c] = 0;
  if (t == s->t_break)
    return 1; /* a series jumped, and the guard with it: at its time, whatever the parameters */
  const variation v = lamc_variation_of(s);
  const lamc_real *row = v.derivative + (ptrdiff_t)guard * (v.n + 1 + v.k + v.held_count);
  lamc_series_put(&s->beside, t);
  s->tangents->guards(s->beside.constants, t, y, y + v.nq, v.derivative);
  lamc_real rate = row[v.n], size = fabs(rate);
  for (int j = 0; j < v.n; j++) {
    rate += row[j] * slope[j];
    size += fabs(row[j] * slope[j]);
  }
  for (int c = 0; c < s->width; c++) out[c] = c < v.k ? -row[v.n + 1 + c] : 0;
  for (int j = 0; j < v.n; j++) lamc_row_less(s->width, row[j], s->here + (ptrdiff_t)j * s->width, out);
  for (int j = 0; j < v.held_count; j++)
    lamc_row_less(s->width, row[v.n + 1 + v.k + j], s->held + (ptrdiff_t)j * s->held_width, out);
  if (!(fabs(rate) > sqrt(LAMC_EPSILON) * size)) return 0;
  lamc_row_scale(s->width, 1 / rate, out);
  return 1;
}

/* u after the impact of a state moved by `way` along a column of S, of delays and of the inputs: into r->after */
static void struck_at(lamc_sensitivity *s, const room *r, lamc_real t, const lamc_real *y,
                      const lamc_real *column, lamc_real late, int c, lamc_real way,
                      const lamc_real *struck) {
  const lamc_model *model = s->motion.model;
  const int n = s->run.ode.n, inputs = model->parameter_count + model->geometry_count;
  for (int i = 0; i < n; i++) r->after[i] = y[i] + way * column[i];
  if (c < s->tangents->column_count) {
    const lamc_real *direction = s->directions + (ptrdiff_t)c * inputs;
    for (int i = 0; i < inputs; i++) r->inputs[i] = s->inputs[i] + way * direction[i];
    model->setup(r->inputs, s->beside.constants);
    lamc_series_put(&s->beside, t);
    for (int g = 0; g < model->guard_count; g++) {
      const int mode = model->guard_modes[g];
      if (mode >= 0) s->beside.constants[mode] = r->constants[mode];
    }
  }
  lamc_impacts(&s->beside, t + way * late, r->after, struck);
}

/* How far one may go along a column: a hundredth of a radian, and of every input */
static lamc_real reach_of(const lamc_sensitivity *s, const lamc_real *column, int c) {
  const lamc_model *model = s->motion.model;
  const int inputs = model->parameter_count + model->geometry_count;
  lamc_real most = 0;
  for (int i = 0; i < model->coordinate_count; i++) most = larger(most, fabs(column[i]));
  for (int i = 0; i < inputs && c < s->tangents->column_count; i++) {
    const lamc_real pace = fabs(s->directions[(ptrdiff_t)c * inputs + i]), size = fabs(s->inputs[i]);
    if (pace > 0) most = larger(most, size > 0 ? pace / size : pace);
  }
  return LAMC_R(0.01) / (most > 0 ? most : 1);
}

/* S- + f- tau, replaced by what the impact makes of it. Its map is an algebraic one, and happens seldom: differences of order
 * 6 know its derivatives to some 1e-12. */
static void strike(lamc_sensitivity *s, const room *r, lamc_real t, const lamc_real *y, const lamc_real *late,
                   const lamc_real *struck) {
  static const lamc_real WEIGHT[3] = {LAMC_R(0.75), LAMC_R(-0.15), LAMC_R(1.0) / 60};
  const int n = s->run.ode.n, nq = s->motion.model->coordinate_count;
  lamc_real *column = r->argument, *sum = r->argument + n; /* (n, width) has room for two: width >= LANES */
  memcpy(r->constants, s->beside.constants, (size_t)s->motion.model->constant_count * sizeof *sum);
  for (int c = 0; c < s->column_count; c++) {
    for (int i = 0; i < n; i++) {
      column[i] = s->here[(ptrdiff_t)i * s->width + c];
      sum[i] = 0;
    }
    const lamc_real reach = reach_of(s, column, c);
    for (int k = 0; k < 6; k++) {
      const lamc_real sign = k % 2 == 0 ? 1 : -1;
      const lamc_real way = sign * reach * (lamc_real)(k / 2 + 1);
      struck_at(s, r, t, y, column, late[c], c, way, struck);
      for (int i = nq; i < n; i++) sum[i] += sign * WEIGHT[k / 2] / reach * r->after[i];
    }
    for (int i = nq; i < n; i++) s->here[(ptrdiff_t)i * s->width + c] = sum[i];
  }
  memcpy(s->beside.constants, r->constants, (size_t)s->motion.model->constant_count * sizeof *sum);
}

/* here += sign slope late, by rows and columns */
static void shift(lamc_sensitivity *s, lamc_real sign, const lamc_real *slope, const lamc_real *late) {
  for (int i = 0; i < s->run.ode.n; i++)
    lamc_row_less(s->width, -sign * slope[i], late, s->here + (ptrdiff_t)i * s->width);
}

/* dy/dt beside the run */
static void slope_beside(lamc_sensitivity *s, lamc_real t, const lamc_real *y, lamc_real *slope) {
  const int nq = s->motion.model->coordinate_count;
  lamc_motion_rates(&s->beside, y, y + nq, slope);
  lamc_motion_accelerate(&s->beside, t, y, y + nq, slope + nq);
}

/* What clocks hold from here on, by columns: those that are struck, or all (NULL), sample y */
static void sample(lamc_sensitivity *s, lamc_real t, const lamc_real *y, const lamc_real *struck) {
  const lamc_model *model = s->motion.model;
  if (model->held_count == 0) return;
  const variation v = lamc_variation_of(s);
  const int across = v.n + v.k + v.held_count;
  lamc_real *next = s->held + (ptrdiff_t)model->held_count * s->held_width;
  lamc_series_put(&s->beside, t);
  s->tangents->samples(s->beside.constants, t, y, y + v.nq, v.derivative);
  for (int h = 0; h < model->held_count; h++) {
    lamc_real *row = next + (ptrdiff_t)h * s->held_width;
    lamc_minus_along(&v, v.n, v.derivative + (ptrdiff_t)h * across, s->here, row);
    lamc_row_scale(s->width, -1, row);
  }
  for (int h = 0; h < model->held_count; h++) {
    if (struck != NULL && !(struck[model->clock_guards[model->held_clocks[h]]] > 0)) continue;
    memcpy(s->held + (ptrdiff_t)h * s->held_width, next + (ptrdiff_t)h * s->held_width,
           (size_t)s->held_width * sizeof *next);
  }
}

/* One guard is struck: a switch, or an impact */
static lamc_status meet_one(lamc_sensitivity *s, const room *r, lamc_real t, lamc_real *y, int guard,
                            const lamc_real *struck) {
  lamc_real *late = r->collocation; /* (width,): nothing else is there between steps */
  const int is_passed = delay(s, t, y, slope_here(&s->run), guard, late);
  if (is_passed) {
    shift(s, 1, slope_here(&s->run), late);
    if (s->motion.model->guard_modes[guard] < 0) strike(s, r, t, y, late, struck);
  } else {
    lose(s, t, LAMC_LOST_GRAZING, guard);
  }
  const lamc_status status = lamc_guards_event(&s->motion, t, y, struck);
  take_constants(s);
  if (is_passed) {
    slope_beside(s, t, y, r->after);
    shift(s, -1, r->after, late);
  }
  return status;
}

/* Several switches at one instant, such as those of two feet that touch down together. Each turns a force of its own on or
 * off: where their effects on dy/dt add up, it does not matter which comes first, and each has its part in the jump. */
static lamc_status meet_switches(lamc_sensitivity *s, const room *r, lamc_real t, lamc_real *y,
                                 const lamc_real *struck) {
  const lamc_model *model = s->motion.model;
  const int n = s->run.ode.n;
  const lamc_real *before = slope_here(&s->run);
  lamc_real *late = r->collocation, *sum = r->y, size = 0, apart = 0;
  memcpy(sum, before, (size_t)n * sizeof *sum);
  int last = -1;
  for (int g = 0; g < model->guard_count; g++) {
    if (!(struck[g] > 0)) continue;
    lamc_real *mode = &s->beside.constants[model->guard_modes[g]];
    last = g;
    if (!delay(s, t, y, before, g, late)) {
      lose(s, t, LAMC_LOST_GRAZING, g);
      break;
    }
    *mode = 1 - *mode;
    slope_beside(s, t, y, r->after);
    *mode = 1 - *mode;
    for (int i = 0; i < n; i++) {
      r->after[i] = before[i] - r->after[i];
      sum[i] -= r->after[i];
    }
    shift(s, 1, r->after, late);
  }
  const lamc_status status = lamc_guards_event(&s->motion, t, y, struck);
  take_constants(s);
  slope_beside(s, t, y, r->after);
  for (int i = 0; i < n; i++) {
    size = larger(size, fabs(r->after[i]) + fabs(before[i]));
    apart = larger(apart, fabs(r->after[i] - sum[i]));
  }
  if (!(apart <= sqrt(LAMC_EPSILON) * size)) lose(s, t, LAMC_LOST_TOGETHER, last);
  return status;
}

/* The event of the run, and what it does to S */
static lamc_status meet(const void *context, lamc_real t, lamc_real *y, const lamc_real *struck) {
  lamc_sensitivity *s = (lamc_sensitivity *)context; /* whose first member is the motion */
  const room r = room_of(s);
  if (s->run.t > s->t) {
    follow(s);
    if (wants_rows_within(&s->run) && lamc_is_replayed(s->method)) lamc_replay_extend(s, r.argument, r.y);
  } else {
    take_constants(s);
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
    sample(s, t, y, struck);
    const lamc_status status = lamc_guards_event(context, t, y, struck);
    take_constants(s);
    return status;
  }
  if (count > 1 && impacts + ticks > 0) lose(s, t, LAMC_LOST_TOGETHER, guard);
  if (s->lost != LAMC_NOT_LOST) return lamc_guards_event(context, t, y, struck);
  const lamc_status status =
      count == 1 ? meet_one(s, &r, t, y, guard, struck) : meet_switches(s, &r, t, y, struck);
  lamc_vary_settle(s, t, y, s->here, r.argument);
  return status;
}

/* A step that ended at a break of a series is followed before the run looks at what comes after it. Breaks stand still: S
 * does not jump there. */
static void pass(const void *context, long long next) {
  lamc_sensitivity *s = (lamc_sensitivity *)context; /* whose first member is the motion */
  if (s->run.t > s->t) {
    const room r = room_of(s);
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
  s->width = padded(column_count);
  s->t = t0;
  s->t_lost = HUGE_VAL;
  s->t_break = -HUGE_VAL;
  room r;
  (void)lay_out(s, &r, motion->model, tangents->column_count, column_count, work);
  if (motion->model->cut_count > 0) lamc_loops_begin(&s->beside);
  lamc_ode ode = lamc_motion_ode(&s->motion);
  ode.integral_count = 0;
  if (ode.guard_count > 0) ode.event = meet;
  if (ode.pass != NULL) ode.pass = pass;
  const lamc_status status =
      lamc_run_start(&s->run, &ode, which, options, t0, y0, t_end, t_eval, t_eval_count, run_work);
  for (int i = 0; i < ode.n; i++)
    memcpy(s->here + (ptrdiff_t)i * s->width, s0 + (ptrdiff_t)i * column_count,
           (size_t)column_count * sizeof *s0);
  if (status != LAMC_OK) return status;
  take_constants(s);
  s->beside.baumgarte = 0;                          /* a start is closed whatever comes of it */
  lamc_vary_settle(s, t0, y0, s->here, r.argument); /* differences of starts know it to some 1e-9 */
  s->beside.baumgarte = motion->baumgarte;
  sample(s, t0, y0, NULL);
  return status;
}

/* S (n, column_count) of a row */
static void write_row(lamc_sensitivity *s, lamc_real t, const lamc_real *y, lamc_real *out) {
  const int n = s->run.ode.n;
  const lamc_real *block = s->here;
  if (t < s->run.t && s->run.h_last > 0) {
    const room r = room_of(s);
    const lamc_real x = (t - s->run.t_old) / s->h;
    if (lamc_is_replayed(s->method)) {
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
    if (rows->t[k] < s->run.t && s->run.h_last > 0) make_ready(s, room_of(s).y);
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
    if (lamc_motion_singular_steps(&s->motion) > singular) lose(s, run->t_old, LAMC_LOST_SINGULAR, -1);
  }
}
