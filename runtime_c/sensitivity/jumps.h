/* jumps.h, of lamc: what events do to the derivatives of a run.
 *
 * In:    a struck guard g at t*, where it passes zero, and S before it. Out: S behind it, and samples of clocks by columns.
 * Never: decides when an event is, or what it does to the run.
 *
 * With tau = -dg / g', how much later the event comes, a map h of the event and slopes f before and after it,
 * S+ = dh(S- + f- tau) - f+ tau. */
#ifndef LAMC_JUMPS_H
#define LAMC_JUMPS_H

#include "lamc_sensitivity.h"

#include "guards.h"
#include "impacts.h"
#include "layout.h"
#include "series.h"

/* From t on there are no derivatives */
static inline void lamc_lose(lamc_sensitivity *s, lamc_real t, lamc_lost why, int guard) {
  if (s->lost != LAMC_NOT_LOST) return;
  s->lost = (int)why;
  s->t_lost = t;
  s->lost_guard = guard;
}

/* Constants as the run has them now */
static inline void lamc_take_constants(lamc_sensitivity *s) {
  const size_t bytes = (size_t)s->motion.model->constant_count * sizeof(lamc_real);
  if (memcmp(s->beside.constants, s->motion.constants, bytes) == 0) return;
  memcpy(s->beside.constants, s->motion.constants, bytes);
  s->has_new_constants = 1;
}

/* How much later the event comes, by column, into the first row of `out`. 0: the guard is touched and not passed */
static inline int lamc_delay(lamc_sensitivity *s, lamc_real t, const lamc_real *y, const lamc_real *slope,
                             int guard, lamc_real *out) {
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
static inline void lamc_struck_at(lamc_sensitivity *s, const lamc_room *r, lamc_real t, const lamc_real *y,
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
  } else { /* those that a column of inputs moved */
    memcpy(s->beside.constants, r->constants, (size_t)model->constant_count * sizeof *r->constants);
  }
  lamc_impacts(&s->beside, t + way * late, r->after, struck);
}

/* How far one goes along a column from y: a thousandth of a radian, of the rates, and of every input. Loops near a singular
 * position bend within hundredths. Rates count too: where one freedom meets its limit, positions of the column are round-off,
 * which must not be blown up. */
static inline lamc_real lamc_reach_of(const lamc_sensitivity *s, const lamc_real *y, const lamc_real *column,
                                      int c) {
  const lamc_model *model = s->motion.model;
  const int inputs = model->parameter_count + model->geometry_count, nq = model->coordinate_count;
  lamc_real most = 0, rate = 0, fastest = 0;
  for (int i = 0; i < nq; i++) most = larger(most, fabs(column[i]));
  for (int i = nq; i < s->run.ode.n; i++) {
    rate = larger(rate, fabs(column[i]));
    fastest = larger(fastest, fabs(y[i]));
  }
  if (fastest > 0) most = larger(most, rate / fastest);
  for (int i = 0; i < inputs && c < s->tangents->column_count; i++) {
    const lamc_real pace = fabs(s->directions[(ptrdiff_t)c * inputs + i]), size = fabs(s->inputs[i]);
    if (pace > 0) most = larger(most, size > 0 ? pace / size : pace);
  }
  return LAMC_R(0.001) / (most > 0 ? most : 1);
}

/* S- + f- tau, replaced by what the impact makes of it. Its map is an algebraic one, and happens seldom: differences of order
 * 6 know its derivatives to some 1e-11, and to some 1e-9 in loops near a singular position. */
