/* cholesky.h, of lamc: M = L L^T for small dense M. L (n, n) row-major, lower; its diagonal holds 1 / L_ii, since solving
 * with it then takes no division, which would be a fifth of the time of a small loop. */
#ifndef LAMC_CHOLESKY_H
#define LAMC_CHOLESKY_H

#include <math.h>
#include <stddef.h>

static inline double lamc_dot(int n, const double *a, const double *b) {
  double sum = 0.0;
  for (int i = 0; i < n; i++) sum += a[i] * b[i];
  return sum;
}

/* L from the lower triangle of M by rows. NaN where M is not positive, which every later result inherits. */
static inline void lamc_cholesky(int n, const double *lower_triangle, double *l) {
  const double *row = lower_triangle;
  for (int i = 0; i < n; i++) {
    double *li = l + (ptrdiff_t)i * n;
    for (int k = 0; k <= i; k++) {
      const double *lk = l + (ptrdiff_t)k * n;
      const double rest = row[k] - lamc_dot(k, li, lk);
      li[k] = k == i ? 1.0 / sqrt(rest) : rest * lk[k];
    }
    row += i + 1;
  }
}

/* x = L^-1 x */
static inline void lamc_solve_lower(int n, const double *l, double *x) {
  for (int i = 0; i < n; i++) {
    const double *li = l + (ptrdiff_t)i * n;
    x[i] = (x[i] - lamc_dot(i, li, x)) * li[i];
  }
}

/* x = L^-T x */
static inline void lamc_solve_upper(int n, const double *l, double *x) {
  for (int i = n - 1; i >= 0; i--) {
    double sum = x[i];
    for (int k = i + 1; k < n; k++) sum -= l[(ptrdiff_t)k * n + i] * x[k];
    x[i] = sum * l[(ptrdiff_t)i * n + i];
  }
}

#endif /* LAMC_CHOLESKY_H */
