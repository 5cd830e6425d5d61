/* side_by_side.h, of lamc: the memory of what a model's derivatives work out in several lanes at once.
 *
 * In: constants of a motion, places. Out: the same in lanes. Never: evaluates anything. */
#ifndef LAMC_SIDE_BY_SIDE_H
#define LAMC_SIDE_BY_SIDE_H

#include "memory.h"
#include "packs.h"

enum { STAGES_AT_MOST = 16, ALIGNED = 64 };

/* Parts of the memory: what lies in lanes, and residuals of many places */
enum { LANE_CONSTANTS, LANE_PLACES, LANE_DIRECTIONS, LANE_ALONG, LANE_RESIDUALS, LANE_PARTS };

/* Numbers of a place: t, q, u, udot, lambda */
static inline ptrdiff_t lamc_place_size(const lamc_model *model) {
  return 1 + model->coordinate_count + 2 * (ptrdiff_t)model->rate_count + model->closure_count;
}

/* Numbers that lamc_tangents.side_by_side leaves for a place */
static inline ptrdiff_t lamc_residuals_size(const lamc_model *model, const lamc_tangents *tangents) {
  const ptrdiff_t nu = model->rate_count, across = tangents->state_columns + tangents->column_count;
  return (nu + model->closure_count) * across + (model->acceleration != NULL ? nu * (nu + 1) / 2 : 0);
}

/* Lays them out; returns how many numbers they take */
static inline long long lamc_lay_side_by_side(const lamc_model *model, const lamc_tangents *tangents,
                                              lamc_real *room, lamc_real **parts) {
  const long long lanes = tangents->lanes > 0 ? tangents->lanes : 1, nu = model->rate_count;
  const long long stages = tangents->side_by_side != NULL ? (STAGES_AT_MOST + lanes - 1) / lanes * lanes : 0;
  const long long sizes[] = {lanes * model->constant_count, lanes * lamc_place_size(model),
                             lanes * (model->coordinate_count + nu), lanes * (nu + model->closure_count),
                             stages * lamc_residuals_size(model, tangents)};
  const long long whole = ALIGNED / (long long)sizeof(lamc_real);
  long long at = 0;
  if (room != NULL) room += (ALIGNED - (uintptr_t)room % ALIGNED) % ALIGNED / sizeof(lamc_real);
  for (int i = 0; i < LANE_PARTS; i++) {
    if (parts != NULL) parts[i] = room + at;
    at += (sizes[i] + whole - 1) / whole * whole;
  }
  return at + whole;
}

/* The constants as they are now, in every lane */
static inline void lamc_spread_constants(lamc_sensitivity *s) {
  const lamc_model *model = s->motion.model;
  const int lanes = s->tangents->lanes, count = model->constant_count;
  if (!s->has_new_constants && model->series_count == 0) return;
  lamc_real *constants = s->lanes[LANE_CONSTANTS];
  for (int i = 0; i < count; i++)
    for (int k = 0; k < lanes; k++) constants[(ptrdiff_t)i * lanes + k] = s->beside.constants[i];
  s->has_new_constants = 0;
}

static inline void lamc_put_lane(int lanes, ptrdiff_t count, const lamc_real *from, lamc_real *to) {
  for (ptrdiff_t i = 0; i < count; i++) to[i * lanes] = from[i];
}

/* A place, into the lane that `to` begins */
static inline void lamc_put_place(const lamc_model *model, int lanes, const lamc_place *place,
                                  lamc_real *to) {
  const ptrdiff_t n = (ptrdiff_t)model->coordinate_count + model->rate_count;
  to[0] = place->t;
  lamc_put_lane(lanes, n, place->y, to + lanes);
  lamc_put_lane(lanes, model->rate_count, place->udot, to + (1 + n) * lanes);
  lamc_put_lane(lanes, model->closure_count, place->lambda, to + (1 + n + model->rate_count) * lanes);
}

#endif /* LAMC_SIDE_BY_SIDE_H */
