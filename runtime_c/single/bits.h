/* bits.h, of lamc, in single precision: floats as sign, exponent and digits.
 *
 * In:    any floats. Out: their parts, their size, the larger of two, powers of two: exact, whatever the rounding. */
#ifndef LAMC_BITS_H
#define LAMC_BITS_H

#include <stdint.h>
#include <string.h>

static inline uint32_t lamc_bits(float x) {
  uint32_t bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}

static inline float lamc_from_bits(uint32_t bits) {
  float x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

#define LAMC_INFINITY lamc_from_bits(0x7f800000u)
#define LAMC_NAN lamc_from_bits(0x7fc00000u)

static inline int lamc_is_negative(float x) {
  return (int)(lamc_bits(x) >> 31);
}

static inline float lamc_fabs(float x) {
  return lamc_from_bits(lamc_bits(x) & 0x7fffffffu);
}

/* size with the sign of x */
static inline float lamc_copysign(float size, float x) {
  return lamc_from_bits((lamc_bits(size) & 0x7fffffffu) | (lamc_bits(x) & 0x80000000u));
}

static inline float lamc_fmax(float a, float b) {
  if (a != a) return b;
  if (b != b) return a;
  if (a == b) return lamc_is_negative(a) ? b : a; /* zeros of both signs */
  return a > b ? a : b;
}

static inline float lamc_fmin(float a, float b) {
  if (a != a) return b;
  if (b != b) return a;
  if (a == b) return lamc_is_negative(a) ? a : b;
  return a < b ? a : b;
}

/* 2^k for a normal number */
static inline float lamc_power_of_two(int k) {
  return lamc_from_bits((uint32_t)(k + 127) << 23);
}

/* x 2^k, rounded once where it becomes subnormal, for 1/8 < |x| < 8 */
static inline float lamc_scaled(float x, int k) {
  if (k > 124) return k > 200 ? x * LAMC_INFINITY : x * lamc_power_of_two(100) * lamc_power_of_two(k - 100);
  if (k >= -122) return x * lamc_power_of_two(k);
  return k < -160 ? x * 0.0f : x * lamc_power_of_two(k + 60) * lamc_power_of_two(-60);
}

/* The exponent k of |x| = m 2^k, finite and not zero, and m in 1 .. 2 */
static inline int lamc_split(float x, float *m) {
  int k = 0;
  uint32_t bits = lamc_bits(x) & 0x7fffffffu;
  if (bits < 0x00800000u) {
    bits = lamc_bits(lamc_from_bits(bits) * 33554432.0f); /* 2^25 */
    k = -25;
  }
  *m = lamc_from_bits((bits & 0x007fffffu) | 0x3f800000u);
  return k + (int)(bits >> 23) - 127;
}

/* Likewise with m in sqrt(1/2) .. sqrt(2) */
static inline int lamc_split_evenly(float x, float *m) {
  const int k = lamc_split(x, m);
  if (!(*m > 1.4142135f)) return k;
  *m *= 0.5f;
  return k + 1;
}

#define LAMC_SPLITTER 4097.0f /* 2^12 + 1, by which a number falls into halves of its digits */

#endif /* LAMC_BITS_H */
