/* loop_sparse.h, of lamc: J of large loops eliminated row by row, each row with the few rates that it knows.
 *
 * In:    the rows of J, a plan. Out: which equations hold, what solves them, which directions they leave free.
 * Never: forms a matrix of all equations times all rates; calls a model; allocates.
 *
 * The plan has the order that fills up few rows, as the compiler found it at one position. Where a pivot of the plan is
 * too small an order is looked for (loop_search.h). */
#ifndef LAMC_LOOP_SPARSE_H
#define LAMC_LOOP_SPARSE_H

#include "cholesky.h"
#include "loop_search.h"

static const lamc_real PLANNED =
    LAMC_R(0.02); /* what a row has left of its largest and of one, where the plan is kept to */

/* By the plan; how many equations were taken, or -1 where it does not hold */
static inline int lamc_sparse_follow(const lamc_loop_parts *p) {
  const lamc_pattern *plan = p->pattern;
  const lamc_steps *s = &p->steps;
  for (int k = 0; k < plan->step_count; k++) {
    const int first = plan->left_start[k];
    lamc_sparse_scatter(p, plan->step_row[k]);
    s->noise[k] = 1;
    for (int i = plan->update_start[k]; i < plan->update_start[k + 1]; i++) {
      s->factor[i] = lamc_sparse_update(p, plan->update[i]);
      s->noise[k] += fabs(s->factor[i]) * s->noise[plan->update[i]];
    }
    s->peak[k] = lamc_sparse_collect(p, first, plan->left_start[k + 1]);
    const lamc_real pivot = fabs(s->value[first]);
    if (!(pivot > PLANNED && pivot > PLANNED * s->peak[k])) return -1;
    if (lamc_sparse_is_noise(s->peak[k], s->noise[k])) return -1;
    s->inverse[k] = 1 / s->value[first];
  }
  return plan->step_count;
}

/* The steps of the plan; its numbers lie where those of other steps do */
static inline lamc_steps lamc_sparse_planned(const lamc_loop_parts *p) {
  lamc_steps s = p->found;
  s.row.given = p->pattern->step_row;
  s.update_start.given = p->pattern->update_start;
  s.update.given = p->pattern->update;
  s.left_start.given = p->pattern->left_start;
  s.left.given = p->pattern->left;
  return s;
}

/* How many equations hold here, at most `rank` */
static inline int lamc_sparse_order(lamc_loop_parts *p, int rank) {
  int count = -1;
  memset(p->row, 0, (size_t)p->n * sizeof *p->row);
  if (p->pattern->step_count == rank) {
    p->steps = lamc_sparse_planned(p);
    count = lamc_sparse_follow(p);
  }
  p->state[5] = count >= 0;
  if (count < 0) {
    p->steps = p->found;
    count = lamc_sparse_find(p, rank);
  }
  for (int i = 0; i < p->n; i++) p->step_of[i] = -1;
  for (int k = 0; k < count; k++) {
    p->step_of[lamc_at(p->steps.left, lamc_at(p->steps.left_start, k))] = (lamc_real)k;
  }
  return count;
}

/* The least that any step had left: how near the equations are to be dependent */
static inline lamc_real lamc_sparse_least(const lamc_loop_parts *p, int count) {
  lamc_real least = 1;
  for (int k = 0; k < count; k++) least = p->steps.peak[k] < least ? p->steps.peak[k] : least;
  return least;
}

/* x, whose free rates are given, such that the taken equations have the values y (count,), by step */
static inline void lamc_sparse_back(const lamc_loop_parts *p, int count, const lamc_real *y, lamc_real *x) {
  const lamc_steps *s = &p->steps;
  for (int k = count - 1; k >= 0; k--) {
    const int first = lamc_at(s->left_start, k), beyond = lamc_at(s->left_start, k + 1);
    lamc_real rest = y[k];
    for (int e = first + 1; e < beyond; e++) rest -= s->value[e] * x[lamc_at(s->left, e)];
    x[lamc_at(s->left, first)] = rest * s->inverse[k];
  }
}

/* x (n,) such that the taken equations have the values -goal (m,), with nothing along the free rates */
static inline void lamc_sparse_impose(const lamc_loop_parts *p, int count, const lamc_real *goal,
                                      lamc_real *x) {
  const lamc_steps *s = &p->steps;
  lamc_real *y = p->z;
  memset(x, 0, (size_t)p->n * sizeof *x);
  for (int k = 0; k < count; k++) {
    y[k] = -goal[lamc_at(s->row, k)];
    for (int i = lamc_at(s->update_start, k); i < lamc_at(s->update_start, k + 1); i++) {
      y[k] -= s->factor[i] * y[lamc_at(s->update, i)];
    }
  }
  lamc_sparse_back(p, count, y, x);
}

/* N, of all directions at once: the rows of `free`; by rates first, where L will lie */
static inline void lamc_sparse_find_free(const lamc_loop_parts *p, int count) {
  const lamc_steps *s = &p->steps;
  const int free = p->n - count;
  lamc_real *by_rate = p->l;
  memset(by_rate, 0, (size_t)p->n * (size_t)free * sizeof *by_rate);
  for (int rate = 0, a = 0; rate < p->n; rate++) {
    if (p->step_of[rate] < 0) by_rate[(ptrdiff_t)rate * free + a++] = 1;
  }
  for (int k = count - 1; k >= 0; k--) {
    const int first = lamc_at(s->left_start, k), beyond = lamc_at(s->left_start, k + 1);
    lamc_real *rest = by_rate + (ptrdiff_t)lamc_at(s->left, first) * free;
    for (int e = first + 1; e < beyond; e++) {
      lamc_less(free, s->value[e], by_rate + (ptrdiff_t)lamc_at(s->left, e) * free, rest);
    }
    for (int a = 0; a < free; a++) rest[a] *= s->inverse[k];
  }
  for (int a = 0; a < free; a++) {
    for (int i = 0; i < p->n; i++) p->free[(ptrdiff_t)a * p->n + i] = by_rate[(ptrdiff_t)i * free + a];
  }
}

/* lambda (m,) from z = M udot - f (n,), which is used up: of the taken equations, zero for the others */
static inline void lamc_sparse_lambda(const lamc_loop_parts *p, int count, lamc_real *z, lamc_real *lambda) {
  const lamc_steps *s = &p->steps;
  lamc_real *x = p->x;
  for (int k = 0; k < count; k++) {
    const int first = lamc_at(s->left_start, k), beyond = lamc_at(s->left_start, k + 1);
    x[k] = z[lamc_at(s->left, first)] * s->inverse[k];
    for (int e = first + 1; e < beyond; e++) z[lamc_at(s->left, e)] -= s->value[e] * x[k];
  }
  for (int k = count - 1; k >= 0; k--) {
    for (int i = lamc_at(s->update_start, k); i < lamc_at(s->update_start, k + 1); i++) {
      x[lamc_at(s->update, i)] -= s->factor[i] * x[k];
    }
    lambda[lamc_at(s->row, k)] = x[k];
  }
}

#endif /* LAMC_LOOP_SPARSE_H */
