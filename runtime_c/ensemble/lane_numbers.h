/* lane_numbers.h, of lamc: numbers of several lanes at once, and what generated C does with them.
 *
 * In:    vectors of as many doubles as the machine has room for. Out: in each lane the bits that a double by itself gives.
 * Never: takes the numbers of one lane into another; contracts a*b + c (-ffp-contract=off). */
#ifndef LAMC_LANE_NUMBERS_H
#define LAMC_LANE_NUMBERS_H

#include "trig.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__AVX512F__)
#define LAMC_LANES 8
#elif defined(__AVX__)
#define LAMC_LANES 4
#else
#define LAMC_LANES 2 /* SSE2, NEON, and whatever a compiler makes of them elsewhere */
#endif

#if defined(__clang__)
#define LAMC_UNROLLED _Pragma("clang loop unroll(full)")
#else
#define LAMC_UNROLLED _Pragma("GCC unroll 16")
#endif
#define LAMC_FOR_LANES LAMC_UNROLLED for (int k = 0; k < LAMC_LANES; k++)
#define LAMC_LANE_FUNCTION static inline __attribute__((unused, always_inline))

typedef double lanes __attribute__((vector_size(8 * LAMC_LANES), may_alias));
typedef int64_t lane_bits __attribute__((vector_size(8 * LAMC_LANES), may_alias));

/* Lanes of two vectors in a new order, those of the second numbered on */
#if defined(__clang__)
#define LAMC_SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define LAMC_SHUFFLE(a, b, ...) __builtin_shuffle(a, b, (lane_bits){__VA_ARGS__})
#endif

/* A number in all lanes, with the sign of its zero */
LAMC_LANE_FUNCTION lanes EACH(double x) {
  lanes all;
  LAMC_FOR_LANES all[k] = x;
  return all;
}

LAMC_LANE_FUNCTION lanes lane_fabs(lanes x) {
  return (lanes)((lane_bits)x & INT64_MAX);
}

/* a > b ? a : b, as `larger` of method.h has it */
LAMC_LANE_FUNCTION lanes lane_larger(lanes a, lanes b) {
  const lane_bits is = (lane_bits)(a > b);
  return (lanes)((is & (lane_bits)a) | (~is & (lane_bits)b));
}

/* 1 if the bits of some lane are not zero */
LAMC_LANE_FUNCTION int lane_any(lane_bits x) {
#if defined(__AVX__)
  long long quad __attribute__((vector_size(32))), part __attribute__((vector_size(32)));
  memcpy(&quad, &x, sizeof quad);
  memcpy(&part, (const char *)&x + sizeof x - sizeof part,
         sizeof part); /* the other half of eight, or the same */
  quad |= part;
  return !__builtin_ia32_ptestz256(quad, quad);
#else
  return (x[0] | x[1]) != 0;
#endif
}

/* ---- Sine and cosine: those of trig_double.h, term by term --------------------------------------------------- */

#ifdef LAMC_TRIG_TO_WHOLE
/* The two parts of row n + shift of the table, in each lane */
LAMC_LANE_FUNCTION void lane_rows(lane_bits n, int shift, lanes *first, lanes *second) {
  int64_t at[LAMC_LANES];
  memcpy(at, &n, sizeof at);
#define ROW(k) LAMC_TRIG_SINES[at[k] + shift]
#if LAMC_LANES == 8
  const lanes one = {ROW(0)[0], ROW(0)[1], ROW(1)[0], ROW(1)[1], ROW(2)[0], ROW(2)[1], ROW(3)[0], ROW(3)[1]};
  const lanes two = {ROW(4)[0], ROW(4)[1], ROW(5)[0], ROW(5)[1], ROW(6)[0], ROW(6)[1], ROW(7)[0], ROW(7)[1]};
  *first = LAMC_SHUFFLE(one, two, 0, 2, 4, 6, 8, 10, 12, 14);
  *second = LAMC_SHUFFLE(one, two, 1, 3, 5, 7, 9, 11, 13, 15);
#elif LAMC_LANES == 4
  const lanes one = {ROW(0)[0], ROW(0)[1], ROW(1)[0], ROW(1)[1]};
  const lanes two = {ROW(2)[0], ROW(2)[1], ROW(3)[0], ROW(3)[1]};
  *first = LAMC_SHUFFLE(one, two, 0, 2, 4, 6);
  *second = LAMC_SHUFFLE(one, two, 1, 3, 5, 7);
#else
  const lanes one = {ROW(0)[0], ROW(1)[0]}, two = {ROW(0)[1], ROW(1)[1]};
  *first = one;
  *second = two;
#endif
#undef ROW
}

