/* elementary.h, of lamc: what a model needs of <math.h> beside sine and cosine, for programs without one.
 *
 * In:    any numbers. Out: square root as IEEE 754 has it, and the rest to what kernel_double.h and kernel_float.h say; at
 *        zeros, infinities and NaN what C99, annex F, says.
 * Never: calls a library, sets errno, looks into a table. Without contraction of a*b + c the same bits on every machine. */
#ifndef LAMC_ELEMENTARY_H
#define LAMC_ELEMENTARY_H

#include "bits.h"
#include "trig.h"
#include "two.h"

#include <stdint.h>

static inline lamc_real lamc_atan2(lamc_real y, lamc_real x);

#ifdef LAMC_REAL_FLOAT
#include "kernel_float.h"
#else
#include "kernel_double.h"
#endif

/* ---- Powers ------------------------------------------------------------------------------------------------ */

/* e^x in two numbers, for sizes up to 1: (1 + (e^(x / 2^n) - 1))^(2^n), by the first terms of the series */
static inline lamc_two lamc_two_exp(lamc_two x) {
  const lamc_real part = lamc_power_of_two(-LAMC_EXP_HALVINGS);
  const lamc_two one = {1, 0}, small = {x.high * part, x.low * part};
  lamc_two e = {0, 0};
  for (int i = LAMC_EXP_TERMS; i > 0; i--) {
    const lamc_two i_two = {(lamc_real)i, 0};
    e = lamc_two_over(lamc_two_times(lamc_two_add(one, e), small), i_two);
  }
  /* (1 + e)^2 - 1 = 2 e + e^2 keeps the digits of e */
  for (int i = 0; i < LAMC_EXP_HALVINGS; i++) {
    const lamc_two twice = {2 * e.high, 2 * e.low};
    e = lamc_two_add(twice, lamc_two_times(e, e));
  }
  return lamc_two_add(one, e);
}

/* log m in two numbers for m in 0.7 .. 1.42: one step of Halley's method, log m = y + 2 (m - e^y) / (m + e^y) */
static inline lamc_two lamc_two_log(lamc_real m) {
  const lamc_two y = {lamc_log(m), 0}, m_two = {m, 0};
  const lamc_two e = lamc_two_exp(y), minus = {-e.high, -e.low};
  const lamc_real step = 2 * lamc_two_add(m_two, minus).high / (m + e.high);
  return lamc_two_sum(y.high, step);
}

/* 1 if y is a whole number, 2 if an even one */
static inline int lamc_is_whole(lamc_real y) {
  const lamc_real size = lamc_fabs(y);
  if (size >= lamc_power_of_two(LAMC_DIGITS)) return 2;
  const lamc_whole whole = (lamc_whole)size;
  if ((lamc_real)whole != size) return 0;
  return whole % 2 == 0 ? 2 : 1;
}

/* |x|^y, both finite and x not zero */
static inline lamc_real lamc_pow_of_size(lamc_real x, lamc_real y) {
  lamc_real m;
  const int k = lamc_split_evenly(x, &m);
  if (m == 1 && k == 0) return 1;
  const lamc_real rough = y * ((lamc_real)k * LAMC_R(0.6931471805599453) + lamc_log(m));
  if (rough > LAMC_EXP_MOST) return LAMC_INFINITY;
  if (rough < LAMC_EXP_LEAST) return 0;
  if (lamc_fabs(rough) < LAMC_EXP_FLAT) return 1 + rough;
  const lamc_two ln2 = LAMC_LN2, turns = {(lamc_real)k, 0}, y_two = {y, 0};
  lamc_two power = lamc_two_times(y_two, lamc_two_add(lamc_two_times(turns, ln2), lamc_two_log(m)));
  const lamc_real n = (power.high * LAMC_PER_LN2 + LAMC_TO_WHOLE) - LAMC_TO_WHOLE;
  const lamc_two back = {-n, 0};
  power = lamc_two_add(power, lamc_two_times(back, ln2));
  const lamc_two e = lamc_two_exp(power);
  return lamc_scaled(e.high, (int)n);
}

static inline lamc_real lamc_pow(lamc_real x, lamc_real y) {
  if (y == 0 || x == 1) return 1;
  if (x != x || y != y) return x + y;
  const lamc_real size = lamc_fabs(x);
  const int whole = lamc_is_whole(y);
  if (lamc_fabs(y) == LAMC_INFINITY) {
    if (size == 1) return 1;
    return (size > 1) == (y > 0) ? LAMC_INFINITY : 0;
  }
  const int is_odd = whole == 1;
  lamc_real result;
  if (size == 0) {
    result = y > 0 ? 0 : LAMC_INFINITY;
  } else if (size == LAMC_INFINITY) {
    result = y > 0 ? LAMC_INFINITY : 0;
  } else if (x < 0 && !whole) {
    return LAMC_NAN;
  } else {
    result = lamc_pow_of_size(size, y);
  }
  return lamc_is_negative(x) && is_odd ? -result : result;
}

/* ---- Angles ------------------------------------------------------------------------------------------------ */

static inline lamc_real lamc_tan(lamc_real x) {
  lamc_real sine, cosine;
  lamc_turn(x, &sine, &cosine);
  return sine / cosine;
}

static inline lamc_real lamc_atan(lamc_real x) {
  return x == x ? lamc_copysign(lamc_atan_of_size(lamc_fabs(x)), x) : x;
}

static inline lamc_real lamc_atan2(lamc_real y, lamc_real x) {
  if (x != x || y != y) return x + y;
  const lamc_real rise = lamc_fabs(y), run = lamc_fabs(x);
  lamc_real angle;
  if (rise == run && (rise == 0 || rise == LAMC_INFINITY)) {
    angle = rise == 0 ? 0 : LAMC_R(0.7853981633974483);
  } else {
    angle = lamc_atan_of_size(rise / run);
  }
  if (lamc_is_negative(x)) angle = LAMC_R(3.141592653589793) - (angle - LAMC_PI_REST);
  return lamc_copysign(angle, y);
}

#endif /* LAMC_ELEMENTARY_H */
