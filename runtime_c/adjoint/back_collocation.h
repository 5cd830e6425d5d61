/* back_collocation.h, of lamc: one step of an implicit method, backwards: collocation.h, transposed.
 *
 * In: derivatives by the state at the end of a step, and by rows within. Out: by the state where it began, and by the sources.
 * f_y at a node is written down row by row, each a weighted slope; its columns are few. */
#ifndef LAMC_BACK_COLLOCATION_H
#define LAMC_BACK_COLLOCATION_H

#include "back_steps.h"

/* x (n,) of a x = x, by elimination with pivots; a (n, n) is used up. 0 where it is singular */
static inline int lamc_solve_square(int n, lamc_real *a, lamc_real *x) {
  for (int j = 0; j < n; j++) {
    int best = j;
    for (int i = j + 1; i < n; i++)
      if (fabs(a[(ptrdiff_t)i * n + j]) > fabs(a[(ptrdiff_t)best * n + j])) best = i;
    lamc_real *row = a + (ptrdiff_t)j * n;
    if (best != j) {
      lamc_real *other = a + (ptrdiff_t)best * n;
      for (int c = j; c < n; c++) {
        const lamc_real kept = row[c];
        row[c] = other[c];
        other[c] = kept;
      }
      const lamc_real kept = x[j];
      x[j] = x[best];
      x[best] = kept;
    }
    if (!(fabs(row[j]) > 0)) return 0;
    for (int i = j + 1; i < n; i++) {
      lamc_real *below = a + (ptrdiff_t)i * n;
      const lamc_real factor = below[j] / row[j];
      if (factor == 0) continue;
      lamc_add_to(n - j, -factor, row + j, below + j);
      x[i] -= factor * x[j];
    }
  }
  for (int j = n - 1; j >= 0; j--) {
    for (int i = j + 1; i < n; i++) x[j] -= a[(ptrdiff_t)j * n + i] * x[i];
    x[j] /= a[(ptrdiff_t)j * n + j];
  }
  return 1;
}

static inline const lamc_real *lamc_node_state(const room *r, const stretch *s, const lamc_real *nodes,
                                               int node) {
  return node + 1 == RADAU_NODES ? s->after : nodes + (ptrdiff_t)node * r->n;
}

static inline lamc_real lamc_node_time(const stretch *s, int node) {
  return node + 1 == RADAU_NODES ? s->t : smaller(s->t_old + RADAU_NODE[node] * s->h, s->t);
}

/* f_y (n, n) at each node */
static inline void lamc_node_jacobians(lamc_adjoint *a, const room *r, const stretch *s,
                                       const lamc_real *nodes) {
  lamc_real *unit = r->first;
  memset(r->jacobian, 0, RADAU_NODES * (size_t)r->n * (size_t)r->n * sizeof *unit);
  memset(unit, 0, (size_t)r->n * sizeof *unit);
  for (int node = 0; node < RADAU_NODES; node++) {
    const lamc_real *y = lamc_node_state(r, s, nodes, node), t = lamc_node_time(s, node);
    lamc_real *rows = r->jacobian + (ptrdiff_t)node * r->n * r->n;
    const int count = lamc_prepare(a, r, t, y), is_plain = a->motion.model->rates == NULL;
    for (int i = 0; i < r->n; i++) {
      if (is_plain && i < r->nq) {
        rows[(ptrdiff_t)i * r->n + r->nq + i] = 1;
        continue;
      }
      unit[i] = 1;
      lamc_pull(a, r, t, y, count, unit, rows + (ptrdiff_t)i * r->n, NULL);
      unit[i] = 0;
    }
  }
}

/* What a row at t_old + x h weighs the state where the step began with, and slopes at the nodes: see lamc_collocated_at */
static inline void lamc_collocated_back(const room *r, const stretch *s, lamc_real x, const lamc_real *seed,
                                        lamc_real *begin) {
  lamc_add_to(r->n, 1, seed, begin);
  for (int j = 0; j < RADAU_NODES; j++) {
    const lamc_real c = RADAU_NODE[j], p = RADAU_NODE[(j + 1) % 3], q = RADAU_NODE[(j + 2) % 3];
    /* the integral from 0 to x of (z - p) (z - q) / ((c - p) (c - q)) */
    const lamc_real integral = x * (p * q + x * (-LAMC_R(0.5) * (p + q) + x / 3)) / ((c - p) * (c - q));
    lamc_add_to(r->n, s->h * integral, seed, r->right + (ptrdiff_t)j * r->n);
  }
}

/* `a->state`, derivatives by the state at the end of a step of an implicit method, replaced by those where it began. 0: the step
 * is too long for its equation */
static inline int lamc_collocate_back(lamc_adjoint *a, const room *r, const stretch *s,
                                      const lamc_real *nodes) {
  const int n = r->n, all = RADAU_NODES * n;
  lamc_real x = 0;
  memset(r->right, 0, (size_t)all * sizeof *r->right);
  memset(r->begin, 0, (size_t)n * sizeof *r->begin);
  while (lamc_next_row(a, r, s, &x, r->seed)) lamc_collocated_back(r, s, x, r->seed, r->begin);
  lamc_pull_settle(a, r, s->t, s->after, a->state);
  lamc_add_to(n, 1, a->state, r->begin);
  lamc_node_jacobians(a, r, s, nodes);
  for (int node = 0; node < RADAU_NODES; node++) {
    lamc_add_to(n, s->h * RADAU_WEIGHT[2][node], a->state, r->right + (ptrdiff_t)node * n);
    const lamc_real *rows = r->jacobian + (ptrdiff_t)node * n * n;
    for (int m = 0; m < RADAU_NODES; m++) {
      for (int j = 0; j < n; j++) {
        lamc_real *row = r->matrix + ((ptrdiff_t)m * n + j) * all + (ptrdiff_t)node * n;
        for (int i = 0; i < n; i++)
          row[i] = (m == node && i == j ? 1 : 0) - s->h * RADAU_WEIGHT[node][m] * rows[(ptrdiff_t)i * n + j];
      }
    }
  }
  if (!lamc_solve_square(all, r->matrix, r->right)) return 0;
  for (int node = 0; node < RADAU_NODES; node++) {
    const lamc_real *y = lamc_node_state(r, s, nodes, node), t = lamc_node_time(s, node);
    const int count = lamc_prepare(a, r, t, y);
    lamc_pull(a, r, t, y, count, r->right + (ptrdiff_t)node * n, r->begin, a->sources);
  }
  memcpy(a->state, r->begin, (size_t)n * sizeof *r->begin);
  return 1;
}

#endif /* LAMC_BACK_COLLOCATION_H */