LAMC_LANE_FUNCTION void lane_turn(lanes x, lanes *sine, lanes *cosine) {
  const lanes shifted = x * 20.371832715762604 + LAMC_TRIG_TO_WHOLE;
  const lane_bits n = (lane_bits)shifted & 127;
  const lanes whole = shifted - LAMC_TRIG_TO_WHOLE;
  const lanes left = x - whole * 0.049087385212260415, off = whole * 8.010450473732872e-14;
  const lanes y = left - off, z = y * y;
  const lanes grid = (y + LAMC_TRIG_TO_GRID) - LAMC_TRIG_TO_GRID;
  const lanes rest = ((left - grid) - off) + LAMC_TRIG_SINE_REST(y, z),
              cosine_rest = LAMC_TRIG_COSINE_REST(z);
  lanes s0, s1, c0, c1;
  lane_rows(n, 0, &s0, &s1);
  lane_rows(n, 32, &c0, &c1);
  const lanes s = s0 + s1, c = c0 + c1;
  *sine = (s0 + c0 * grid) + (((s1 + c1 * grid) + c * rest) + s * cosine_rest);
  *cosine = (c0 - s0 * grid) + (((c1 - s1 * grid) - s * rest) + c * cosine_rest);
  const lane_bits plain = (lane_bits)(x * x < 40960000.0) & (lane_bits)(z > 5.820766091346741e-11);
  if (__builtin_expect(lane_any(~plain), 0)) {
    for (int k = 0; k < LAMC_LANES; k++) {
      double one_sine = (*sine)[k], one_cosine = (*cosine)[k];
      if (!plain[k]) lamc_turn_any(x[k], &one_sine, &one_cosine);
      (*sine)[k] = one_sine;
      (*cosine)[k] = one_cosine;
    }
  }
}
#else /* where trig.h takes the library's */
LAMC_LANE_FUNCTION void lane_turn(lanes x, lanes *sine, lanes *cosine) {
  LAMC_FOR_LANES {
    double one_sine, one_cosine;
    lamc_turn(x[k], &one_sine, &one_cosine);
    (*sine)[k] = one_sine;
    (*cosine)[k] = one_cosine;
  }
}
#endif

LAMC_LANE_FUNCTION void lane_turn_two(lanes x0, lanes x1, lanes *sines, lanes *cosines) {
  lane_turn(x0, sines, cosines);
  lane_turn(x1, sines + 1, cosines + 1);
}

LAMC_LANE_FUNCTION lanes lane_sin(lanes x) {
  lanes sine, cosine;
  lane_turn(x, &sine, &cosine);
  return sine;
}

LAMC_LANE_FUNCTION lanes lane_cos(lanes x) {
  lanes sine, cosine;
  lane_turn(x, &sine, &cosine);
  return cosine;
}

/* ---- Other functions: those of the library, lane by lane ----------------------------------------------------- */

#define LAMC_LANE_BY_LANE(name)                                                                              \
  LAMC_LANE_FUNCTION lanes lane_##name(lanes x) {                                                            \
    LAMC_FOR_LANES x[k] = name(x[k]);                                                                        \
    return x;                                                                                                \
  }
#define LAMC_LANE_BY_LANE_OF_TWO(name)                                                                       \
  LAMC_LANE_FUNCTION lanes lane_##name(lanes x, lanes y) {                                                   \
    LAMC_FOR_LANES x[k] = name(x[k], y[k]);                                                                  \
    return x;                                                                                                \
  }

LAMC_LANE_BY_LANE(sqrt)
LAMC_LANE_BY_LANE(tan)
LAMC_LANE_BY_LANE(asin)
LAMC_LANE_BY_LANE(acos)
LAMC_LANE_BY_LANE(atan)
LAMC_LANE_BY_LANE(sinh)
LAMC_LANE_BY_LANE(cosh)
LAMC_LANE_BY_LANE(tanh)
LAMC_LANE_BY_LANE(exp)
LAMC_LANE_BY_LANE(log)
LAMC_LANE_BY_LANE_OF_TWO(atan2)
LAMC_LANE_BY_LANE_OF_TWO(fmin)
LAMC_LANE_BY_LANE_OF_TWO(fmax)
LAMC_LANE_BY_LANE_OF_TWO(pow)

/* -1, 0 or 1 */
LAMC_LANE_FUNCTION lanes lane_sign(lanes x) {
  LAMC_FOR_LANES x[k] = (x[k] > 0) - (x[k] < 0);
  return x;
}

#endif /* LAMC_LANE_NUMBERS_H */
