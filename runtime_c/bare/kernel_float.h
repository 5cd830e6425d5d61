/* kernel_float.h, of lamc: what elementary.h computes in another way for floats than for doubles, and without any.
 *
 * Errors: exp, log and pow within 1 unit in the last place, the others within 3. Polynomials of exp, log, atan, sinh, tanh:
 * Cephes library (S. L. Moshier 1992). */
#ifndef LAMC_KERNEL_FLOAT_H
#define LAMC_KERNEL_FLOAT_H

#include "bits.h"

#include <stdint.h>

enum { LAMC_EXP_TERMS = 7, LAMC_EXP_HALVINGS = 4 };
#define LAMC_EXP_MOST 89.0f
#define LAMC_EXP_LEAST (-105.0f)
#define LAMC_EXP_FLAT 1e-9f
#define LAMC_LN2 {0.6931472f, -1.9046542e-09f}
#define LAMC_PER_LN2 1.442695f
#define LAMC_TO_WHOLE 12582912.0f /* adding 1.5 2^23, and taking it away again, rounds */
#define LAMC_PI_REST (-8.742278e-08f)

/* ---- Roots ------------------------------------------------------------------------------------------------- */

#if defined(__GNUC__) && defined(__arm__) && defined(__ARM_FP) && !defined(LAMC_PLAIN_SQRT)
static inline float lamc_sqrt(float x) {
  float y;
  __asm__("vsqrt.f32 %0, %1" : "=t"(y) : "t"(x)); /* one instruction, and the same number */
  return y;
}
#elif defined(__GNUC__) && defined(__NO_MATH_ERRNO__) && defined(__SSE2__) && !defined(LAMC_PLAIN_SQRT)
static inline float lamc_sqrt(float x) {
  return __builtin_sqrtf(x);
}
#else
/* Bit by bit, as on paper */
static inline float lamc_sqrt(float x) {
  if (!(x > 0.0f) || x == LAMC_INFINITY) return x == 0.0f || x > 0.0f || x != x ? x : LAMC_NAN;
  float m;
  const int k = lamc_split(x, &m), is_odd = k & 1;
  uint32_t left = ((lamc_bits(m) & 0x7fffffu) | 0x800000u) << (is_odd + 1), root = 0, sum = 0;
  for (uint32_t bit = 0x1000000u; bit != 0; bit >>= 1) {
    if (sum + bit <= left) {
      left -= sum + bit;
      sum += 2u * bit;
      root += bit;
    }
    left *= 2u;
  }
  root = (root + (root & 1u)) / 2u; /* the last bit rounds; what is left tells that no tie is possible */
  return lamc_scaled((float)(int32_t)root * 1.1920929e-07f, (k - is_odd) / 2);
}
#endif

/* ---- Exponentials and logarithms --------------------------------------------------------------------------- */

/* The whole number next to x / ln 2, and what is left of x */
static inline int lamc_exp_reduce(float x, float *left) {
  const float n = (x * 1.442695f + 12582912.0f) - 12582912.0f; /* adding 1.5 2^23 rounds */
  *left = (x - n * 0.693359375f) - n * -0.00021219444f;
  return (int)n;
}

/* e^x - 1 - x for sizes up to ln 2 / 2 */
static inline float lamc_exp_rest(float x) {
  return x * x *
         (0.5f + x * (0.16666666f +
                      x * (0.041665796f + x * (0.008333452f + x * (0.0013981999f + x * 0.00019875691f)))));
}

static inline float lamc_exp(float x) {
  if (x != x) return x;
  if (x > 88.8f) return LAMC_INFINITY;
  if (x < -104.0f) return 0.0f;
  float left;
  const int k = lamc_exp_reduce(x, &left);
  return lamc_scaled(1.0f + (left + lamc_exp_rest(left)), k);
}

/* log m for m in sqrt(1/2) .. sqrt(2), without m - 1 */
static inline float lamc_log_rest(float f) {
  const float z = f * f;
  const float p =
      f * z *
      (0.3333333f +
       f * (-0.24999994f +
            f * (0.20000714f +
                 f * (-0.16668057f +
                      f * (0.14249323f + f * (-0.12420141f +
                                              f * (0.116769984f + f * (-0.1151461f + f * 0.070376836f))))))));
  return p - 0.5f * z;
}

static inline float lamc_log(float x) {
  if (x != x) return x;
  if (!(x > 0.0f)) return x == 0.0f ? -LAMC_INFINITY : LAMC_NAN;
  if (x == LAMC_INFINITY) return x;
  float m;
  const float k = (float)lamc_split_evenly(x, &m), f = m - 1.0f;
  return (f + (lamc_log_rest(f) - k * 0.00021219444f)) + k * 0.693359375f;
}

/* ---- Angles ------------------------------------------------------------------------------------------------ */

/* atan x for x >= 0 */
static inline float lamc_atan_of_size(float x) {
  float high = 0.0f, low = 0.0f;
  if (x > 2.4142137f) {
    high = 1.5707964f;
    low = -4.371139e-08f;
    x = -1.0f / x;
  } else if (x > 0.41421357f) {
    high = 0.7853982f;
    low = -2.1855695e-08f;
    x = (x - 1.0f) / (x + 1.0f);
  }
  const float z = x * x;
  const float rest = x * z * (-0.3333295f + z * (0.19977711f + z * (-0.13877686f + z * 0.080537446f)));
  return high + (x + (rest + low));
}

static inline float lamc_asin(float x) {
  const float size = lamc_fabs(x);
  if (x != x) return x;
  if (!(size <= 1.0f)) return LAMC_NAN;
  if (size < 1e-4f) return x;
  return lamc_copysign(lamc_atan2(size, lamc_sqrt((1.0f - size) * (1.0f + size))), x);
}

static inline float lamc_acos(float x) {
  if (x != x) return x;
  if (!(lamc_fabs(x) <= 1.0f)) return LAMC_NAN;
  return lamc_atan2(lamc_sqrt((1.0f - x) * (1.0f + x)), x);
}

/* ---- Hyperbolic functions ---------------------------------------------------------------------------------- */

/* e^x / 2 beyond where e^x is infinite already */
static inline float lamc_half_exp(float x) {
  if (x > 90.0f) return LAMC_INFINITY;
  float left;
  const int k = lamc_exp_reduce(x, &left);
  return lamc_scaled(1.0f + (left + lamc_exp_rest(left)), k - 1);
}

static inline float lamc_sinh(float x) {
  const float size = lamc_fabs(x);
  if (x != x || size < 1e-4f) return x;
  if (size > 1.0f) {
    const float half = lamc_half_exp(size);
    return lamc_copysign(half - 0.25f / half, x);
  }
  const float z = x * x;
  return x + x * z * (0.16666716f + z * (0.008330284f + z * 0.00020372191f));
}

static inline float lamc_cosh(float x) {
  const float half = lamc_half_exp(lamc_fabs(x));
  return x == x ? half + 0.25f / half : x;
}

static inline float lamc_tanh(float x) {
  const float size = lamc_fabs(x);
  if (x != x || size < 1e-4f) return x;
  if (size > 10.0f) return lamc_copysign(1.0f, x);
  if (size > 0.625f) return lamc_copysign(1.0f - 2.0f / (lamc_exp(2.0f * size) + 1.0f), x);
  const float z = x * x;
  return x + x * z *
                 (-0.33333284f +
                  z * (0.13331442f + z * (-0.053739715f + z * (0.020639088f + z * -0.0057049887f))));
}

#endif /* LAMC_KERNEL_FLOAT_H */
