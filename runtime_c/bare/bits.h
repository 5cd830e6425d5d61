/* bits.h, of lamc: numbers as sign, exponent and digits, for programs without <math.h>.
 *
 * In:    any numbers. Out: their parts, their size, the larger of two, powers of two: exact, whatever the rounding. */
#ifndef LAMC_BITS_H
#define LAMC_BITS_H

#include "lamc_real.h"

#include <stdint.h>
#include <string.h>

#ifdef LAMC_REAL_FLOAT
typedef uint32_t lamc_word;
typedef int32_t lamc_whole;
enum { LAMC_DIGITS = 24, LAMC_BIAS = 127, LAMC_HUGE = 100, LAMC_GONE = -160, LAMC_LIFT = 60 };
#define LAMC_SPLITTER 4097.0f
#else
typedef uint64_t lamc_word; /* as long as a number */
typedef int64_t lamc_whole; /* holds whole numbers of up to LAMC_DIGITS */
enum {
  LAMC_DIGITS = 53,  /* binary ones; the first is not written */
  LAMC_BIAS = 1023,  /* of exponents */
  LAMC_HUGE = 1000,  /* exponent that a number may have twice over before it is infinite */
  LAMC_GONE = -1100, /* exponent below which a number is zero */
  LAMC_LIFT = 200    /* from subnormal exponents to others */
};
#define LAMC_SPLITTER 134217729.0 /* 2^27 + 1, by which a number falls into halves of its digits */
#endif

#define LAMC_SIGN ((lamc_word)1 << (8 * sizeof(lamc_word) - 1))
#define LAMC_ONE_BIT ((lamc_word)1 << (LAMC_DIGITS - 1)) /* the last of the exponent */

static inline lamc_word lamc_bits(lamc_real x) {
  lamc_word bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}

static inline lamc_real lamc_from_bits(lamc_word bits) {
  lamc_real x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

#define LAMC_INFINITY lamc_from_bits((2 * LAMC_BIAS + 1) * LAMC_ONE_BIT)
#define LAMC_NAN lamc_from_bits((2 * LAMC_BIAS + 1) * LAMC_ONE_BIT + LAMC_ONE_BIT / 2)

static inline int lamc_is_negative(lamc_real x) {
  return (lamc_bits(x) & LAMC_SIGN) != 0;
}

static inline lamc_real lamc_fabs(lamc_real x) {
  return lamc_from_bits(lamc_bits(x) & ~LAMC_SIGN);
}

/* size with the sign of x */
static inline lamc_real lamc_copysign(lamc_real size, lamc_real x) {
  return lamc_from_bits((lamc_bits(size) & ~LAMC_SIGN) | (lamc_bits(x) & LAMC_SIGN));
}

static inline lamc_real lamc_fmax(lamc_real a, lamc_real b) {
  if (a != a) return b;
  if (b != b) return a;
  if (a == b) return lamc_is_negative(a) ? b : a; /* zeros of both signs */
  return a > b ? a : b;
}

static inline lamc_real lamc_fmin(lamc_real a, lamc_real b) {
  if (a != a) return b;
  if (b != b) return a;
  if (a == b) return lamc_is_negative(a) ? a : b;
  return a < b ? a : b;
}

/* 2^k for a normal number */
static inline lamc_real lamc_power_of_two(int k) {
  return lamc_from_bits((lamc_word)(k + LAMC_BIAS) * LAMC_ONE_BIT);
}

/* x 2^k, rounded once where it becomes subnormal: x has at most LAMC_DIGITS, and 1/8 < |x| < 8 */
static inline lamc_real lamc_scaled(lamc_real x, int k) {
  if (k > LAMC_BIAS - 3) {
    if (k > 2 * LAMC_HUGE) return x * LAMC_INFINITY;
    return x * lamc_power_of_two(LAMC_HUGE) * lamc_power_of_two(k - LAMC_HUGE);
  }
  if (k >= 5 - LAMC_BIAS) return x * lamc_power_of_two(k);
  return k < LAMC_GONE ? x * 0 : x * lamc_power_of_two(k + LAMC_LIFT) * lamc_power_of_two(-LAMC_LIFT);
}

/* The exponent k of |x| = m 2^k, finite and not zero, and m in 1 .. 2 */
static inline int lamc_split(lamc_real x, lamc_real *m) {
  int k = 0;
  lamc_word bits = lamc_bits(x) & ~LAMC_SIGN;
  if (bits < LAMC_ONE_BIT) {
    bits = lamc_bits(lamc_from_bits(bits) * lamc_power_of_two(LAMC_DIGITS + 1));
    k = -LAMC_DIGITS - 1;
  }
  *m = lamc_from_bits((bits & (LAMC_ONE_BIT - 1)) | LAMC_BIAS * LAMC_ONE_BIT);
  return k + (int)(bits / LAMC_ONE_BIT) - LAMC_BIAS;
}

/* Likewise with m in sqrt(1/2) .. sqrt(2) */
static inline int lamc_split_evenly(lamc_real x, lamc_real *m) {
  const int k = lamc_split(x, m);
  if (!(*m > LAMC_R(1.4142135623730951))) return k;
  *m *= LAMC_R(0.5);
  return k + 1;
}

#endif /* LAMC_BITS_H */
