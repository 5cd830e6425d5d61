/* packs.h, of lamc: two or four numbers as one, in a register where the compiler has vectors (gcc, clang), else as an
 * array. */
#ifndef LAMC_PACKS_H
#define LAMC_PACKS_H

#include "lamc_real.h"

#include <stddef.h>

#if defined(__GNUC__) && !defined(__AVX__)
enum { PACK = 2 };
#else
enum { PACK = 4 };
#endif

#ifdef __GNUC__
#define LAMC_PACK_FUNCTION static inline __attribute__((always_inline))
#ifdef __clang__
#define LAMC_UNROLL _Pragma("clang loop unroll(full)")
#else
#define LAMC_UNROLL _Pragma("GCC unroll 10")
#endif

typedef lamc_real lamc_pack __attribute__((vector_size(PACK * sizeof(lamc_real))));
/* The same anywhere in memory */
typedef lamc_real lamc_pack_there
    __attribute__((vector_size(PACK * sizeof(lamc_real)), aligned(sizeof(lamc_real)), may_alias));

LAMC_PACK_FUNCTION lamc_pack lamc_pack_at(const lamc_real *p) {
  return *(const lamc_pack_there *)p;
}

LAMC_PACK_FUNCTION void lamc_pack_put(lamc_real *p, lamc_pack x) {
  *(lamc_pack_there *)p = x;
}

/* x + a y */
LAMC_PACK_FUNCTION lamc_pack lamc_pack_add(lamc_pack x, lamc_real a, lamc_pack y) {
  return x + a * y;
}

LAMC_PACK_FUNCTION lamc_pack lamc_pack_times(lamc_real a, lamc_pack x) {
  return a * x;
}

/* x + y y */
LAMC_PACK_FUNCTION lamc_pack lamc_pack_add_square(lamc_pack x, lamc_pack y) {
  return x + y * y;
}
#else
#define LAMC_PACK_FUNCTION static inline
#define LAMC_UNROLL

typedef struct lamc_pack {
  lamc_real x[PACK];
} lamc_pack;

static inline lamc_pack lamc_pack_at(const lamc_real *p) {
  lamc_pack r;
  for (int i = 0; i < PACK; i++) r.x[i] = p[i];
  return r;
}

static inline void lamc_pack_put(lamc_real *p, lamc_pack x) {
  for (int i = 0; i < PACK; i++) p[i] = x.x[i];
}

static inline lamc_pack lamc_pack_add(lamc_pack x, lamc_real a, lamc_pack y) {
  for (int i = 0; i < PACK; i++) x.x[i] += a * y.x[i];
  return x;
}

static inline lamc_pack lamc_pack_times(lamc_real a, lamc_pack x) {
  for (int i = 0; i < PACK; i++) x.x[i] *= a;
  return x;
}

static inline lamc_pack lamc_pack_add_square(lamc_pack x, lamc_pack y) {
  for (int i = 0; i < PACK; i++) x.x[i] += y.x[i] * y.x[i];
  return x;
}
#endif

/* rows (n, width) replaced by M^-1 of them, of M = L L^T as lamc_cholesky leaves it: all columns at once */
LAMC_PACK_FUNCTION void lamc_solve_columns(const int n, const lamc_real *l, int width, lamc_real *rows) {
  for (int b = 0; b < width; b += PACK) {
    lamc_real *columns = rows + b;
    LAMC_UNROLL
    for (int i = 0; i < n; i++) {
      const lamc_real *li = l + (ptrdiff_t)i * n;
      lamc_pack sum = lamc_pack_at(columns + (ptrdiff_t)i * width);
      LAMC_UNROLL
      for (int j = 0; j < i; j++)
        sum = lamc_pack_add(sum, -li[j], lamc_pack_at(columns + (ptrdiff_t)j * width));
      lamc_pack_put(columns + (ptrdiff_t)i * width, lamc_pack_times(li[i], sum));
    }
    LAMC_UNROLL
    for (int i = n - 1; i >= 0; i--) {
      lamc_pack sum = lamc_pack_at(columns + (ptrdiff_t)i * width);
      LAMC_UNROLL
      for (int j = i + 1; j < n; j++)
        sum = lamc_pack_add(sum, -l[(ptrdiff_t)j * n + i], lamc_pack_at(columns + (ptrdiff_t)j * width));
      lamc_pack_put(columns + (ptrdiff_t)i * width, lamc_pack_times(l[(ptrdiff_t)i * n + i], sum));
    }
  }
}

#endif /* LAMC_PACKS_H */
