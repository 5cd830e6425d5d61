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

#if defined(LAMC_LANES) /* two, four, or what the machine has room for */
#elif defined(__AVX512F__)
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
#define LAMC_ONCE __attribute__((unused, noinline)) /* what is long: once in the cache of instructions */
#define LAMC_LANE_FUNCTION static inline __attribute__((unused, always_inline))

typedef double lanes __attribute__((vector_size(8 * LAMC_LANES), may_alias));
typedef int64_t lane_bits __attribute__((vector_size(8 * LAMC_LANES), may_alias));

#if defined(__has_builtin)
#if LAMC_LANES == 8 && !defined(__clang__) && __has_builtin(__builtin_ia32_blendmpd_512_mask) &&             \
    __has_builtin(__builtin_ia32_cmppd512_mask) && __has_builtin(__builtin_ia32_cmpq512_mask)
#define LAMC_MASK_REGISTERS
#endif
#if defined(LAMC_MASK_REGISTERS) && __has_builtin(__builtin_ia32_sqrtpd512_mask)
#define LAMC_ROOTS_OF_EIGHT
#elif LAMC_LANES == 4 && __has_builtin(__builtin_ia32_sqrtpd256)
#define LAMC_ROOTS_OF_FOUR
#endif
#if __has_builtin(__builtin_shufflevector)
#define LAMC_JOIN                                                                                            \
  __builtin_shufflevector /* lanes of two vectors in a new order, those of the second numbered on */
typedef double lane_pair __attribute__((vector_size(16), may_alias));
typedef double lane_quad __attribute__((vector_size(32), may_alias));
#endif
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

/* ---- Comparisons ------------------------------------------------------------------------------------------- */

/* What holds in which lanes. gcc finds the registers that AVX-512 has for it only where it is told of them, which saves
 * small loops a fifth of the time; clang does by itself. */
#ifdef LAMC_MASK_REGISTERS
typedef unsigned char lane_mask; /* a bit for each lane */
typedef long long lane_longs __attribute__((vector_size(64), may_alias));
#define LAMC_COMPARED(a, b, how) ((lane_mask)__builtin_ia32_cmppd512_mask(a, b, how, (lane_mask) - 1, 4))

LAMC_LANE_FUNCTION lane_mask lane_less(lanes a, lanes b) {
  return LAMC_COMPARED(a, b, 0x11);
}

LAMC_LANE_FUNCTION lane_mask lane_at_most(lanes a, lanes b) {
  return LAMC_COMPARED(a, b, 0x12);
}

LAMC_LANE_FUNCTION lane_mask lane_same(lanes a, lanes b) {
  return LAMC_COMPARED(a, b, 0x00);
}

LAMC_LANE_FUNCTION lane_mask lane_is(lane_bits a, int64_t b) {
  return (lane_mask)__builtin_ia32_cmpq512_mask((lane_longs)a, (lane_longs)(a * 0 + b), 0, (lane_mask)-1);
}

LAMC_LANE_FUNCTION lane_mask lane_not(lane_mask is) {
  return (lane_mask)~is;
}

LAMC_LANE_FUNCTION lanes lane_pick(lane_mask is, lanes a, lanes b) {
  return (lanes)__builtin_ia32_blendmpd_512_mask(b, a, is);
}

LAMC_LANE_FUNCTION int lane_some(lane_mask is) {
  return is != 0;
}

LAMC_LANE_FUNCTION int lane_has(lane_mask is, int k) {
  return is >> k & 1;
}

LAMC_LANE_FUNCTION void lane_add(lane_mask *is, int k) {
  *is = (lane_mask)(*is | 1 << k);
}
#else
typedef lane_bits lane_mask; /* all bits of a lane, or none */

LAMC_LANE_FUNCTION lane_mask lane_less(lanes a, lanes b) {
  return (lane_mask)(a < b);
}

LAMC_LANE_FUNCTION lane_mask lane_at_most(lanes a, lanes b) {
  return (lane_mask)(a <= b);
}

LAMC_LANE_FUNCTION lane_mask lane_same(lanes a, lanes b) {
  return (lane_mask)(a == b);
}

LAMC_LANE_FUNCTION lane_mask lane_is(lane_bits a, int64_t b) {
  return (lane_mask)(a == b);
}

