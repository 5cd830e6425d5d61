/* directions.h, of lamc: derivatives of the residuals along columns of S, where they are not known by each component of the
 * state.
 *
 * In: a place, S. Out: what moves S there. Never: evaluates the motion. */
#ifndef LAMC_DIRECTIONS_H
#define LAMC_DIRECTIONS_H

#include "lamc_sensitivity.h"

#include "memory.h"
#include "packs.h"
#include "side_by_side.h"

/* Counts of a model, and where its parts lie in scratch */
typedef struct variation {
  int nq, nu, m, n, k, width;
  int by_state;               /* columns by q and u of the residuals: n or 0 */
  int held_count, held_width; /* what clocks hold, and the width of its derivatives */
  const lamc_real *held;
  lamc_real *udot, *lambda, *derivative, *x, *goal, *goals, *packs, *closure;
} variation;

/* out (width,) -= value times row */
static inline void lamc_row_less(int width, lamc_real value, const lamc_real *LAMC_RESTRICT row,
                                 lamc_real *LAMC_RESTRICT out) {
  for (int b = 0; b < width; b += PACK)
    lamc_pack_put(out + b, lamc_pack_add(lamc_pack_at(out + b), -value, lamc_pack_at(row + b)));
}

static inline void lamc_row_scale(int width, lamc_real value, lamc_real *out) {
  for (int b = 0; b < width; b += PACK) lamc_pack_put(out + b, lamc_pack_times(value, lamc_pack_at(out + b)));
}

/* rows (nu, width) less derivatives of the residuals along columns of S, goals (m, width) plus those of the loops; a pack of
 * columns at a time */
static inline void lamc_vary_packs(lamc_sensitivity *s, const variation *v, const lamc_place *at,
                                   const lamc_real *sens, lamc_real *rows) {
  const lamc_model *model = s->motion.model;
  lamc_real *directions = s->lanes[LANE_DIRECTIONS];
  lamc_spread_constants(s);
  for (int k = 0; k < PACK; k++) lamc_put_place(model, PACK, at, s->lanes[LANE_PLACES] + k);
  for (int b = 0; b < v->width; b += PACK) {
    for (int j = 0; j < v->n; j++)
      lamc_pack_put(directions + (ptrdiff_t)j * PACK, lamc_pack_at(sens + (ptrdiff_t)j * v->width + b));
    s->tangents->directions(s->lanes[LANE_CONSTANTS], s->lanes[LANE_PLACES], directions,
                            s->lanes[LANE_ALONG]);
    const lamc_real *found = s->lanes[LANE_ALONG];
    for (int i = 0; i < v->nu; i++, found += PACK)
      lamc_row_less(PACK, 1, found, rows + (ptrdiff_t)i * v->width + b);
    for (int i = 0; i < v->m; i++, found += PACK)
      lamc_row_less(PACK, -1, found, v->goals + (ptrdiff_t)i * v->width + b);
  }
}

/* The same, a column at a time */
static inline void lamc_vary_columns(lamc_sensitivity *s, const variation *v, const lamc_place *at,
                                     const lamc_real *sens, lamc_real *rows) {
  lamc_real *direction = s->lanes[LANE_DIRECTIONS], *along = s->lanes[LANE_ALONG];
  for (int c = 0; c < s->column_count; c++) {
    for (int j = 0; j < v->n; j++) direction[j] = sens[(ptrdiff_t)j * v->width + c];
    s->tangents->directional(s->beside.constants, at->t, at->y, at->y + v->nq, at->udot, at->lambda,
                             direction, along);
    for (int i = 0; i < v->nu; i++) rows[(ptrdiff_t)i * v->width + c] -= along[i];
    for (int i = 0; i < v->m; i++) v->goals[(ptrdiff_t)i * v->width + c] += along[v->nu + i];
  }
}

static inline void lamc_vary_directions(lamc_sensitivity *s, const variation *v, const lamc_place *at,
                                        const lamc_real *sens, lamc_real *rows) {
  if (s->tangents->directions != NULL)
    lamc_vary_packs(s, v, at, sens, rows);
  else
    lamc_vary_columns(s, v, at, sens, rows);
}

#endif /* LAMC_DIRECTIONS_H */
