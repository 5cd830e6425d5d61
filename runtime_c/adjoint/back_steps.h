/* back_steps.h, of lamc: one step of an explicit method, backwards.
 *
 * In: derivatives by the state at the end of a step, and by rows within. Out: by the state where it began, and by the sources.
 * Never: differs from the transpose of what replay.h and finely.h do: the stages are gone through once more, and then back. */
#ifndef LAMC_BACK_STEPS_H
#define LAMC_BACK_STEPS_H

#include "pulling.h"

/* A step, or a part of one */
typedef struct stretch {
  lamc_real t_old, t, h;
  const lamc_real *before, *after;
} stretch;

/* Of an error of derivatives in a step, over their size, what the tolerance of the run allows. finely.h looks at one column at a
 * time and allows more; here what weighs all of the state is looked at. */
static const lamc_real ADJOINT_PER_RTOL = 10;

static inline lamc_real *lamc_of_stage(const room *r, lamc_real *rows, int stage) {
  return rows + (ptrdiff_t)stage * r->n;
}

static inline lamc_real lamc_stage_time(const tableau *b, const stretch *s, int stage) {
  return stage == b->last ? s->t : s->t_old + b->node[stage] * s->h;
}

static inline lamc_real lamc_stage_weight(const tableau *b, int stage, int earlier) {
  return earlier < b->across ? b->weight[stage * b->across + earlier] : 0;
}

/* Slopes and states of stages `from` to `to` - 1 */
static inline void lamc_stages(lamc_adjoint *a, const room *r, const tableau *b, const stretch *s, int from,
                               int to) {
  for (int stage = from; stage < to; stage++) {
    lamc_real *y = lamc_of_stage(r, r->states, stage);
    memcpy(y, stage == b->last ? s->after : s->before, (size_t)r->n * sizeof *y);
    for (int j = 0; j < stage && stage != b->last; j++) {
      const lamc_real weight = lamc_stage_weight(b, stage, j);
      if (weight != 0) lamc_add_to(r->n, s->h * weight, lamc_of_stage(r, r->slopes, j), y);
    }
    lamc_slope(a, r, lamc_stage_time(b, s, stage), y, lamc_of_stage(r, r->slopes, stage));
  }
}

/* Back through a stage: what weighs its slope goes to the state that it began from, to earlier slopes, and to `sources` */
static inline void lamc_stage_back(lamc_adjoint *a, const room *r, const tableau *b, const stretch *s,
                                   int stage, lamc_real *state, lamc_real *sources) {
  const lamc_real *y = lamc_of_stage(r, r->states, stage), t = lamc_stage_time(b, s, stage);
  lamc_real *by_argument = r->first;
  memset(by_argument, 0, (size_t)r->n * sizeof *by_argument);
  const int count = lamc_prepare(a, r, t, y);
  lamc_pull(a, r, t, y, count, lamc_of_stage(r, r->pulls, stage), by_argument, sources);
  lamc_add_to(r->n, 1, by_argument, state);
  for (int j = 0; j < stage && stage != b->last; j++) {
    const lamc_real weight = lamc_stage_weight(b, stage, j);
    if (weight != 0) lamc_add_to(r->n, s->h * weight, by_argument, lamc_of_stage(r, r->pulls, j));
  }
}

/* What a row at t_old + x h weighs the state where the step began with, that at its end, and slopes: see lamc_replay_at */
static inline void lamc_row_back(const room *r, const tableau *b, const stretch *s, lamc_real x,
                                 const lamc_real *seed, lamc_real *begin, lamc_real *end) {
  const lamc_real z = 1 - x, h = s->h, fourth = h * x * x * z * z;
  const lamc_real of_change = x - x * z + 2 * x * x * z;
  lamc_add_to(r->n, 1 - of_change, seed, begin);
  lamc_add_to(r->n, of_change, seed, end);
  lamc_add_to(r->n, h * (x * z - x * x * z), seed, lamc_of_stage(r, r->pulls, 0));
  lamc_add_to(r->n, -h * x * x * z, seed, lamc_of_stage(r, r->pulls, b->last));
  for (int j = 0; j < b->count; j++) {
    const lamc_real higher = DOP853_D[1][j] + z * (DOP853_D[2][j] + x * DOP853_D[3][j]);
    const lamc_real weight = fourth * (b->last == 6 ? RK45_D[j % 7] : DOP853_D[0][j] + x * higher);
    if (weight != 0) lamc_add_to(r->n, weight, seed, lamc_of_stage(r, r->pulls, j));
  }
}

