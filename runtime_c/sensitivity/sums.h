/* sums.h, of lamc: weighted sums of slopes, as stages of Runge-Kutta methods take them.
 *
 * In: vectors of whole packs. Out: their sum, term after term. Never: knows what they are of. */
#ifndef LAMC_SUMS_H
#define LAMC_SUMS_H

#include "packs.h"

/* out += weight times v, of (count,), whole packs */
static inline void lamc_add_weighted(ptrdiff_t count, lamc_real weight, const lamc_real *LAMC_RESTRICT v,
                                     lamc_real *LAMC_RESTRICT out) {
  for (ptrdiff_t b = 0; b < count; b += PACK)
    lamc_pack_put(out + b, lamc_pack_add(lamc_pack_at(out + b), weight, lamc_pack_at(v + b)));
}

enum { PACKS_AT_ONCE = 6, TERMS_AT_MOST = 16 };

/* out = from + sum of weight times used, of `packs` packs from b on: their sums stay in registers */
LAMC_PACK_FUNCTION void lamc_sum_packs(const int packs, ptrdiff_t b, const lamc_real *from, int terms,
                                       const lamc_real *weight, const lamc_real *const *used,
                                       lamc_real *out) {
  lamc_pack sum[PACKS_AT_ONCE];
  for (int i = 0; i < packs; i++) sum[i] = lamc_pack_at(from + b + i * PACK);
  for (int j = 0; j < terms; j++)
    for (int i = 0; i < packs; i++)
      sum[i] = lamc_pack_add(sum[i], weight[j], lamc_pack_at(used[j] + b + i * PACK));
  for (int i = 0; i < packs; i++) lamc_pack_put(out + b + i * PACK, sum[i]);
}

/* out = from + sum over terms of weight times used; of (size,), whole packs, each */
static inline void lamc_sum_terms(ptrdiff_t size, const lamc_real *from, int terms, const lamc_real *weight,
                                  const lamc_real *const *used, lamc_real *out) {
  ptrdiff_t b = 0;
  for (; b + PACKS_AT_ONCE * PACK <= size; b += PACKS_AT_ONCE * PACK)
    lamc_sum_packs(PACKS_AT_ONCE, b, from, terms, weight, used, out);
  for (; b + 2 * PACK <= size; b += 2 * PACK) lamc_sum_packs(2, b, from, terms, weight, used, out);
  for (; b < size; b += PACK) lamc_sum_packs(1, b, from, terms, weight, used, out);
}

/* out = from + sum over the first `count` slopes of h weight times slope; of (size,), whole packs, each */
static inline void lamc_weighted_sum(ptrdiff_t size, const lamc_real *from, lamc_real h, int count,
                                     const lamc_real *weights, const lamc_real *slopes, lamc_real *out) {
  const lamc_real *used[TERMS_AT_MOST];
  lamc_real weight[TERMS_AT_MOST];
  int terms = 0;
  for (int j = 0; j < count; j++) {
    if (weights[j] == 0) continue;
    used[terms] = slopes + j * size;
    weight[terms++] = h * weights[j];
  }
  lamc_sum_terms(size, from, terms, weight, used, out);
}

#endif /* LAMC_SUMS_H */
