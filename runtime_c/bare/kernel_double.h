/* kernel_double.h, of lamc: what elementary.h computes in another way for doubles than for floats.
 *
 * Errors: exp, log and atan within 1 unit in the last place, pow within 0.6, the others within 3. Reductions and minimax
 * polynomials of exp, expm1, log and atan: fdlibm (Sun Microsystems 1993). */
#ifndef LAMC_KERNEL_DOUBLE_H
#define LAMC_KERNEL_DOUBLE_H

#include "bits.h"

#include <stdint.h>

enum { LAMC_EXP_TERMS = 9, LAMC_EXP_HALVINGS = 8 }; /* of e^x in two numbers */
#define LAMC_EXP_MOST 710.0                         /* beyond, e^x is infinite, */
#define LAMC_EXP_LEAST (-746.0)                     /* below, zero, */
#define LAMC_EXP_FLAT 1e-18                         /* and at sizes below this 1 + x */
#define LAMC_LN2 {0.6931471805599453, 2.3190468138462996e-17}
#define LAMC_PER_LN2 1.44269504088896338700e+00
#define LAMC_TO_WHOLE 6755399441055744.0 /* adding 1.5 2^52, and taking it away again, rounds */
#define LAMC_PI_REST 1.22464679914735317720e-16

/* ---- Roots ------------------------------------------------------------------------------------------------- */

#if (defined(__GNUC__) && defined(__NO_MATH_ERRNO__) && (defined(__SSE2__) || defined(__aarch64__))) ||      \
    defined(__wasm__)
static inline double lamc_sqrt(double x) {
  return __builtin_sqrt(x); /* one instruction, and the same number */
}
#else
static inline double lamc_sqrt(double x) {
  if (!(x > 0.0) || x == LAMC_INFINITY) return x == 0.0 || x > 0.0 ? x : LAMC_NAN;
  double m;
  int k = lamc_split(x, &m);
  if (k % 2 != 0) {
    m *= 2.0;
    k -= 1;
  }
  /* m in 1 .. 4: the inverse root by Newton's method, from 4 % to the last digit but one */
  double r = lamc_from_bits(0x5fe6eb50c7b537a9u - (lamc_bits(m) >> 1));
  for (int i = 0; i < 4; i++) r = r * (1.5 - 0.5 * m * r * r);
  double y = m * r;
  lamc_two square = lamc_two_product(y, y);
  y += 0.5 * r * ((m - square.high) - square.low);
  /* y is next to the root at most: (y +- spacing / 2)^2 is y^2 +- spacing y to what can be told from m */
  square = lamc_two_product(y, y);
  const double left = (m - square.high) - square.low, spacing = 2.220446049250313e-16;
  if (left > spacing * y) {
    y += spacing;
  } else if (left <= -spacing * y) {
    y -= spacing;
  }
  return lamc_scaled(y, k / 2);
}
#endif

/* ---- Exponentials and logarithms --------------------------------------------------------------------------- */

/* x = k ln 2 + high - low */
static inline int lamc_exp_reduce(double x, double *high, double *low) {
  const double turns = x * 1.44269504088896338700e+00 + 6755399441055744.0; /* adding 1.5 2^52 rounds */
  const double k = turns - 6755399441055744.0;
  *high = x - k * 6.93147180369123816490e-01;
  *low = k * 1.90821492927058770002e-10;
  return (int)k;
}

/* e^(high - low) for sizes up to ln 2 / 2 */
static inline double lamc_exp_near(double high, double low) {
  const double x = high - low, z = x * x;
  const double c = x - z * (1.66666666666666019037e-01 +
                            z * (-2.77777777770155933842e-03 +
                                 z * (6.61375632143793436117e-05 +
                                      z * (-1.65339022054652515390e-06 + z * 4.13813679705723846039e-08))));
  return 1.0 - ((low - (x * c) / (2.0 - c)) - high);
}

static inline double lamc_exp(double x) {
  if (x != x) return x;
  if (x > 709.79) return LAMC_INFINITY;
  if (x < -745.2) return 0.0;
  double high, low;
  const int k = lamc_exp_reduce(x, &high, &low);
  return lamc_scaled(lamc_exp_near(high, low), k);
}

/* e^x - 1 */
static inline double lamc_expm1(double x) {
  if (x != x || x == 0.0) return x;
  if (x > 709.79) return LAMC_INFINITY;
  if (x < -40.0) return -1.0;
  double high, low;
  const int k = lamc_exp_reduce(x, &high, &low);
  const double r = high - low, c = (high - r) - low, half = 0.5 * r, z = r * half;
  const double p = 1.0 + z * (-3.33333333333331316428e-02 +
                              z * (1.58730158725481460165e-03 +
                                   z * (-7.93650757867487942473e-05 +
                                        z * (4.00821782732936239552e-06 + z * -2.01099218183624371326e-07))));
  const double t = 3.0 - p * half, e = z * ((p - t) / (6.0 - r * t));
  if (k == 0) return r - ((r * e - z) - c);
  const double rest = ((r * (e - c) - c) - z); /* e^r = 1 + r - rest */
  if (k == -1) return 0.5 * (r - rest) - 0.5;
  if (k == 1) return r < -0.25 ? -2.0 * (rest - (r + 0.5)) : 1.0 + 2.0 * (r - rest);
  if (k > 56) return lamc_scaled(1.0 - (rest - r), k) - 1.0;
  if (k < 20) return lamc_scaled((1.0 - lamc_power_of_two(-k)) - (rest - r), k);
  return lamc_scaled((r - (rest + lamc_power_of_two(-k))) + 1.0, k);
}

