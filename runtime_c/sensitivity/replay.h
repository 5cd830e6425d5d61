/* replay.h, of lamc: a step of an explicit Runge-Kutta method once more, for the derivatives of what it computed.
 *
 * The stages of S are those of y, with the same weights, so that S is the derivative of the step itself. The slopes of y
 * lie in the run's work still: the states of the stages follow from them without an evaluation. */
#ifndef LAMC_REPLAY_H
#define LAMC_REPLAY_H

#include "ahead.h"
#include "tableau.h"
#include "variation.h"

static inline lamc_real *lamc_slope_of(const lamc_sensitivity *s, int stage) {
  return s->slopes + (ptrdiff_t)stage * s->run.ode.n * s->width;
}

/* S (n, width) at a stage, from where the step began */
static inline void lamc_replay_argument(const lamc_sensitivity *s, const tableau *a, int stage, lamc_real h,
                                        lamc_real *out) {
  const ptrdiff_t size = (ptrdiff_t)s->run.ode.n * s->width;
  lamc_weighted_sum(size, s->start, h, stage < a->across ? stage : a->across,
                    a->weight + (ptrdiff_t)stage * a->across, s->slopes, out);
}

/* Where a stage of the last step was evaluated; y: (n,) of scratch */
static inline lamc_place lamc_stage_place(lamc_sensitivity *s, const tableau *a, int stage, lamc_real *y) {
  const lamc_run *run = &s->run;
  const lamc_real *slope = lamc_run_slope(run, a, stage), t = lamc_stage_time(run, a, stage);
  lamc_place place;
  if (lamc_recall(s, t, slope, &place)) return place;
  lamc_stage_state(run, a, stage, y);
  return lamc_place_beside(s, t, y, slope + s->motion.model->coordinate_count);
}

/* dS/dt at a stage with derivatives sens (n, width), among the slopes; y: (n,) of scratch */
static inline void lamc_replay_slope(lamc_sensitivity *s, const tableau *a, int stage, const lamc_real *sens,
                                     lamc_real *y) {
  if (stage >= s->ahead_first && stage < s->ahead_beyond) {
    lamc_vary_ahead(s, a, stage, sens, y, lamc_slope_of(s, stage));
    return;
  }
  const lamc_place place = lamc_stage_place(s, a, stage, y);
  lamc_vary(s, &place, sens, lamc_slope_of(s, stage));
}

/* One stage: dS/dt there. argument, y: (n, width) and (n,) of scratch */
static inline void lamc_replay_stage(lamc_sensitivity *s, const tableau *a, int stage, lamc_real *argument,
                                     lamc_real *y) {
  lamc_replay_argument(s, a, stage, s->run.h_last, argument);
  lamc_replay_slope(s, a, stage, argument, y);
}

/* dS/dt at the end of the last step; y: (n,) of scratch */
static inline void lamc_replay_end(lamc_sensitivity *s, lamc_real *y) {
  const tableau a = lamc_tableau(s->run.method);
  lamc_replay_slope(s, &a, a.last, s->end, y);
}

/* S over the last step of an explicit method, from `start` to `end`; argument and y: scratch, (n, width) and (n,) */
static inline void lamc_replay(lamc_sensitivity *s, lamc_real *argument, lamc_real *y) {
  const lamc_run *run = &s->run;
  const tableau a = lamc_tableau(run->method);
  const size_t bytes = (size_t)run->ode.n * (size_t)s->width * sizeof *argument;
  int first = 0;
  if (s->has_slope) { /* the last slope of the step before, and of the same method or not: S and y are the same */
    const tableau before = lamc_tableau(s->method);
    memmove(lamc_slope_of(s, 0), lamc_slope_of(s, before.last), bytes);
    first = 1;
  }
  (void)lamc_look_ahead(s, &a, first, a.last + 1, y);
  for (int stage = first; stage < a.last; stage++) lamc_replay_stage(s, &a, stage, argument, y);
  lamc_replay_argument(s, &a, a.last, run->h_last, s->end);
  if (s->motion.model->cut_count > 0 && s->beside.baumgarte == 0) {
    const lamc_place end = lamc_stage_place(s, &a, a.last, y);
    lamc_vary_settle_at(s, &end, s->end, argument);
  }
  lamc_replay_slope(s, &a, a.last, s->end, y);
  s->slope_count = a.last + 1;
  s->has_slope = 1;
}

/* The slopes that the continuous extension takes besides, if it does */
static inline void lamc_replay_extend(lamc_sensitivity *s, lamc_real *argument, lamc_real *y) {
  const tableau a = lamc_tableau(s->method);
  if (s->slope_count < a.count) (void)lamc_look_ahead(s, &a, s->slope_count, a.count, y);
  for (; s->slope_count < a.count; s->slope_count++) lamc_replay_stage(s, &a, s->slope_count, argument, y);
}

/* out += part times sum over slopes of weight times slope */
static inline void lamc_add_slopes(const lamc_sensitivity *s, int count, lamc_real part,
                                   const lamc_real *weights, lamc_real *out) {
  const ptrdiff_t size = (ptrdiff_t)s->run.ode.n * s->width;
  for (int j = 0; j < count; j++)
    if (weights[j] != 0) lamc_add_weighted(size, part * weights[j], lamc_slope_of(s, j), out);
}

/* S (n, width) at t_old + x h of a step that was replayed: the continuous extension of dop853.c, or of rk45.c, by powers of
 * x and 1 - x */
static inline void lamc_replay_at(const lamc_sensitivity *s, lamc_real x, lamc_real *out) {
  const tableau a = lamc_tableau(s->method);
  const ptrdiff_t size = (ptrdiff_t)s->run.ode.n * s->width;
  const lamc_real z = 1 - x, h = s->h;
  const lamc_real *begin = lamc_slope_of(s, 0), *end = lamc_slope_of(s, a.last);
  const lamc_real of_change = x - x * z + 2 * x * x * z, of_begin = h * (x * z - x * x * z),
                  of_end = -h * x * x * z;
  for (ptrdiff_t i = 0; i < size; i++)
    out[i] = s->start[i] + of_change * (s->end[i] - s->start[i]) + of_begin * begin[i] + of_end * end[i];
  const lamc_real fourth = h * x * x * z * z;
  if (s->method == LAMC_RK45) {
    lamc_add_slopes(s, 7, fourth, RK45_D, out);
    return;
  }
  lamc_add_slopes(s, 16, fourth, DOP853_D[0], out);
  lamc_add_slopes(s, 16, fourth * x, DOP853_D[1], out);
  lamc_add_slopes(s, 16, fourth * x * z, DOP853_D[2], out);
  lamc_add_slopes(s, 16, fourth * x * z * x, DOP853_D[3], out);
}

#endif /* LAMC_REPLAY_H */
