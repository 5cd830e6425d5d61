/* The sign of two determinants, exactly.
 *
 * Floating-point first; where its error bound does not tell the sign, again in expansions: sums of doubles that do not
 * overlap, smallest first, which hold the exact value. Needs IEEE doubles, rounding to nearest, and no contraction of
 * products and sums. Source: J. R. Shewchuk, Adaptive precision floating-point arithmetic and fast robust geometric
 * predicates, Discrete & Computational Geometry 18 (1997) 305-363. */
#include "predicates.h"

#include <math.h>

#define HALF_ULP 1.1102230246251565e-16 /* 2^-53 */
#define SPLITTER 134217729.0            /* 2^27 + 1 */

static const double orientation_bound = (3.0 + 16.0 * HALF_ULP) * HALF_ULP;
static const double circle_bound = (10.0 + 96.0 * HALF_ULP) * HALF_ULP;

static void two_sum(double a, double b, double *high, double *low) {
  const double sum = a + b, virtual_b = sum - a;
  *low = (a - (sum - virtual_b)) + (b - virtual_b);
  *high = sum;
}

static void split(double a, double *high, double *low) {
  const double c = SPLITTER * a;
  *high = c - (c - a);
  *low = a - *high;
}

static void two_product(double a, double b, double *high, double *low) {
  double a_high, a_low, b_high, b_low;
  const double product = a * b;
  split(a, &a_high, &a_low);
  split(b, &b_high, &b_low);
  *low = a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low);
  *high = product;
}

/* h = e + f, without zeros; returns its length. h must hold n + m and differ from e and f. */
static int sum(int n, const double *e, int m, const double *f, double *h) {
  int i = 0, j = 0, count = 0;
  double carried = 0.0, low;
  while (i < n || j < m) {
    const int from_e = j >= m || (i < n && fabs(e[i]) < fabs(f[j]));
    two_sum(carried, from_e ? e[i] : f[j], &carried, &low);
    i += from_e;
    j += !from_e;
    if (low != 0.0) h[count++] = low;
  }
  if (carried != 0.0 || count == 0) h[count++] = carried;
  return count;
}

/* h = b e, without zeros; returns its length. h must hold 2 n. */
static int scale(int n, const double *e, double b, double *h) {
  int count = 0;
  double carried, low, high, product;
  two_product(e[0], b, &carried, &low);
  if (low != 0.0) h[count++] = low;
  for (int i = 1; i < n; i++) {
    two_product(e[i], b, &high, &product);
    two_sum(carried, product, &carried, &low);
    if (low != 0.0) h[count++] = low;
    two_sum(high, carried, &carried, &low);
    if (low != 0.0) h[count++] = low;
  }
  if (carried != 0.0 || count == 0) h[count++] = carried;
  return count;
}

/* h = a_x b_y - b_x a_y; returns its length, at most 4. */
static int minor(const double a[2], const double b[2], double *h) {
  double left[2], right[2];
  two_product(a[0], b[1], &left[1], &left[0]);
  two_product(-b[0], a[1], &right[1], &right[0]);
  return sum(2, left, 2, right, h);
}

/* h = (a × b) + (b × c) + (c × a), twice the area; returns its length, at most 12. */
static int area(const double a[2], const double b[2], const double c[2], double *h) {
  double ab[4], bc[4], ca[4], part[8];
  const int n = minor(a, b, ab), m = minor(b, c, bc), k = minor(c, a, ca);
  const int both = sum(n, ab, m, bc, part);
  return sum(both, part, k, ca, h);
}

double lamc_orientation(const double a[2], const double b[2], const double c[2]) {
  const double left = (a[0] - c[0]) * (b[1] - c[1]), right = (a[1] - c[1]) * (b[0] - c[0]);
  const double value = left - right;
  if (fabs(value) > orientation_bound * (fabs(left) + fabs(right))) return value;
  double exact[12];
  return exact[area(a, b, c, exact) - 1];
}

/* h = factor |a|² e, for e of at most 12; returns its length, at most 96. */
static int lifted(int n, const double *e, const double a[2], double factor, double *h) {
  double once[24], x[48], y[48];
  int count = scale(n, e, factor * a[0], once);
  const int nx = scale(count, once, a[0], x);
  count = scale(n, e, factor * a[1], once);
  const int ny = scale(count, once, a[1], y);
  return sum(nx, x, ny, y, h);
}

double lamc_in_circle(const double a[2], const double b[2], const double c[2], const double d[2]) {
  const double ax = a[0] - d[0], ay = a[1] - d[1], bx = b[0] - d[0], by = b[1] - d[1];
  const double cx = c[0] - d[0], cy = c[1] - d[1];
  const double bc = bx * cy - cx * by, ca = cx * ay - ax * cy, ab = ax * by - bx * ay;
  const double al = ax * ax + ay * ay, bl = bx * bx + by * by, cl = cx * cx + cy * cy;
  const double value = al * bc + bl * ca + cl * ab;
  const double size = al * (fabs(bx * cy) + fabs(cx * by)) + bl * (fabs(cx * ay) + fabs(ax * cy)) +
                      cl * (fabs(ax * by) + fabs(bx * ay));
  if (fabs(value) > circle_bound * size) return value;
  double minors[12], first[96], second[96], half[192], other[192], exact[384];
  int n = area(b, c, d, minors);
  int i = lifted(n, minors, a, 1.0, first);
  n = area(a, c, d, minors);
  int j = lifted(n, minors, b, -1.0, second);
  const int left = sum(i, first, j, second, half);
  n = area(a, b, d, minors);
  i = lifted(n, minors, c, 1.0, first);
  n = area(a, b, c, minors);
  j = lifted(n, minors, d, -1.0, second);
  const int right = sum(i, first, j, second, other);
  return exact[sum(left, half, right, other, exact) - 1];
}
