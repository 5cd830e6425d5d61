/* loop_dense.h, of lamc: J of small loops eliminated as one array, with complete pivoting.
 *
 * In:    the rows of J. Out: which equations hold, what solves them, which directions they leave free.
 * Never: calls a model; assumes that the equations are independent; allocates.
 *
 * Gauss's elimination orders the equations by what each adds, and stops at the rank of a generic position or where the
 * rest is below 3e-5 of the first. Redundant equations differ from their partners at the level of drift only, so a test
 * at machine precision would take them in and lock the mechanism. */
#ifndef LAMC_LOOP_DENSE_H
#define LAMC_LOOP_DENSE_H

#include "cholesky.h"
#include "loop_parts.h"

static inline void lamc_dense_swap(lamc_real *a, lamc_real *b, int count, int stride) {
  for (int i = 0; i < count; i++) {
    const lamc_real keep = a[(ptrdiff_t)i * stride];
    a[(ptrdiff_t)i * stride] = b[(ptrdiff_t)i * stride];
    b[(ptrdiff_t)i * stride] = keep;
  }
}

enum {
  LARGE = 10
}; /* rates: from here on most entries of J are zero (measured: a folding box of 16 takes 2/3 of it) */

/* Takes what pivot k has from the rows below; where the largest that is left is, as a place in `a` */
static inline int lamc_dense_eliminate(const lamc_loop_parts *p, int k) {
  const int n = p->n;
  const lamc_real *pivot = p->a + (ptrdiff_t)k * n;
  const lamc_real inverse = p->inverse[k];
  lamc_real most = -1;
  int best = 0;
  for (int i = k + 1; i < p->m; i++) {
    lamc_real *ai = p->a + (ptrdiff_t)i * n;
    const lamc_real part = ai[k] *= inverse;
    for (int c = k + 1; c < n; c++) {
      const lamc_real left = ai[c] -= part * pivot[c];
      const int larger = fabs(left) > most;
      most = larger ? fabs(left) : most;
      best = larger ? i * n + c : best;
    }
  }
  return best;
}

/* In loops that are not tiny: among the rows whose largest is at least a tenth of the largest of all, the one with the fewest entries
 * comes next, so that few rows fill up; where its largest is */
static inline int lamc_dense_sparsest(const lamc_loop_parts *p, int k) {
  lamc_real most = 0;
  int row = k;
  for (int i = k; i < p->m; i++) most = p->peak[i] > most ? p->peak[i] : most;
  for (int i = k; i < p->m; i++) {
    const int is_better = p->peak[row] < LAMC_R(0.1) * most || p->filled[i] < p->filled[row];
    if (p->peak[i] >= LAMC_R(0.1) * most && is_better) row = i;
  }
  const lamc_real *next = p->a + (ptrdiff_t)row * p->n;
  int column = k;
  for (int c = k + 1; c < p->n; c++) column = fabs(next[c]) > fabs(next[column]) ? c : column;
  return row * p->n + column;
}

/* Of row i from column k on: its largest, and how many entries are not zero */
static inline void lamc_dense_look(const lamc_loop_parts *p, int i, int k) {
  const lamc_real *ai = p->a + (ptrdiff_t)i * p->n;
  lamc_real most = 0;
  int filled = 0;
  for (int c = k; c < p->n; c++) {
    most = fabs(ai[c]) > most ? fabs(ai[c]) : most;
    filled += ai[c] != 0;
  }
  p->peak[i] = most;
  p->filled[i] = (lamc_real)filled;
}

/* The same there: rows that do not know the pivot stay as they are */
static inline int lamc_dense_eliminate_sparse(const lamc_loop_parts *p, int k) {
  const int n = p->n;
  const lamc_real *pivot = p->a + (ptrdiff_t)k * n;
  const lamc_real inverse = p->inverse[k];
  for (int i = k + 1; i < p->m; i++) {
    lamc_real *ai = p->a + (ptrdiff_t)i * n;
    if (ai[k] == 0) continue;
    const lamc_real part = ai[k] *= inverse;
    for (int c = k + 1; c < n; c++) ai[c] -= part * pivot[c];
    lamc_dense_look(p, i, k + 1);
  }
  return lamc_dense_sparsest(p, k + 1);
}

/* J as it is into `a`; where its largest is */
static inline int lamc_dense_copy(const lamc_loop_parts *p) {
  lamc_real most = -1;
  int best = 0;
  const int size = p->m * p->n;
  if (p->pattern->row_start[p->m] < size) memset(p->a, 0, (size_t)size * sizeof *p->a);
  for (int i = 0; i < p->m; i++) {
    for (int e = p->pattern->row_start[i]; e < p->pattern->row_start[i + 1]; e++) {
      const int at = i * p->n + p->pattern->column[e];
      p->a[at] = p->j[e];
      const int larger = fabs(p->j[e]) > most;
      most = larger ? fabs(p->j[e]) : most;
      best = larger ? at : best;
    }
    p->rows[i] = (lamc_real)i;
    if (p->n > LARGE) lamc_dense_look(p, i, 0);
  }
  for (int c = 0; c < p->n; c++) p->columns[c] = (lamc_real)c;
  return p->n > LARGE ? lamc_dense_sparsest(p, 0) : best;
}

