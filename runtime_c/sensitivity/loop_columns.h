/* loop_columns.h, of lamc: lamc_loops_response for several right-hand sides, a pack of them at a time.
 *
 * In:    loops as an acceleration left them, whose J was eliminated as one array and whose M is written down. Out: x of
 *        M x = force + J^T ..., J x + goal = 0, by columns.
 * Never: adds in another order than loop_dense.h and loop_equations.h do for one. */
#ifndef LAMC_LOOP_COLUMNS_H
#define LAMC_LOOP_COLUMNS_H

#include "loop_equations.h"
#include "loop_work.h"
#include "packs.h"

static inline int lamc_has_loop_columns(const lamc_loop_parts *p) {
  return p->has_mass && !p->is_sparse;
}

/* Numbers of scratch */
static inline long long lamc_loop_columns_size(const lamc_model *model) {
  return 3LL * PACK * model->rate_count;
}

LAMC_PACK_FUNCTION lamc_real *lamc_pack_in(lamc_real *packs, int i) {
  return packs + (ptrdiff_t)PACK * i;
}

/* x with the taken equations at -goal and nothing along the free rates; goals: rows of `width` */
LAMC_PACK_FUNCTION void lamc_impose_pack(const lamc_loop_parts *p, const int n, const int count,
                                         const lamc_real *goals, int width, lamc_real *y, lamc_real *x) {
  const lamc_real none[PACK] = {0};
  LAMC_UNROLL
  for (int i = 0; i < n; i++) lamc_pack_put(lamc_pack_in(x, i), lamc_pack_at(none));
  LAMC_UNROLL
  for (int k = 0; k < count; k++) {
    const int row = (int)p->rows[k];
    const lamc_real scale = p->norms[row] > 0 ? -1 / p->norms[row] : 0;
    lamc_pack sum = lamc_pack_times(scale, lamc_pack_at(goals + (ptrdiff_t)row * width));
    LAMC_UNROLL
    for (int i = 0; i < k; i++)
      sum = lamc_pack_add(sum, -p->a[(ptrdiff_t)k * n + i], lamc_pack_at(lamc_pack_in(y, i)));
    lamc_pack_put(lamc_pack_in(y, k), sum);
  }
  LAMC_UNROLL
  for (int k = count - 1; k >= 0; k--) {
    lamc_pack sum = lamc_pack_at(lamc_pack_in(y, k));
    LAMC_UNROLL
    for (int i = k + 1; i < count; i++)
      sum = lamc_pack_add(sum, -p->a[(ptrdiff_t)k * n + i], lamc_pack_at(lamc_pack_in(y, i)));
    sum = lamc_pack_times(p->inverse[k], sum);
    lamc_pack_put(lamc_pack_in(y, k), sum);
    lamc_pack_put(lamc_pack_in(x, (int)p->columns[k]), sum);
  }
}

/* z = force - M x; force: rows of `width` */
LAMC_PACK_FUNCTION void lamc_remain_pack(const lamc_loop_parts *p, const int n, const lamc_real *force,
                                         int width, const lamc_real *x, lamc_real *z) {
  LAMC_UNROLL
  for (int i = 0; i < n; i++) lamc_pack_put(lamc_pack_in(z, i), lamc_pack_at(force + (ptrdiff_t)i * width));
  LAMC_UNROLL
  for (int i = 0; i < n; i++) {
    const lamc_real *row = p->mass + i * (i + 1) / 2;
    if (i >= p->cut && i < p->beyond) continue;
    const lamc_pack xi = lamc_pack_at(x + (ptrdiff_t)PACK * i);
    lamc_pack sum = lamc_pack_add(lamc_pack_at(lamc_pack_in(z, i)), -row[i], xi);
    LAMC_UNROLL
    for (int k = 0; k < i; k++) {
      sum = lamc_pack_add(sum, -row[k], lamc_pack_at(x + (ptrdiff_t)PACK * k));
      lamc_pack_put(lamc_pack_in(z, k), lamc_pack_add(lamc_pack_at(lamc_pack_in(z, k)), -row[k], xi));
    }
    lamc_pack_put(lamc_pack_in(z, i), sum);
  }
}

/* x += N (N^T M N)^-1 N^T z */
LAMC_PACK_FUNCTION void lamc_free_pack(const lamc_loop_parts *p, const int n, const int count,
                                       const lamc_real *z, lamc_real *found, lamc_real *x) {
  const int free = n - count;
  const lamc_real none[PACK] = {0};
  LAMC_UNROLL
  for (int a = 0; a < free; a++) {
    const lamc_real *direction = p->free + (ptrdiff_t)a * n;
    lamc_pack sum = lamc_pack_at(none);
    LAMC_UNROLL
    for (int i = 0; i < n; i++) sum = lamc_pack_add(sum, direction[i], lamc_pack_at(z + (ptrdiff_t)PACK * i));
    lamc_pack_put(lamc_pack_in(found, a), sum);
  }
  lamc_solve_columns(free, p->l, PACK, found);
  LAMC_UNROLL
  for (int i = 0; i < n; i++) {
    lamc_pack sum = lamc_pack_at(lamc_pack_in(x, i));
    LAMC_UNROLL
    for (int a = 0; a < free; a++)
      sum = lamc_pack_add(sum, p->free[(ptrdiff_t)a * n + i], lamc_pack_at(lamc_pack_in(found, a)));
    lamc_pack_put(lamc_pack_in(x, i), sum);
  }
}

/* rows (n, width), forces, replaced by x; goals (m, width); scratch: lamc_loop_columns_size. Numbers that a compiler knows make
 * straight code */
LAMC_PACK_FUNCTION void lamc_loop_columns_of(const int n, const int count, const lamc_loop_parts *p,
                                             int width, const lamc_real *goals, lamc_real *rows,
                                             lamc_real *scratch) {
  lamc_real *x = scratch, *z = lamc_pack_in(x, n), *y = lamc_pack_in(z, n);
  for (int b = 0; b < width; b += PACK) {
    lamc_impose_pack(p, n, count, goals + b, width, y, x);
    lamc_remain_pack(p, n, rows + b, width, x, z);
    lamc_free_pack(p, n, count, z, y, x);
    for (int i = 0; i < n; i++)
      lamc_pack_put(rows + (ptrdiff_t)i * width + b, lamc_pack_at(lamc_pack_in(x, i)));
  }
}

#endif /* LAMC_LOOP_COLUMNS_H */
