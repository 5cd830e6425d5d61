/* trig_double.h, of lamc: trig.h in double precision.
 *
 * In:    angles, rad: any doubles. Out: sine and cosine within 0.51 units in the last place; NaN for what is not finite.
 * Never: calls a library; depends on the machine. A compiler that does not contract a*b + c gives the same bits everywhere,
 *        whether it has vectors of two numbers or not, and whichever of the functions is called. (Under -ffast-math, and
 *        where doubles are evaluated with more digits, as in x87, libm is taken instead: both break the sums below.)
 *
 * x = n pi/64 + d, sin x = S cos d + C sin d with S and C from a table, as P. T. P. Tang has it, Proc. 10th IEEE Symp.
 * Computer Arithmetic (1991) 232-236. S and C begin with multiples of 2^-26 and d with one of 2^-27, so that S + C d is
 * exact in these, and what is rounded is 2^-11 of the result at most. d in two parts, W. J. Cody, W. Waite, Software
 * Manual for the Elementary Functions (1980); far from zero, and where d all but vanishes, with as many digits of pi as
 * it takes, M. Payne, R. Hanek, ACM SIGNUM Newsletter 18 (1983) 19-24. */
#ifndef LAMC_TRIG_DOUBLE_H
#define LAMC_TRIG_DOUBLE_H

#include <float.h>

#if defined(__GNUC__)
#define LAMC_TRIG_UNUSED __attribute__((unused)) /* where all is one file, and has one angle */
#else
#define LAMC_TRIG_UNUSED
#endif

/* 16: as 0 for doubles; only numbers of half precision are kept as such (gcc for machines with AVX512-FP16) */
#if defined(__FAST_MATH__) ||                                                                                \
    (defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 1 && FLT_EVAL_METHOD != 16)
#ifdef LAMC_BARE
#error "without a mathematical library sine and cosine need IEEE 754: no -ffast-math, and SSE2 instead of x87"
#else
#include <math.h>

static inline void lamc_turn(double x, double *sine, double *cosine) {
  *sine = sin(x);
  *cosine = cos(x);
}

static inline LAMC_TRIG_UNUSED void lamc_turn_two(double x0, double x1, double *sines, double *cosines) {
  lamc_turn(x0, sines, cosines);
  lamc_turn(x1, sines + 1, cosines + 1);
}
#endif

#else
#include "trig_rows.h"

#include <string.h>

/* Adding and taking it away again rounds to a multiple of 1, and of 2^-27 */
#define LAMC_TRIG_TO_WHOLE 6755399441055744.0
#define LAMC_TRIG_TO_GRID 50331648.0

/* ---- Any angle --------------------------------------------------------------------------------------------- */

/* |x| = n pi/64 + high + low, n modulo 128 */
typedef struct lamc_trig_reduced {
  double high, low;
  int n;
} lamc_trig_reduced;

/* |x| in turns, for pi/128 and more: its 53 bits times six words of 1 / (2 pi), without those before, which make whole
 * turns. Of the fraction 139 bits are right, and the double next to a multiple of pi/64 is 2^-62 off. */
static inline lamc_trig_reduced lamc_trig_reduce(uint64_t bits) {
  const int start = (int)(bits >> 52 & 0x7ff) - 1075 + 64, first = start / 32, shift = start % 32;
  const uint64_t mantissa = (bits & 0xfffffffffffffu) | 0x10000000000000u;
  uint32_t f[6] = {0, 0, 0, 0, 0, 0}; /* the fraction, its first bits first */
  for (int half = 0; half < 2; half++) {
    const uint64_t part = half == 0 ? mantissa & 0xffffffffu : mantissa >> 32;
    uint64_t sum = 0;
    for (int k = 5; k >= half; k--) {
      const uint64_t words =
          (uint64_t)LAMC_TRIG_PER_TURN[first + k] << 32 | LAMC_TRIG_PER_TURN[first + k + 1];
      sum += part * (words << shift >> 32) + f[k - half];
      f[k - half] = (uint32_t)sum;
      sum >>= 32;
    }
  }
  const uint32_t n = (f[0] + 0x1000000u) >> 25;
  f[0] -= n << 25;
  const uint32_t sign = 0u - (f[0] >> 31);
  double scale = sign ? -5.421010862427522e-20 : 5.421010862427522e-20; /* 2^-64 */
  int k = 0;
  while (k < 3 && f[k] == sign) {
    scale *= 2.3283064365386963e-10; /* 2^-32 */
    k++;
  }
  const uint64_t top = (uint64_t)(f[k] ^ sign) << 32 | (f[k + 1] ^ sign);
  const double whole = (double)(int64_t)(top >> 11), head = (double)(float)whole;
  const double tail =
      2048.0 * (whole - head) + ((double)(int64_t)(top & 0x7ff) + 2.3283064365386963e-10 * (f[k + 2] ^ sign));
  const lamc_trig_reduced r = {
      scale * (2048.0 * head * 6.283185243606567), /* 2 pi in 26 bits, and the rest */
      scale * (2048.0 * head * 6.357301909411278e-08 + tail * 6.283185307179586), (int)(n & 127u)};
  return r;
}

