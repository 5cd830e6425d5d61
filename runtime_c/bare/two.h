/* two.h, of lamc: numbers that are the sum of two, with twice the digits of one.
 *
 * In: any numbers. Out: sums and products as pairs, high and low.
 *
 * T. J. Dekker, Numerische Mathematik 18 (1971) 224-242. */
#ifndef LAMC_TWO_H
#define LAMC_TWO_H

#include "bits.h"
#include "lamc_real.h"

typedef struct lamc_two {
  lamc_real high, low;
} lamc_two;

/* a + b, exactly */
static inline lamc_two lamc_two_sum(lamc_real a, lamc_real b) {
  const lamc_real sum = a + b, part = sum - a;
  const lamc_two s = {sum, (a - (sum - part)) + (b - part)};
  return s;
}

/* a b, exactly, for sizes of 1e-140 to 1e140, and in single precision of 1e-14 to 1e14 */
static inline lamc_two lamc_two_product(lamc_real a, lamc_real b) {
  const lamc_real pa = LAMC_SPLITTER * a, pb = LAMC_SPLITTER * b;
  const lamc_real a1 = pa - (pa - a), b1 = pb - (pb - b), a2 = a - a1, b2 = b - b1, product = a * b;
  const lamc_two p = {product, ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2};
  return p;
}

static inline lamc_two lamc_two_add(lamc_two a, lamc_two b) {
  const lamc_two s = lamc_two_sum(a.high, b.high);
  return lamc_two_sum(s.high, s.low + (a.low + b.low));
}

static inline lamc_two lamc_two_times(lamc_two a, lamc_two b) {
  const lamc_two p = lamc_two_product(a.high, b.high);
  return lamc_two_sum(p.high, p.low + (a.high * b.low + a.low * b.high));
}

static inline lamc_two lamc_two_over(lamc_two a, lamc_two b) {
  const lamc_real first = a.high / b.high;
  const lamc_two p = lamc_two_product(first, b.high);
  return lamc_two_sum(first, ((a.high - p.high) - p.low + a.low - first * b.low) / b.high);
}

#endif /* LAMC_TWO_H */