/* Takes the last row within a step off the list: where it is, and the derivatives by it as it was before it was brought to
 * closure. 0: there is none */
static inline int lamc_next_row(lamc_adjoint *a, const room *r, const stretch *s, lamc_real *x,
                                lamc_real *seed) {
  const lamc_real t = a->rows > 0 ? a->row_t[a->rows - 1] : s->t;
  if (!(t > s->t_old) || !(t < s->t)) return 0;
  const ptrdiff_t row = (ptrdiff_t)--a->rows;
  *x = (t - s->t_old) / s->h;
  memcpy(seed, a->seeds + row * r->n, (size_t)r->n * sizeof *seed);
  lamc_pull_settle(a, r, t, a->row_y + row * r->n, seed);
  return 1;
}

/* The largest of v over the largest of `size` */
static inline lamc_real lamc_ratio(int n, const lamc_real *v, const lamc_real *size) {
  lamc_real most = 0, largest = 0;
  for (int i = 0; i < n; i++) {
    most = larger(most, fabs(v[i]));
    largest = larger(largest, fabs(size[i]));
  }
  return largest > 0 ? most / largest : 0;
}

/* Derivatives of an error estimate of the step, weighed with `end`, over `end`, by the state where it began */
static inline lamc_real lamc_error_back(lamc_adjoint *a, const room *r, const tableau *b, const stretch *s,
                                        const lamc_real *estimate, int count, const lamc_real *end) {
  memset(r->pulls, 0, STAGES * (size_t)r->n * sizeof *end);
  memset(r->error, 0, (size_t)r->n * sizeof *end);
  for (int j = 0; j < count; j++) lamc_add_to(r->n, s->h * estimate[j], end, lamc_of_stage(r, r->pulls, j));
  if (count > b->last) { /* its slope is of the end of the step, which all others make */
    lamc_stage_back(a, r, b, s, b->last, r->error, NULL);
    for (int j = 0; j < b->last; j++)
      lamc_add_to(r->n, s->h * lamc_stage_weight(b, b->last, j), r->error, lamc_of_stage(r, r->pulls, j));
  }
  for (int stage = b->last - 1; stage >= 0; stage--) lamc_stage_back(a, r, b, s, stage, r->error, NULL);
  return lamc_ratio(r->n, r->error, end);
}

/* 1 if the step is too long for derivatives, as steps behind an event may be, where forces begin with a power of time */
static inline int lamc_is_too_long(lamc_adjoint *a, const room *r, const tableau *b, const stretch *s,
                                   const lamc_real *end) {
  static const lamc_real RK45_E[7] = {71.0 / 57600.0,      0.0,          -71.0 / 16695.0, 71.0 / 1920.0,
                                      -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0};
  const lamc_real enough = ADJOINT_PER_RTOL * a->rtol;
  if (b->last == 6) {
    lamc_stages(a, r, b, s, 6, 7);
    return lamc_error_back(a, r, b, s, RK45_E, 7, end) > enough;
  }
  const lamc_real five = lamc_error_back(a, r, b, s, DOP853_E5, 12, end);
  if (!(five > enough)) return 0; /* the estimate below is smaller */
  const lamc_real three = lamc_error_back(a, r, b, s, DOP853_E3, 12, end);
  return five * five / sqrt(five * five + LAMC_R(0.01) * three * three) > enough;
}

/* Slopes are weighed with what they make of the end of the step, and the stages gone back through; begin: by the state where
 * the step began */
static inline void lamc_weights_back(lamc_adjoint *a, const room *r, const tableau *b, const stretch *s,
                                     const lamc_real *end, lamc_real *begin) {
  if (end != NULL) {
    lamc_add_to(r->n, 1, end, begin);
    for (int j = 0; j < b->last; j++) {
      const lamc_real weight = lamc_stage_weight(b, b->last, j);
      if (weight != 0) lamc_add_to(r->n, s->h * weight, end, lamc_of_stage(r, r->pulls, j));
    }
  }
  for (int stage = b->last - 1; stage >= 0; stage--) lamc_stage_back(a, r, b, s, stage, begin, a->sources);
}

