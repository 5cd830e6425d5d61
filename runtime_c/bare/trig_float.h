/* trig_float.h, of lamc: trig.h in single precision.
 *
 * In:    angles, rad: any floats. Out: sine and cosine within 1 unit in the last place; NaN for what is not finite.
 * Never: calls a library; computes with doubles. Without contraction of a*b + c the same bits on every machine.
 *
 * Angles are reduced to an eighth of a turn in integers, with as many digits of pi as it takes (M. Payne, R. Hanek, ACM
 * SIGNUM Newsletter 18 (1983) 19-24): small processors multiply 32 bits by 32 in one instruction, and have no doubles.
 * Polynomials: sinf and cosf of the Cephes library (S. L. Moshier 1992). */
#ifndef LAMC_TRIG_FLOAT_H
#define LAMC_TRIG_FLOAT_H

#include "bits.h"

#include <float.h>
#include <stdint.h>

#if defined(__FAST_MATH__) || (defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 16)
#error "sine and cosine need IEEE 754 in single precision: no -ffast-math, and SSE2 instead of x87"
#endif

/* 1 / (2 pi) after 32 zeros, the bits of which count 2^31 to 2^0 */
static const uint32_t LAMC_TRIG_PER_TURN[8] = {0x00000000u, 0x28be60dbu, 0x9391054au, 0x7f09d5f4u,
                                               0x7d4d3770u, 0x36d8a566u, 0x4f10e410u, 0x7f9458eau};

/* |x| = n pi/2 + high + low, n modulo 4 */
typedef struct lamc_trig_reduced {
  float high, low;
  int n;
} lamc_trig_reduced;

/* For 1/2 and more: the 24 bits of |x| times three words of 1 / (2 pi), without the bits before, which make whole turns.
 * Of the fraction 64 bits are right, and the float next to a multiple of pi/2 is 2^-32 off. */
static inline lamc_trig_reduced lamc_trig_reduce(uint32_t size) {
  const uint32_t start = (size >> 23) - 150u + 32u, first = start / 32u, shift = start % 32u;
  const uint64_t mantissa = (size & 0x7fffffu) | 0x800000u;
  uint32_t word[3];
  for (uint32_t k = 0; k < 3; k++) {
    const uint64_t words = (uint64_t)LAMC_TRIG_PER_TURN[first + k] << 32 | LAMC_TRIG_PER_TURN[first + k + 1];
    word[k] = (uint32_t)(words << shift >> 32);
  }
  const uint64_t turn = (mantissa * word[0] << 32) + mantissa * word[1] + (mantissa * word[2] >> 32);
  const uint64_t n = (turn + ((uint64_t)1 << 61)) >> 62, left = turn - (n << 62);
  const int is_below = (int)(left >> 63);
  uint64_t rest = is_below ? 0u - left : left;
  float scale = is_below ? -5.9604645e-08f : 5.9604645e-08f; /* 2^-24 */
  for (int k = 0; k < 6 && rest >> 56 == 0; k++) {
    rest <<= 8;
    scale *= 0.00390625f; /* 2^-8 */
  }
  /* In parts of 12, 12 and 24 bits; 2 pi in one of 12 and the rest: the first two products are exact */
  const float a = scale * (4096.0f * (float)(int32_t)(rest >> 52)),
              b = scale * (float)(int32_t)(rest >> 40 & 0xfffu),
              c = scale * 5.9604645e-08f * (float)(int32_t)(rest >> 16 & 0xffffffu);
  const float top = a * 6.28125f, more = b * 6.28125f + (c * 6.28125f + (a + b) * 0.0019353072f);
  const float high = top + more;
  const lamc_trig_reduced r = {high, (top - high) + more, (int)(n & 3u)};
  return r;
}

static inline void lamc_turn(float x, float *sine, float *cosine) {
  const uint32_t size = lamc_bits(x) & 0x7fffffffu;
  if (size >= 0x7f800000u) {
    *sine = *cosine = x - x;
    return;
  }
  if (size < 0x39800000u) { /* 2^-12, and the sign of zero */
    *sine = x;
    *cosine = 1.0f;
    return;
  }
  lamc_trig_reduced r = {lamc_from_bits(size), 0.0f, 0};
  if (size > 0x3f490fdau) r = lamc_trig_reduce(size); /* pi/4 */
  const float y = r.high, z = y * y;
  const float sn = y + (r.low + y * z * (-0.16666655f + z * (0.008332161f + z * -0.00019515296f)));
  const float half = 0.5f * z, whole = 1.0f - half;
  const float cs = whole + (((1.0f - whole) - half) +
                            (z * z * (0.041666646f + z * (-0.0013887316f + z * 2.4433157e-05f)) - y * r.low));
  const float s = r.n & 1 ? cs : sn, c = r.n & 1 ? sn : cs;
  const int is_minus_s = (r.n >> 1) ^ (int)(lamc_bits(x) >> 31), is_minus_c = (r.n >> 1) ^ (r.n & 1);
  *sine = is_minus_s ? -s : s;
  *cosine = is_minus_c ? -c : c;
}

/* Sines (2,) and cosines (2,) of two angles */
static inline void lamc_turn_two(float x0, float x1, float *sines, float *cosines) {
  lamc_turn(x0, sines, cosines);
  lamc_turn(x1, sines + 1, cosines + 1);
}

#endif /* LAMC_TRIG_FLOAT_H */