/* sin d - d and cos d - 1, by y, which is d to 53 bits: what Taylor's series have within pi/128, the last two of the
 * cosine's coefficients taking up the next one's share (Chebyshev). Within 2^-61 of d and of 1. */
#define LAMC_TRIG_SINE_REST(y, z)                                                                            \
  ((y) * (z) * (-0.16666666666666666 + (z) * (0.008333333333333333 + (z) * -0.0001984126984126984)))
#define LAMC_TRIG_COSINE_REST(z) ((z) * (-0.5 + (z) * (0.041666666665541675 + (z) * -0.0013888739485901104)))

/* Sine and cosine of any double; not inlined, as it is rarely called */
static inline void lamc_turn_any(double x, double *sine, double *cosine) {
  uint64_t bits;
  memcpy(&bits, &x, sizeof bits);
  const double sign = bits >> 63 ? -1.0 : 1.0, size = sign * x;
  bits &= 0x7fffffffffffffffu;
  if (bits >= 0x7ff0000000000000u) {
    *sine = *cosine = x - x;
    return;
  }
  if (size < 7.450580596923828e-09) { /* 2^-27, and the sign of zero */
    *sine = x;
    *cosine = 1.0;
    return;
  }
  lamc_trig_reduced r = {size, 0.0, 0};
  if (size >= 0.02) r = lamc_trig_reduce(bits);
  const double y = r.high + r.low, z = y * y, grid = (y + LAMC_TRIG_TO_GRID) - LAMC_TRIG_TO_GRID;
  const double low = (r.high - y) + r.low;
  const double sine_rest = low + LAMC_TRIG_SINE_REST(y, z), cosine_rest = LAMC_TRIG_COSINE_REST(z);
  const double *s = LAMC_TRIG_SINES[r.n], *c = LAMC_TRIG_SINES[r.n + 32];
  const double rest = (y - grid) + sine_rest, full_s = s[0] + s[1], full_c = c[0] + c[1];
  double sn = (s[0] + c[0] * grid) + (((s[1] + c[1] * grid) + full_c * rest) + full_s * cosine_rest);
  double cs = (c[0] - s[0] * grid) + (((c[1] - s[1] * grid) - full_s * rest) + full_c * cosine_rest);
  if (s[0] == 0.0) sn = c[0] * (y + sine_rest);
  if (c[0] == 0.0) cs = -s[0] * (y + sine_rest);
  *sine = sign * sn;
  *cosine = cs;
}

/* ---- One angle or two -------------------------------------------------------------------------------------- */

#if defined(__GNUC__) && !defined(LAMC_PLAIN_TRIG)
typedef double lamc_trig_lanes __attribute__((vector_size(16)));
typedef long long lamc_trig_bits __attribute__((vector_size(16)));

static inline lamc_trig_lanes lamc_trig_rows(lamc_trig_bits n, int shift, int part) {
  const lamc_trig_lanes rows = {LAMC_TRIG_SINES[n[0] + shift][part], LAMC_TRIG_SINES[n[1] + shift][part]};
  return rows;
}

static inline lamc_trig_bits lamc_trig_bits_of(lamc_trig_lanes x) {
  return (lamc_trig_bits)x;
}

static inline lamc_trig_lanes lamc_trig_both(double x) {
  const lamc_trig_lanes lanes = {x, x};
  return lanes;
}