static inline void lamc_strike(lamc_sensitivity *s, const lamc_room *r, lamc_real t, const lamc_real *y,
                               const lamc_real *late, const lamc_real *struck) {
  static const lamc_real WEIGHT[3] = {LAMC_R(0.75), LAMC_R(-0.15), LAMC_R(1.0) / 60};
  const int n = s->run.ode.n, nq = s->motion.model->coordinate_count;
  lamc_real *column = r->argument,
            *sum = r->argument + n; /* (n, width) has room for two: width is 2 or more */
  memcpy(r->constants, s->beside.constants, (size_t)s->motion.model->constant_count * sizeof *sum);
  for (int c = 0; c < s->column_count; c++) {
    for (int i = 0; i < n; i++) {
      column[i] = s->here[(ptrdiff_t)i * s->width + c];
      sum[i] = 0;
    }
    const lamc_real reach = lamc_reach_of(s, y, column, c);
    for (int k = 0; k < 6; k++) {
      const lamc_real sign = k % 2 == 0 ? 1 : -1;
      const lamc_real way = sign * reach * (lamc_real)(k / 2 + 1);
      lamc_struck_at(s, r, t, y, column, late[c], c, way, struck);
      for (int i = nq; i < n; i++) sum[i] += sign * WEIGHT[k / 2] / reach * r->after[i];
    }
    for (int i = nq; i < n; i++) s->here[(ptrdiff_t)i * s->width + c] = sum[i];
  }
  memcpy(s->beside.constants, r->constants, (size_t)s->motion.model->constant_count * sizeof *sum);
}

/* here += sign slope late, by rows and columns */
static inline void lamc_shift(lamc_sensitivity *s, lamc_real sign, const lamc_real *slope,
                              const lamc_real *late) {
  for (int i = 0; i < s->run.ode.n; i++)
    lamc_row_less(s->width, -sign * slope[i], late, s->here + (ptrdiff_t)i * s->width);
}

/* dy/dt beside the run */
static inline void lamc_slope_beside(lamc_sensitivity *s, lamc_real t, const lamc_real *y, lamc_real *slope) {
  const int nq = s->motion.model->coordinate_count;
  lamc_motion_rates(&s->beside, y, y + nq, slope);
  lamc_motion_accelerate(&s->beside, t, y, y + nq, slope + nq);
}

/* What clocks hold from here on, by columns: those that are struck, or all (NULL), sample y */
static inline void lamc_sample(lamc_sensitivity *s, lamc_real t, const lamc_real *y,
                               const lamc_real *struck) {
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
static inline lamc_status lamc_meet_one(lamc_sensitivity *s, const lamc_room *r, lamc_real t, lamc_real *y,
                                        int guard, const lamc_real *struck) {
  lamc_real *late = r->collocation; /* (width,): nothing else is there between steps */
  const int is_passed = lamc_delay(s, t, y, slope_here(&s->run), guard, late);
  if (is_passed) {
    lamc_shift(s, 1, slope_here(&s->run), late);
    if (s->motion.model->guard_modes[guard] < 0) lamc_strike(s, r, t, y, late, struck);
  } else {
    lamc_lose(s, t, LAMC_LOST_GRAZING, guard);
  }
  const lamc_status status = lamc_guards_event(&s->motion, t, y, struck);
  lamc_take_constants(s);
  if (is_passed) {
    lamc_slope_beside(s, t, y, r->after);
    lamc_shift(s, -1, r->after, late);
  }
  return status;
}

/* Several switches at one instant, such as those of two feet that touch down together. Each turns a force of its own on or
 * off: where their effects on dy/dt add up, it does not matter which comes first, and each has its part in the jump. */
static inline lamc_status lamc_meet_switches(lamc_sensitivity *s, const lamc_room *r, lamc_real t,
                                             lamc_real *y, const lamc_real *struck) {
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
    if (!lamc_delay(s, t, y, before, g, late)) {
      lamc_lose(s, t, LAMC_LOST_GRAZING, g);
      break;
    }
    *mode = 1 - *mode;
    lamc_slope_beside(s, t, y, r->after);
    *mode = 1 - *mode;
    for (int i = 0; i < n; i++) {
      r->after[i] = before[i] - r->after[i];
      sum[i] -= r->after[i];
    }
    lamc_shift(s, 1, r->after, late);
  }
  const lamc_status status = lamc_guards_event(&s->motion, t, y, struck);
  lamc_take_constants(s);
  lamc_slope_beside(s, t, y, r->after);
  for (int i = 0; i < n; i++) {
    size = larger(size, fabs(r->after[i]) + fabs(before[i]));
    apart = larger(apart, fabs(r->after[i] - sum[i]));
  }
  if (!(apart <= sqrt(LAMC_EPSILON) * size)) lamc_lose(s, t, LAMC_LOST_TOGETHER, last);
  return status;
}

#endif /* LAMC_JUMPS_H */
