/* replay.h, of lamc: a step of an explicit Runge-Kutta method once more, for the derivatives of what it computed.
 *
 * The stages of S are those of y, with the same weights, so that S is the derivative of the step itself. The slopes of y
 * lie in the run's work still: the states of the stages follow from them without an evaluation. */
#ifndef LAMC_REPLAY_H
#define LAMC_REPLAY_H

#include "tableau.h"
#include "variation.h"

static inline lamc_real *lamc_slope_of(const lamc_sensitivity *s, int stage) {
  return s->slopes + (ptrdiff_t)stage * s->run.ode.n * s->width;
}

/* dy/dt of the run at a stage of its last step */
static inline const lamc_real *lamc_run_slope(const lamc_run *run, const tableau *a, int stage) {
  if (stage == 0) return slope_there(run);
  if (stage == a->last) return slope_here(run);
  return slot(run, SLOT_OWN + (stage < a->last ? stage - 1 : stage - 2));
}

/* out += weight times v, of (count,), whole packs */
static inline void lamc_add_weighted(ptrdiff_t count, lamc_real weight, const lamc_real *LAMC_RESTRICT v,
                                     lamc_real *LAMC_RESTRICT out) {
  for (ptrdiff_t b = 0; b < count; b += PACK)
    lamc_pack_put(out + b, lamc_pack_add(lamc_pack_at(out + b), weight, lamc_pack_at(v + b)));
}

/* out = from + sum over the first `count` slopes of h weight times slope; of (size,), whole packs, each */
static inline void lamc_weighted_sum(ptrdiff_t size, const lamc_real *LAMC_RESTRICT from, lamc_real h,
                                     int count, const lamc_real *weights,
                                     const lamc_real *LAMC_RESTRICT slopes, lamc_real *LAMC_RESTRICT out) {
  const lamc_real *used[16];
  lamc_real weight[16];
  int terms = 0;
  for (int j = 0; j < count; j++) {
    if (weights[j] == 0) continue;
    used[terms] = slopes + j * size;
    weight[terms++] = h * weights[j];
  }
  for (ptrdiff_t b = 0; b < size; b += PACK) {
    lamc_pack sum = lamc_pack_at(from + b);
    for (int j = 0; j < terms; j++) sum = lamc_pack_add(sum, weight[j], lamc_pack_at(used[j] + b));
    lamc_pack_put(out + b, sum);
  }
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
  const int n = run->ode.n;
  const lamc_real h = run->h_last, t = stage == a->last ? run->t : run->t_old + a->node[stage] * h;
  const lamc_real *slope = lamc_run_slope(run, a, stage);
  lamc_place place;
  if (lamc_recall(s, t, slope, &place)) return place;
  memcpy(y, stage == a->last ? y_here(run) : y_there(run), (size_t)n * sizeof *y);
  for (int j = 0; j < stage && j < a->across && stage != a->last; j++) {
    const lamc_real weight = a->weight[stage * a->across + j];
    const lamc_real *earlier = lamc_run_slope(run, a, j);
    for (int i = 0; i < n && weight != 0; i++) y[i] += h * weight * earlier[i];
  }
  return lamc_place_beside(s, t, y, slope + s->motion.model->coordinate_count);
}

/* One stage: dS/dt there. argument, y: (n, width) and (n,) of scratch */
static inline void lamc_replay_stage(lamc_sensitivity *s, const tableau *a, int stage, lamc_real *argument,
                                     lamc_real *y) {
  const lamc_place place = lamc_stage_place(s, a, stage, y);
  lamc_replay_argument(s, a, stage, s->run.h_last, argument);
  lamc_vary(s, &place, argument, lamc_slope_of(s, stage));
}

/* dS/dt at the end of the last step; y: (n,) of scratch */
static inline void lamc_replay_end(lamc_sensitivity *s, lamc_real *y) {
  const tableau a = lamc_tableau(s->run.method);
  const lamc_place end = lamc_stage_place(s, &a, a.last, y);
  lamc_vary(s, &end, s->end, lamc_slope_of(s, a.last));
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
  for (int stage = first; stage < a.last; stage++) lamc_replay_stage(s, &a, stage, argument, y);
  lamc_replay_argument(s, &a, a.last, run->h_last, s->end);
  const lamc_place end = lamc_stage_place(s, &a, a.last, y);
  if (s->motion.model->cut_count > 0 && s->beside.baumgarte == 0)
    lamc_vary_settle_at(s, &end, s->end, argument);
  lamc_vary(s, &end, s->end, lamc_slope_of(s, a.last));
  s->slope_count = a.last + 1;
  s->has_slope = 1;
}

/* The slopes that the continuous extension takes besides, if it does */
static inline void lamc_replay_extend(lamc_sensitivity *s, lamc_real *argument, lamc_real *y) {
  const tableau a = lamc_tableau(s->method);
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