static inline double lamc_trig_first(lamc_trig_lanes x) {
  return x[0];
}

/* 1 if the sums hold for both: |x| < 6400, so that n has 17 bits, and d > 2^-17; not so for NaN */
static inline int lamc_trig_is_plain(lamc_trig_lanes x, lamc_trig_lanes z) {
  const lamc_trig_lanes xx = x * x;
  return (xx[0] < 40960000.0) & (xx[1] < 40960000.0) & (z[0] > 5.820766091346741e-11) &
         (z[1] > 5.820766091346741e-11);
}
#else
typedef double lamc_trig_lanes;
typedef long long lamc_trig_bits;

static inline lamc_trig_lanes lamc_trig_rows(lamc_trig_bits n, int shift, int part) {
  return LAMC_TRIG_SINES[n + shift][part];
}

static inline lamc_trig_bits lamc_trig_bits_of(lamc_trig_lanes x) {
  lamc_trig_bits bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}

static inline lamc_trig_lanes lamc_trig_both(double x) {
  return x;
}

static inline double lamc_trig_first(lamc_trig_lanes x) {
  return x;
}

static inline int lamc_trig_is_plain(lamc_trig_lanes x, lamc_trig_lanes z) {
  return x * x < 40960000.0 && z > 5.820766091346741e-11;
}
#endif

/* 0 if an angle among x asks for lamc_turn_any */
static inline int lamc_turn_plain(lamc_trig_lanes x, lamc_trig_lanes *sine, lamc_trig_lanes *cosine) {
  const lamc_trig_lanes shifted = x * 20.371832715762604 + LAMC_TRIG_TO_WHOLE; /* 64 / pi */
  const lamc_trig_bits n = lamc_trig_bits_of(shifted) & 127;
  const lamc_trig_lanes k = shifted - LAMC_TRIG_TO_WHOLE;
  /* pi/64 in 36 bits, by which k times it and the difference are exact, and the rest */
  const lamc_trig_lanes left = x - k * 0.049087385212260415, off = k * 8.010450473732872e-14;
  const lamc_trig_lanes y = left - off, z = y * y;
  const lamc_trig_lanes grid = (y + LAMC_TRIG_TO_GRID) - LAMC_TRIG_TO_GRID;
  const lamc_trig_lanes rest = ((left - grid) - off) + LAMC_TRIG_SINE_REST(y, z),
                        cosine_rest = LAMC_TRIG_COSINE_REST(z);
  const lamc_trig_lanes s0 = lamc_trig_rows(n, 0, 0), s1 = lamc_trig_rows(n, 0, 1), s = s0 + s1;
  const lamc_trig_lanes c0 = lamc_trig_rows(n, 32, 0), c1 = lamc_trig_rows(n, 32, 1), c = c0 + c1;
  *sine = (s0 + c0 * grid) + (((s1 + c1 * grid) + c * rest) + s * cosine_rest);
  *cosine = (c0 - s0 * grid) + (((c1 - s1 * grid) - s * rest) + c * cosine_rest);
  return lamc_trig_is_plain(x, z);
}

static inline void lamc_turn(double x, double *sine, double *cosine) {
  lamc_trig_lanes s, c;
  if (lamc_turn_plain(lamc_trig_both(x), &s, &c)) {
    *sine = lamc_trig_first(s);
    *cosine = lamc_trig_first(c);
  } else {
    lamc_turn_any(x, sine, cosine);
  }
}

/* Sines (2,) and cosines (2,) of two angles, in hardly more time than those of one */
static inline LAMC_TRIG_UNUSED void lamc_turn_two(double x0, double x1, double *sines, double *cosines) {
#if defined(__GNUC__) && !defined(LAMC_PLAIN_TRIG)
  const lamc_trig_lanes x = {x0, x1};
  lamc_trig_lanes s, c;
  if (lamc_turn_plain(x, &s, &c)) {
    memcpy(sines, &s, sizeof s);
    memcpy(cosines, &c, sizeof c);
    return;
  }
#endif
  lamc_turn(x0, sines, cosines);
  lamc_turn(x1, sines + 1, cosines + 1);
}
#endif

#endif /* LAMC_TRIG_DOUBLE_H */