/* The same over the step in parts by DOP853, half as long as the next ones towards both ends, so that those are short enough
 * for whatever begins or ends there. `end` is replaced by the derivatives by where the step began. */
static inline void lamc_finely_back(lamc_adjoint *a, const room *r, const stretch *s, lamc_real *end) {
  const tableau b = lamc_tableau(LAMC_DOP853);
  lamc_real at[FINE_PARTS + 1] = {0};
  for (int k = 1; k < FINE_PARTS; k++)
    at[k] = k <= FINE_PARTS / 2 ? ldexp(s->h, k - FINE_PARTS / 2 - 1)
                                : s->h - ldexp(s->h, FINE_PARTS / 2 - k - 1);
  at[FINE_PARTS] = s->h;
  memcpy(r->fine, s->before, (size_t)r->n * sizeof *end);
  for (int way = 0; way < 2; way++) {
    for (int i = 0; i < FINE_PARTS; i++) {
      const int k = way == 0 ? i : FINE_PARTS - 1 - i;
      lamc_real *here = lamc_of_stage(r, r->fine, k), *there = here + r->n, moved = 0;
      const lamc_real h = at[k + 1] - at[k];
      const stretch part = {s->t_old + at[k], k + 1 == FINE_PARTS ? s->t : s->t_old + at[k + 1], h, here,
                            there};
      if (way == 1 && k + 1 < FINE_PARTS) lamc_pull_settle(a, r, part.t, there, end);
      lamc_stages(a, r, &b, &part, 0, b.last);
      if (way == 0) {
        memcpy(there, here, (size_t)r->n * sizeof *here);
        for (int j = 0; j < b.last; j++)
          lamc_add_to(r->n, h * lamc_stage_weight(&b, b.last, j), lamc_of_stage(r, r->slopes, j), there);
        (void)lamc_motion_settle(&a->motion, part.t, there, &moved);
        continue;
      }
      memset(r->pulls, 0, STAGES * (size_t)r->n * sizeof *end);
      memset(r->begin, 0, (size_t)r->n * sizeof *end);
      lamc_weights_back(a, r, &b, &part, end, r->begin);
      memcpy(end, r->begin, (size_t)r->n * sizeof *end);
    }
  }
  a->refined++;
}

/* `a->state`, derivatives by the state at the end of a step of an explicit method, replaced by those where it began */
static inline void lamc_replay_back(lamc_adjoint *a, const room *r, int which, const stretch *s, int check) {
  const tableau b = lamc_tableau(which);
  const size_t bytes = (size_t)r->n * sizeof *a->state;
  lamc_real x = 0;
  int has_rows = 0;
  memset(r->pulls, 0, STAGES * bytes);
  memset(r->begin, 0, bytes);
  lamc_stages(a, r, &b, s, 0, b.last);
  for (; lamc_next_row(a, r, s, &x, r->seed); has_rows = 1)
    lamc_row_back(r, &b, s, x, r->seed, r->begin, a->state);
  if (has_rows) {
    lamc_stages(a, r, &b, s, b.last, b.count);
    for (int stage = b.count - 1; stage > b.last; stage--)
      lamc_stage_back(a, r, &b, s, stage, r->begin, a->sources);
    lamc_stage_back(a, r, &b, s, b.last, a->state, a->sources);
  }
  lamc_pull_settle(a, r, s->t, s->after, a->state);
  int is_fine = 0;
  if (check) {
    memcpy(r->kept, r->pulls, STAGES * bytes);
    is_fine = lamc_is_too_long(a, r, &b, s, a->state);
    memcpy(r->pulls, r->kept, STAGES * bytes);
  }
  lamc_weights_back(a, r, &b, s, is_fine ? NULL : a->state, r->begin);
  if (!is_fine) {
    memcpy(a->state, r->begin, bytes);
    return;
  }
  memcpy(r->kept, r->begin, bytes);
  lamc_finely_back(a, r, s, a->state);
  lamc_add_to(r->n, 1, r->kept, a->state);
}

#endif /* LAMC_BACK_STEPS_H */