static inline lamc_real lamc_dense_pivot(const lamc_loop_parts *p, int k) {
  return fabs(p->a[(ptrdiff_t)k * p->n + k]);
}

/* How many equations hold here, at most `rank`. Where one fades at a singular position, with pivot s of the first,
 * round-off turns the tangent of the branch by round-off / s^2, so it cannot be used all the way. Doing without it leaves
 * the branch to the forces, which turns rates by s or so. Both are least at some 1e-5. With one equation go all that fade
 * with it: the order of small pivots changes from stage to stage, and with it which directions are held. */
static inline int lamc_dense_order(const lamc_loop_parts *p, int rank) {
  const int n = p->n;
  int count = 0, best = lamc_dense_copy(p);
  for (; count < rank; count++) {
    const int row = best / n, column = best % n;
    if (row != count) {
      lamc_dense_swap(p->a + (ptrdiff_t)count * n, p->a + (ptrdiff_t)row * n, n, 1);
      lamc_dense_swap(p->rows + count, p->rows + row, 1, 1);
      if (n > LARGE) lamc_dense_swap(p->peak + count, p->peak + row, 1, 1);
      if (n > LARGE) lamc_dense_swap(p->filled + count, p->filled + row, 1, 1);
    }
    if (column != count) {
      lamc_dense_swap(p->a + count, p->a + column, p->m, n);
      lamc_dense_swap(p->columns + count, p->columns + column, 1, 1);
    }
    if (!(lamc_dense_pivot(p, count) > PASSING * lamc_dense_pivot(p, 0))) break;
    p->inverse[count] = 1 / p->a[(ptrdiff_t)count * n + count];
    if (count + 1 < rank) {
      best = n > LARGE ? lamc_dense_eliminate_sparse(p, count) : lamc_dense_eliminate(p, count);
    }
  }
  while (count < rank && count > 0 && lamc_dense_pivot(p, count - 1) < TOGETHER * lamc_dense_pivot(p, 0))
    count--;
  return count;
}

/* x (n,) such that the taken equations have the values -goal (m,), with nothing along the free rates */
static inline void lamc_dense_impose(const lamc_loop_parts *p, int count, const lamc_real *goal,
                                     lamc_real *x) {
  const int n = p->n;
  lamc_real *y = p->z;
  memset(x, 0, (size_t)n * sizeof *x);
  for (int k = 0; k < count; k++) {
    y[k] = -goal[(int)p->rows[k]] - lamc_dot(k, p->a + (ptrdiff_t)k * n, y);
  }
  for (int k = count - 1; k >= 0; k--) {
    const lamc_real *row = p->a + (ptrdiff_t)k * n;
    for (int i = k + 1; i < count; i++) y[k] -= row[i] * y[i];
    y[k] *= p->inverse[k];
    x[(int)p->columns[k]] = y[k];
  }
}

/* N: the rows of `free` */
static inline void lamc_dense_find_free(const lamc_loop_parts *p, int count) {
  const int n = p->n;
  lamc_real *y = p->z;
  memset(p->free, 0, (size_t)(n - count) * (size_t)n * sizeof *p->free);
  for (int c = count; c < n; c++) {
    lamc_real *direction = p->free + (ptrdiff_t)(c - count) * n;
    direction[(int)p->columns[c]] = 1;
    for (int k = count - 1; k >= 0; k--) {
      const lamc_real *row = p->a + (ptrdiff_t)k * n;
      lamc_real rest = -row[c];
      for (int i = k + 1; i < count; i++) rest -= row[i] * y[i];
      y[k] = rest * p->inverse[k];
      direction[(int)p->columns[k]] = y[k];
    }
  }
}

/* lambda (m,) from z = M udot - f: of the taken equations, zero for the others */
static inline void lamc_dense_lambda(const lamc_loop_parts *p, int count, const lamc_real *z,
                                     lamc_real *lambda) {
  const int n = p->n;
  for (int k = 0; k < count; k++) {
    lamc_real rest = z[(int)p->columns[k]];
    for (int i = 0; i < k; i++) rest -= p->a[(ptrdiff_t)i * n + k] * p->x[i];
    p->x[k] = rest * p->inverse[k];
  }
  for (int k = count - 1; k >= 0; k--) {
    for (int i = k + 1; i < count; i++) p->x[k] -= p->a[(ptrdiff_t)i * n + k] * p->x[i];
    lambda[(int)p->rows[k]] = p->x[k];
  }
}

#endif /* LAMC_LOOP_DENSE_H */
