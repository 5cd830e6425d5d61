/* bits.h, of lamc: doubles as sign, exponent and digits, for programs without <math.h>.
 *
 * In:    any doubles. Out: their parts, their size, the larger of two, powers of two: exact, whatever the rounding. */
#ifndef LAMC_BITS_H
#define LAMC_BITS_H

#include <stdint.h>
#include <string.h>

static inline uint64_t lamc_bits(double x) {
  uint64_t bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}

static inline double lamc_from_bits(uint64_t bits) {
  double x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

#define LAMC_INFINITY lamc_from_bits(0x7ff0000000000000u)
#define LAMC_NAN lamc_from_bits(0x7ff8000000000000u)

static inline int lamc_is_negative(double x) {
  return (int)(lamc_bits(x) >> 63);
}

static inline double lamc_fabs(double x) {
  return lamc_from_bits(lamc_bits(x) & 0x7fffffffffffffffu);
}

/* size with the sign of x */
static inline double lamc_copysign(double size, double x) {
  return lamc_from_bits((lamc_bits(size) & 0x7fffffffffffffffu) | (lamc_bits(x) & 0x8000000000000000u));
}

static inline double lamc_fmax(double a, double b) {
  if (a != a) return b;
  if (b != b) return a;
  if (a == b) return lamc_is_negative(a) ? b : a; /* zeros of both signs */
  return a > b ? a : b;
}

static inline double lamc_fmin(double a, double b) {
  if (a != a) return b;
  if (b != b) return a;
  if (a == b) return lamc_is_negative(a) ? a : b;
  return a < b ? a : b;
}

/* 2^k for a normal number */
static inline double lamc_power_of_two(int k) {
  return lamc_from_bits((uint64_t)(k + 1023) << 52);
}

/* x 2^k, rounded once where it becomes subnormal: x has at most 53 bits, and 1/8 < |x| < 8 */
static inline double lamc_scaled(double x, int k) {
  if (k > 1020)
    return k > 2000 ? x * LAMC_INFINITY : x * lamc_power_of_two(1000) * lamc_power_of_two(k - 1000);
  if (k >= -1018) return x * lamc_power_of_two(k);
  return k < -1100 ? x * 0.0 : x * lamc_power_of_two(k + 200) * lamc_power_of_two(-200);
}

/* The exponent k of |x| = m 2^k, finite and not zero, and m in 1 .. 2 */
static inline int lamc_split(double x, double *m) {
  int k = 0;
  uint64_t bits = lamc_bits(x) & 0x7fffffffffffffffu;
  if (bits < 0x0010000000000000u) {
    bits = lamc_bits(lamc_from_bits(bits) * lamc_power_of_two(54));
    k = -54;
  }
  *m = lamc_from_bits((bits & 0x000fffffffffffffu) | 0x3ff0000000000000u);
  return k + (int)(bits >> 52) - 1023;
}

#define LAMC_SPLITTER 134217729.0 /* 2^27 + 1, by which a number falls into halves of its digits */

#endif /* LAMC_BITS_H */
