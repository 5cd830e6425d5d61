/* ahead.h, of lamc: the residuals' derivatives at the stages of a step, several stages side by side.
 *
 * In: a step of an explicit method that was accepted. Out: what lamc_tangents.residuals gives at each of its stages; they do
 * not depend on S, so that none waits for another. Never: evaluates the motion; knows S. */
#ifndef LAMC_AHEAD_H
#define LAMC_AHEAD_H

#include "memory.h"
#include "side_by_side.h"
#include "sums.h"
#include "tableau.h"
#include "variation.h"

/* 1 if stages are looked at side by side */
static inline int lamc_looks_ahead(const lamc_model *model, const lamc_tangents *tangents) {
  return tangents->side_by_side != NULL && (lamc_is_plain(model) || lamc_has_factors(model));
}

/* dy/dt of the run at a stage of its last step */
static inline const lamc_real *lamc_run_slope(const lamc_run *run, const tableau *a, int stage) {
  if (stage == 0) return slope_there(run);
  if (stage == a->last) return slope_here(run);
  return slot(run, SLOT_OWN + (stage < a->last ? stage - 1 : stage - 2));
}

static inline lamc_real lamc_stage_time(const lamc_run *run, const tableau *a, int stage) {
  return stage == a->last ? run->t : run->t_old + a->node[stage] * run->h_last;
}

/* The state at a stage, from slopes: (n,), and what fills the last block of `padded` */
static inline void lamc_stage_state(const lamc_run *run, const tableau *a, int stage, lamc_real *y) {
  const lamc_real *used[TERMS_AT_MOST] = {slope_there(run)},
                  *weights = a->weight + (ptrdiff_t)stage * a->across;
  lamc_real weight[TERMS_AT_MOST];
  int terms = 0;
  if (stage == a->last) {
    memcpy(y, y_here(run), (size_t)run->ode.n * sizeof *y);
    return;
  }
  for (int j = 0; j < stage && j < a->across; j++) {
    if (weights[j] == 0) continue;
    used[terms] = lamc_run_slope(run, a, j);
    weight[terms++] = run->h_last * weights[j];
  }
  lamc_sum_terms(padded(run->ode.n), y_there(run), terms, weight, used, y);
}

/* Where a stage was evaluated, with all that derivatives take. y: (n,) of scratch. 0: it is not remembered */
static inline int lamc_known_place(lamc_sensitivity *s, const tableau *a, int stage, lamc_real *y,
                                   lamc_place *place) {
  const lamc_run *run = &s->run;
  const lamc_real *slope = lamc_run_slope(run, a, stage);
  const lamc_real t = lamc_stage_time(run, a, stage);
  if (lamc_recall(s, t, slope, place)) return 1;
  if (!lamc_is_plain(s->motion.model)) return 0;
  lamc_stage_state(run, a, stage, y);
  place->t = t;
  place->y = y;
  place->udot = slope + s->motion.model->coordinate_count;
  place->lambda = NULL;
  place->count = 0;
  place->work = NULL;
  return 1;
}

/* Works out the residuals of the stages first <= stage < beyond of the last step. 0: they are to be had one by one.
 * y: (n,) of scratch */
static inline int lamc_look_ahead(lamc_sensitivity *s, const tableau *a, int first, int beyond,
                                  lamc_real *y) {
  const lamc_model *model = s->motion.model;
  const int lanes = s->tangents->lanes;
  s->ahead_first = s->ahead_beyond = first;
  if (!lamc_looks_ahead(model, s->tangents)) return 0;
  lamc_spread_constants(s);
  lamc_real *residuals = s->lanes[LANE_RESIDUALS];
  for (int begin = first; begin < beyond; begin += lanes) {
    for (int k = 0; k < lanes; k++) { /* lanes that are left over take the last stage once more */
      const int stage = begin + k < beyond ? begin + k : beyond - 1;
      lamc_place place;
      if (!lamc_known_place(s, a, stage, y, &place)) return 0;
      lamc_put_place(model, lanes, &place, s->lanes[LANE_PLACES] + k);
      s->ahead_entry[stage] = s->recalled;
    }
    s->tangents->side_by_side(s->lanes[LANE_CONSTANTS], s->lanes[LANE_PLACES], residuals);
    residuals += lanes * lamc_residuals_size(model, s->tangents);
  }
  s->evaluations += beyond - first;
  s->ahead_beyond = beyond;
  return 1;
}

/* dS/dt at a stage that was looked at, with derivatives sens (n, width); y: (n,) of scratch */
static inline void lamc_vary_ahead(lamc_sensitivity *s, const tableau *a, int stage, const lamc_real *sens,
                                   lamc_real *y, lamc_real *slope) {
  const lamc_model *model = s->motion.model;
  const int lanes = s->tangents->lanes, index = stage - s->ahead_first;
  const ptrdiff_t size = lamc_residuals_size(model, s->tangents);
  lamc_place place = {0};
  if (!lamc_is_plain(model)) {
    place = lamc_remembered(s, s->ahead_entry[stage]);
  } else if (s->tangents->state_columns == 0) {
    (void)lamc_known_place(s, a, stage, y, &place);
  }
  variation v = lamc_variation_of(s);
  v.derivative = s->lanes[LANE_RESIDUALS] + index / lanes * lanes * size + index % lanes;
  lamc_vary_by(s, &v, &place, s->tangents->along_lane, sens, slope);
}

#endif /* LAMC_AHEAD_H */