LAMC_LANE_FUNCTION lane_mask lane_not(lane_mask is) {
  return ~is;
}

/* is ? a : b */
LAMC_LANE_FUNCTION lanes lane_pick(lane_mask is, lanes a, lanes b) {
  return (lanes)((is & (lane_bits)a) | (~is & (lane_bits)b));
}

LAMC_LANE_FUNCTION int lane_some(lane_mask is) {
  return lane_any(is);
}

LAMC_LANE_FUNCTION int lane_has(lane_mask is, int k) {
  return is[k] != 0;
}

LAMC_LANE_FUNCTION void lane_add(lane_mask *is, int k) {
  (*is)[k] = -1;
}
#endif

/* a > b ? a : b, as `larger` of method.h has it */
LAMC_LANE_FUNCTION lanes lane_larger(lanes a, lanes b) {
  return lane_pick(lane_less(b, a), a, b);
}

/* ---- Sine and cosine: those of trig_double.h, term by term --------------------------------------------------- */

#ifdef LAMC_TRIG_TO_WHOLE
/* The two parts of the rows at `at` (bytes) + shift of the table, in each lane: pairs are loaded whole and sorted then */
LAMC_LANE_FUNCTION void lane_rows(const int64_t *at, int shift, lanes *first, lanes *second) {
#define ROW(k) ((const double *)(const void *)((const char *)LAMC_TRIG_SINES[shift] + at[k]))
#if LAMC_LANES > 2 && defined(LAMC_JOIN)
#define PAIR(k) (*(const lane_pair *)ROW(k))
  const lane_quad a = LAMC_JOIN(PAIR(0), PAIR(1), 0, 1, 2, 3), b = LAMC_JOIN(PAIR(2), PAIR(3), 0, 1, 2, 3);
#if LAMC_LANES == 8
  const lane_quad c = LAMC_JOIN(PAIR(4), PAIR(5), 0, 1, 2, 3), d = LAMC_JOIN(PAIR(6), PAIR(7), 0, 1, 2, 3);
  const lanes one = LAMC_JOIN(a, b, 0, 1, 2, 3, 4, 5, 6, 7), two = LAMC_JOIN(c, d, 0, 1, 2, 3, 4, 5, 6, 7);
  *first = LAMC_JOIN(one, two, 0, 2, 4, 6, 8, 10, 12, 14);
  *second = LAMC_JOIN(one, two, 1, 3, 5, 7, 9, 11, 13, 15);
#else
  *first = LAMC_JOIN(a, b, 0, 2, 4, 6);
  *second = LAMC_JOIN(a, b, 1, 3, 5, 7);
#endif
#undef PAIR
#else
  LAMC_FOR_LANES {
    (*first)[k] = ROW(k)[0];
    (*second)[k] = ROW(k)[1];
  }
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
  lane_bits offsets = n * 16;  /* bytes of a row */
  __asm__("" : "+m"(offsets)); /* through memory: to take eight numbers out of a register is slower */
  int64_t at[LAMC_LANES];
  memcpy(at, &offsets, sizeof at);
  lane_rows(at, 0, &s0, &s1);
  lane_rows(at, 32, &c0, &c1);
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

static LAMC_ONCE void lane_turn_two(lanes x0, lanes x1, lanes *sines, lanes *cosines) {
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

/* Rounded as the library's, by any instruction; told of errno, gcc takes one lane after the other. */
LAMC_LANE_FUNCTION lanes lane_sqrt(lanes x) {
#if defined(LAMC_ROOTS_OF_EIGHT)
  return __builtin_ia32_sqrtpd512_mask(x, x, -1, 4);
#elif defined(LAMC_ROOTS_OF_FOUR)
  return __builtin_ia32_sqrtpd256(x);
#else
  LAMC_FOR_LANES x[k] = sqrt(x[k]);
  return x;
#endif
}

/* -1, 0 or 1 */
LAMC_LANE_FUNCTION lanes lane_sign(lanes x) {
  LAMC_FOR_LANES x[k] = (x[k] > 0) - (x[k] < 0);
  return x;
}

#endif /* LAMC_LANE_NUMBERS_H */
