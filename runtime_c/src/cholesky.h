/* cholesky.h, of lamc: M = L L^T for small dense M, and sums over rows.
 *
 * L (n, n) row-major, lower; its diagonal holds 1 / L_ii, since solving with it then takes no division, which would be a
 * fifth of the time of a small loop. */
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

/* Four rows of a (4, n), one below the other, times b: as lamc_dot to the last digit, without waiting for each sum */
static inline void lamc_four_dots(int n, const lamc_real *a, ptrdiff_t stride, const lamc_real *b,
                                  lamc_real *sums) {
  lamc_real s0 = 0, s1 = 0, s2 = 0, s3 = 0;
  const lamc_real *a1 = a + stride, *a2 = a1 + stride, *a3 = a2 + stride;
  for (int i = 0; i < n; i++) {
    s0 += a[i] * b[i];
    s1 += a1[i] * b[i];
    s2 += a2[i] * b[i];
    s3 += a3[i] * b[i];
  }
  sums[0] = s0;
  sums[1] = s1;
  sums[2] = s2;
  sums[3] = s3;
}

/* a (count, n) times b */
static inline void lamc_dots(int count, int n, const lamc_real *a, ptrdiff_t stride, const lamc_real *b,
                             lamc_real *sums) {
  int k = 0;
  for (; k + 4 <= count; k += 4) lamc_four_dots(n, a + k * stride, stride, b, sums + k);
  for (; k < count; k++) sums[k] = lamc_dot(n, a + k * stride, b);
}

/* Columns first <= k < beyond of row i of L, from that of M */
static inline void lamc_cholesky_row(int n, int i, int first, int beyond, const lamc_real *row,
                                     lamc_real *l) {
  lamc_real *li = l + (ptrdiff_t)i * n;
  for (int k = first; k < beyond; k++) {
    const lamc_real *lk = l + (ptrdiff_t)k * n;
    const lamc_real rest = row[k] - lamc_dot(k, li, lk);
    li[k] = k == i ? 1 / sqrt(rest) : rest * lk[k];
  }
}

/* L from the lower triangle of M by rows, of which four are taken side by side, as lamc_dot to the last digit. NaN where M
 * is not positive, which every later result inherits. */
static inline void lamc_cholesky(int n, const lamc_real *lower_triangle, lamc_real *l) {
  const lamc_real *row = lower_triangle;
  int i = 0;
  for (; i + 4 <= n; row += 4 * i + 10, i += 4) {
    const lamc_real *rows[4] = {row, row + i + 1, row + 2 * i + 3, row + 3 * i + 6};
    lamc_real *li = l + (ptrdiff_t)i * n;
    for (int k = 0; k < i; k++) {
      const lamc_real *lk = l + (ptrdiff_t)k * n;
      lamc_real sums[4];
      lamc_four_dots(k, li, n, lk, sums);
      for (int j = 0; j < 4; j++) li[(ptrdiff_t)j * n + k] = (rows[j][k] - sums[j]) * lk[k];
    }
    for (int j = 0; j < 4; j++) lamc_cholesky_row(n, i + j, i, i + j + 1, rows[j], l);
  }
  for (; i < n; row += ++i) lamc_cholesky_row(n, i, 0, i + 1, row, l);
}

/* rest (n,) less `value` times known: four at once, read before they are written */
static inline void lamc_less(int n, lamc_real value, const lamc_real *known, lamc_real *rest) {
  int i = 0;
  for (; i + 4 <= n; i += 4) {
    const lamc_real r0 = rest[i] - value * known[i], r1 = rest[i + 1] - value * known[i + 1];
    const lamc_real r2 = rest[i + 2] - value * known[i + 2], r3 = rest[i + 3] - value * known[i + 3];
    rest[i] = r0;
    rest[i + 1] = r1;
    rest[i + 2] = r2;
    rest[i + 3] = r3;
  }
  for (; i < n; i++) rest[i] -= value * known[i];
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
