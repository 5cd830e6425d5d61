/* collocation.h, of lamc: derivatives over a step of an implicit method, by Radau IIA of order 5 on the linear equation
 * dS/dt = f_y S + f_p along the continuous extension of y.
 *
 * On steps of RADAU5 its nodes are the stages: S is the derivative of what the step computed. The nine blocks are solved as
 * one matrix, which a linear equation needs once a step (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd
 * ed. (1996), section IV.8). */
#ifndef LAMC_COLLOCATION_H
#define LAMC_COLLOCATION_H

#include "replay.h"

/* Columns of [f_p, f_y], f_p for all columns of S, and numbers of scratch: those at a node, S for them, and the matrix with its right-hand sides */
static inline int lamc_collocation_width(int n, int k) {
  return lamc_columns_width(n + k);
}

static inline long long lamc_collocation_size(int n, int k, int width) {
  const long long all = 3LL * n;
  return 2LL * n * lamc_collocation_width(n, k) + all * padded(3 * n) + all * width + n;
}

/* f_y and f_p at a node, (n, of column_count + n columns), f_p first */
static inline void lamc_collocation_node(lamc_sensitivity *s, lamc_real t, const lamc_real *y,
                                         lamc_real *unit, lamc_real *found) {
  const int n = s->run.ode.n, columns = s->column_count, width = s->width;
  s->column_count = n + columns;
  s->width = lamc_collocation_width(n, columns);
  memset(unit, 0, (size_t)n * (size_t)s->width * sizeof *unit);
  for (int i = 0; i < n; i++) unit[(ptrdiff_t)i * s->width + columns + i] = 1;
  const lamc_place place = lamc_place_beside(s, t, y, NULL);
  lamc_vary(s, &place, unit, found);
  s->column_count = columns;
  s->width = width;
}

/* x (n, width) of a x = x, by elimination with pivots; a (n, across) is used up. 0 where it is singular */
static inline int lamc_solve_dense(int n, int across, lamc_real *a, int width, lamc_real *x) {
  for (int j = 0; j < n; j++) {
    int best = j;
    for (int i = j + 1; i < n; i++)
      if (fabs(a[(ptrdiff_t)i * across + j]) > fabs(a[(ptrdiff_t)best * across + j])) best = i;
    lamc_real *row = a + (ptrdiff_t)j * across, *right = x + (ptrdiff_t)j * width;
    if (best != j) {
      lamc_real *other = a + (ptrdiff_t)best * across, *beside = x + (ptrdiff_t)best * width;
      for (int c = 0; c < n; c++) {
        const lamc_real kept = row[c];
        row[c] = other[c];
        other[c] = kept;
      }
      for (int c = 0; c < width; c++) {
        const lamc_real kept = right[c];
        right[c] = beside[c];
        beside[c] = kept;
      }
    }
    if (!(fabs(row[j]) > 0)) return 0;
    const int begin = j / PACK * PACK; /* what stands before j is not read again */
    for (int i = j + 1; i < n; i++) {
      lamc_real *below = a + (ptrdiff_t)i * across;
      const lamc_real factor = below[j] / row[j];
      if (factor == 0) continue;
      lamc_row_less(across - begin, factor, row + begin, below + begin);
      lamc_row_less(width, factor, right, x + (ptrdiff_t)i * width);
    }
  }
  for (int j = n - 1; j >= 0; j--) {
    lamc_real *right = x + (ptrdiff_t)j * width;
    for (int i = j + 1; i < n; i++)
      lamc_row_less(width, a[(ptrdiff_t)j * across + i], x + (ptrdiff_t)i * width, right);
    lamc_row_scale(width, 1 / a[(ptrdiff_t)j * across + j], right);
  }
  return 1;
}

/* S over the last step, from `start` to `end`. 0: the step is too long for its equation, and S is not known.
 * room: lamc_collocation_size; rows: (n, width) of scratch */
static inline int lamc_collocate(lamc_sensitivity *s, lamc_real *room, lamc_real *rows) {
  lamc_run *run = &s->run;
  const int n = run->ode.n, k = s->column_count, width = s->width, all = RADAU_NODES * n;
  const int across = padded(all), broad = lamc_collocation_width(n, k), dense = run->dense;
  const lamc_real h = run->h_last;
  lamc_real *unit = room, *found = unit + (ptrdiff_t)n * broad, *matrix = found + (ptrdiff_t)n * broad;
  lamc_real *right = matrix + (ptrdiff_t)all * across, *y = right + (ptrdiff_t)all * width;
  memset(matrix, 0, (size_t)all * (size_t)across * sizeof *matrix);
  memset(right, 0, (size_t)all * (size_t)width * sizeof *right);
  for (int node = 0; node < RADAU_NODES; node++) {
    const lamc_real t = node == 2 ? run->t : smaller(run->t_old + RADAU_NODE[node] * h, run->t);
    (void)lamc_run_interpolate(run, t, y);
    lamc_collocation_node(s, t, y, unit, found);
    for (int i = 0; i < n; i++) {
      const lamc_real *row = found + (ptrdiff_t)i * broad;
      lamc_real *out = right + (ptrdiff_t)(node * n + i) * width;
      for (int c = 0; c < k; c++) out[c] = row[c];
      for (int j = 0; j < n; j++) {
        lamc_row_less(width, -row[k + j], s->start + (ptrdiff_t)j * width, out);
        for (int m = 0; m < RADAU_NODES; m++)
          matrix[(ptrdiff_t)(node * n + i) * across + m * n + j] = -h * RADAU_WEIGHT[node][m] * row[k + j];
      }
      matrix[(ptrdiff_t)(node * n + i) * across + node * n + i] += 1;
    }
  }
  if (run->ode.doubts != NULL) run->dense = dense; /* rows ask whether making it met doubts */
  if (!lamc_solve_dense(all, across, matrix, width, right)) return 0;
  memcpy(s->slopes, right, (size_t)all * (size_t)width * sizeof *right);
  memcpy(s->end, s->start, (size_t)n * (size_t)width * sizeof *right);
  for (int m = 0; m < RADAU_NODES; m++)
    lamc_add_weighted((ptrdiff_t)n * width, h * RADAU_WEIGHT[2][m], lamc_slope_of(s, m), s->end);
  lamc_vary_settle(s, run->t, y_here(run), s->end, rows);
  s->slope_count = RADAU_NODES;
  s->has_slope = 0;
  return 1;
}

/* S (n, width) at t_old + x h of such a step: the collocation polynomial */
static inline void lamc_collocated_at(const lamc_sensitivity *s, lamc_real x, lamc_real *out) {
  const ptrdiff_t size = (ptrdiff_t)s->run.ode.n * s->width;
  memcpy(out, s->start, (size_t)size * sizeof *out);
  for (int j = 0; j < RADAU_NODES; j++) {
    const lamc_real c = RADAU_NODE[j], a = RADAU_NODE[(j + 1) % 3], b = RADAU_NODE[(j + 2) % 3];
    /* the integral from 0 to x of (z - a) (z - b) / ((c - a) (c - b)) */
    const lamc_real integral = x * (a * b + x * (-LAMC_R(0.5) * (a + b) + x / 3)) / ((c - a) * (c - b));
    lamc_add_weighted(size, s->h * integral, lamc_slope_of(s, j), out);
  }
}

#endif /* LAMC_COLLOCATION_H */
