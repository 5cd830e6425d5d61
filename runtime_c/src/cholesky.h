/* cholesky.h, of lamc: M = L L^T for small dense M. L (n, n) row-major, lower; its diagonal holds 1 / L_ii, since solving
 * with it then takes no division, which would be a fifth of the time of a small loop. */
#ifndef LAMC_CHOLESKY_H
#define LAMC_CHOLESKY_H

#include "lamc_real.h"

#include <math.h>
#include <stddef.h>

static inline lamc_real lamc_dot(int n, const lamc_real *a, const lamc_real *b) {
  lamc_real sum = 0;
  for (int i = 0; i < n; i++) sum += a[i] * b[i];
  return sum;
}

/* L from the lower triangle of M by rows. NaN where M is not positive, which every later result inherits. */
static inline void lamc_cholesky(int n, const lamc_real *lower_triangle, lamc_real *l) {
  const lamc_real *row = lower_triangle;
  for (int i = 0; i < n; i++) {
    lamc_real *li = l + (ptrdiff_t)i * n;
    for (int k = 0; k <= i; k++) {
      const lamc_real *lk = l + (ptrdiff_t)k * n;
      const lamc_real rest = row[k] - lamc_dot(k, li, lk);
      li[k] = k == i ? 1 / sqrt(rest) : rest * lk[k];
    }
    row += i + 1;
  }
}

/* x = L^-1 x */
static inline void lamc_solve_lower(int n, const lamc_real *l, lamc_real *x) {
  for (int i = 0; i < n; i++) {
    const lamc_real *li = l + (ptrdiff_t)i * n;
    x[i] = (x[i] - lamc_dot(i, li, x)) * li[i];
  }
}

/* x = L^-T x */
static inline void lamc_solve_upper(int n, const lamc_real *l, lamc_real *x) {
  for (int i = n - 1; i >= 0; i--) {
    lamc_real sum = x[i];
    for (int k = i + 1; k < n; k++) sum -= l[(ptrdiff_t)k * n + i] * x[k];
    x[i] = sum * l[(ptrdiff_t)i * n + i];
  }
}

#endif /* LAMC_CHOLESKY_H */