static inline double lamc_log(double x) {
  if (!(x > 0.0)) return x == 0.0 ? -LAMC_INFINITY : LAMC_NAN;
  if (x == LAMC_INFINITY) return x;
  double m;
  const int k = lamc_split_evenly(x, &m);
  const double f = m - 1.0, s = f / (2.0 + f), z = s * s, half = 0.5 * f * f, turns = k;
  const double rest =
      z * (6.666666666666735130e-01 +
           z * (3.999999999940941908e-01 +
                z * (2.857142874366239149e-01 +
                     z * (2.222219843214978396e-01 +
                          z * (1.818357216161805012e-01 +
                               z * (1.531383769920937332e-01 + z * 1.479819860511658591e-01))))));
  return turns * 6.93147180369123816490e-01 -
         ((half - (s * (half + rest) + turns * 1.90821492927058770002e-10)) - f);
}

/* ---- Angles ------------------------------------------------------------------------------------------------ */

/* atan x for x >= 0 */
static inline double lamc_atan_of_size(double x) {
  double high = 0.0, low = 0.0;
  if (x >= 2.4375) {
    high = 1.57079632679489655800e+00;
    low = 6.12323399573676603587e-17;
    x = -1.0 / x;
  } else if (x >= 1.1875) {
    high = 9.82793723247329054082e-01;
    low = 1.39033110312309984516e-17;
    x = (x - 1.5) / (1.0 + 1.5 * x);
  } else if (x >= 0.6875) {
    high = 7.85398163397448278999e-01;
    low = 3.06161699786838301793e-17;
    x = (x - 1.0) / (x + 1.0);
  } else if (x >= 0.4375) {
    high = 4.63647609000806093515e-01;
    low = 2.26987774529616870924e-17;
    x = (2.0 * x - 1.0) / (2.0 + x);
  }
  const double z = x * x;
  const double rest =
      z * (3.33333333333329318027e-01 +
           z * (-1.99999999998764832476e-01 +
                z * (1.42857142725034663711e-01 +
                     z * (-1.11111104054623557880e-01 +
                          z * (9.09088713343650656196e-02 +
                               z * (-7.69187620504482999495e-02 +
                                    z * (6.66107313738753120669e-02 +
                                         z * (-5.83357013379057348645e-02 +
                                              z * (4.97687799461593236017e-02 +
                                                   z * (-3.65315727442169155270e-02 +
                                                        z * 1.62858201153657823623e-02))))))))));
  return high == 0.0 ? x - x * rest : high - ((x * rest - low) - x);
}

static inline double lamc_asin(double x) {
  const double size = lamc_fabs(x);
  if (!(size <= 1.0)) return LAMC_NAN;
  if (size < 1e-8) return x;
  return lamc_copysign(lamc_atan2(size, lamc_sqrt((1.0 - size) * (1.0 + size))), x);
}

static inline double lamc_acos(double x) {
  if (!(lamc_fabs(x) <= 1.0)) return LAMC_NAN;
  return 2.0 * lamc_atan2(lamc_sqrt(1.0 - x), lamc_sqrt(1.0 + x));
}

/* ---- Hyperbolic functions ---------------------------------------------------------------------------------- */

/* e^x / 2 beyond where e^x is infinite already */
static inline double lamc_half_exp(double x) {
  if (x > 711.0) return LAMC_INFINITY;
  const double root = lamc_exp(0.5 * x);
  return x < 700.0 ? 0.5 * lamc_exp(x) : 0.5 * root * root;
}

static inline double lamc_sinh(double x) {
  const double size = lamc_fabs(x);
  if (x != x || size < 1e-8) return x;
  if (size > 22.0) return lamc_copysign(lamc_half_exp(size), x);
  const double e = lamc_expm1(size);
  return lamc_copysign(size < 1.0 ? 0.5 * (2.0 * e - e * e / (e + 1.0)) : 0.5 * (e + e / (e + 1.0)), x);
}

static inline double lamc_cosh(double x) {
  const double size = lamc_fabs(x);
  if (x != x) return x;
  if (size > 22.0) return lamc_half_exp(size);
  if (size < 0.35) {
    const double e = lamc_expm1(size);
    return 1.0 + e * e / (2.0 * (1.0 + e));
  }
  const double e = lamc_exp(size);
  return 0.5 * e + 0.5 / e;
}

static inline double lamc_tanh(double x) {
  const double size = lamc_fabs(x);
  if (x != x || size < 1e-8) return x;
  if (size > 22.0) return lamc_copysign(1.0, x);
  const double e = lamc_expm1(size < 1.0 ? -2.0 * size : 2.0 * size);
  return lamc_copysign(size < 1.0 ? -e / (e + 2.0) : 1.0 - 2.0 / (e + 2.0), x);
}

#endif /* LAMC_KERNEL_DOUBLE_H */
