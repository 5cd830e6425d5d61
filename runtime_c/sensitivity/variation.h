/* variation.h, of lamc: dS/dt = f_y S + f_p at a state, and S brought to what holds for the state.
 *
 * In the residual form, as in linearise.c: M d(udot) = J^T d(lambda) - dr, J d(udot) = -dc, with r and c differentiated at
 * constant udot and lambda along every column at once. */
#ifndef LAMC_VARIATION_H
#define LAMC_VARIATION_H

#include "lamc_sensitivity.h"

#include "directions.h"
#include "loop_columns.h"
#include "loops.h"
#include "memory.h"
#include "method.h"
#include "motion.h"
#include "packs.h"
#include "series.h"
#include "system.h"

/* 1 if a model gives accelerations as they are: its derivatives are solved with factors of M of their own */
static inline int lamc_is_plain(const lamc_model *model) {
  return model->acceleration != NULL && model->cut_count == 0;
}

/* Columns of S, padded to whole packs */
static inline int lamc_columns_width(int columns) {
  return (columns + PACK - 1) / PACK * PACK;
}

static inline long long lamc_variation_size(const lamc_model *model, int k, int width) {
  const long long nq = model->coordinate_count, nu = model->rate_count, m = model->closure_count, n = nq + nu;
  const long long flow = model->rates == NULL ? 0 : nq * n;
  const long long factors = lamc_is_plain(model) ? nu * (nu + 1) / 2 : 0;
  const long long held = model->held_count, residuals = (nu + m) * (n + k + held) + flow + factors,
                  closure = m * (nq + k + n + k);
  const long long guards = (model->guard_count + held) * (n + 1 + k + held);
  long long most = residuals > closure ? residuals : closure;
  if (guards > most) most = guards;
  return nu + m + most + nu + m + m * width + lamc_loop_columns_size(model) + closure;
}

static inline variation lamc_variation_of(const lamc_sensitivity *s) {
  const lamc_model *model = s->motion.model;
  variation v;
  v.nq = model->coordinate_count;
  v.nu = model->rate_count;
  v.m = model->closure_count;
  v.n = v.nq + v.nu;
  v.k = s->tangents->column_count;
  v.by_state = s->tangents->state_columns;
  v.width = s->width;
  v.held_count = model->held_count;
  v.held_width = s->held_width;
  v.held = s->held;
  v.udot = s->scratch;
  v.lambda = v.udot + v.nu;
  v.x = v.lambda + v.m;
  v.goal = v.x + v.nu;
  v.goals = v.goal + v.m;
  v.packs = v.goals + (ptrdiff_t)v.m * v.width;
  v.closure = v.packs + lamc_loop_columns_size(model);
  v.derivative = v.closure + (ptrdiff_t)v.m * (v.nq + v.k + v.n + v.k);
  return v;
}

/* out (width,) = -(row of derivatives by `count` state components, then by columns) along S, a block of columns at a time */
static inline void lamc_minus_along(const variation *v, int count, const lamc_real *row,
                                    const lamc_real *sens, lamc_real *out) {
  for (int b = 0; b < v->width; b += PACK) {
    lamc_real begin[PACK] = {0};
    for (int c = b; c < v->k && c < b + PACK; c++) begin[c - b] = -row[count + c];
    lamc_pack sum = lamc_pack_at(begin);
    for (int j = 0; j < count; j++)
      sum = lamc_pack_add(sum, -row[j], lamc_pack_at(sens + (ptrdiff_t)j * v->width + b));
    for (int j = 0; j < v->held_count && b < v->held_width; j++)
      sum = lamc_pack_add(sum, -row[count + v->k + j],
                          lamc_pack_at(v->held + (ptrdiff_t)j * v->held_width + b));
    lamc_pack_put(out + b, sum);
  }
}

/* A place of the run's, or one that lies beside it: udot, where it is known, of a model that gives it as it is; NULL: it is
 * worked out */
static inline lamc_place lamc_place_beside(lamc_sensitivity *s, lamc_real t, const lamc_real *y,
                                           const lamc_real *udot) {
  const lamc_model *model = s->motion.model;
  const variation v = lamc_variation_of(s);
  lamc_place place = {t, y, v.udot, v.lambda, 0, s->beside.work};
  if (model->cut_count > 0) {
    place.count = lamc_loops_acceleration(&s->beside, t, y, y + v.nq, v.udot, v.lambda);
  } else if (udot != NULL && lamc_is_plain(model)) {
    place.udot = udot;
  } else {
    lamc_motion_accelerate(&s->beside, t, y, y + v.nq, v.udot);
  }
  return place;
}

/* The motion beside the run, with the factors of a place */
static inline lamc_motion lamc_motion_at(const lamc_sensitivity *s, lamc_real *work) {
  lamc_motion motion = s->beside;
  motion.work = work;
  return motion;
}

/* rows (nu, width) replaced by x of M x = rows + J^T ..., J x + goals = 0, by columns; goals (m, width) */
static inline void lamc_vary_solve_loops(const lamc_tangents *tangents, const lamc_motion *motion,
                                         const variation *v, int count, int columns, lamc_real *rows) {
  lamc_loop_parts p;
  lamc_loop_parts_of(motion, &p);
  if (lamc_has_loop_columns(&p)) {
    if (tangents->loop_columns != NULL)
      tangents->loop_columns(&p, count, v->width, v->goals, rows, v->packs);
    else
      lamc_loop_columns_of(v->nu, count, &p, v->width, v->goals, rows, v->packs);
    return;
  }
  for (int c = 0; c < columns; c++) {
    for (int i = 0; i < v->nu; i++) v->x[i] = rows[(ptrdiff_t)i * v->width + c];
    for (int i = 0; i < v->m; i++) v->goal[i] = v->goals[(ptrdiff_t)i * v->width + c];
    lamc_loops_response(motion, count, v->goal, v->x);
    for (int i = 0; i < v->nu; i++) rows[(ptrdiff_t)i * v->width + c] = v->x[i];
  }
}

/* lamc_tangents.along, or .along_lane */
typedef void (*along_residuals)(const lamc_real *residuals, int width, const lamc_real *sens, lamc_real *rows,
                                lamc_real *goals);

/* rows (nu, width): what moves S, solved already in a plain model; goals: what the loops ask for */
static inline void lamc_vary_along(lamc_sensitivity *s, const variation *v, const lamc_place *at,
                                   along_residuals along, const lamc_real *sens, lamc_real *rows) {
  const int across = v->by_state + v->k + v->held_count;
  memset(rows, 0, (size_t)v->nu * (size_t)v->width * sizeof *rows);
  memset(v->goals, 0, (size_t)v->m * (size_t)v->width * sizeof *rows);
  for (int j = 0; j < v->held_count; j++) {
    const lamc_real *held = v->held + (ptrdiff_t)j * v->held_width,
                    *value = v->derivative + v->by_state + v->k + j;
    const int width = v->width < v->held_width ? v->width : v->held_width;
    for (int i = 0; i < v->nu; i++)
      lamc_row_less(width, value[(ptrdiff_t)i * across], held, rows + (ptrdiff_t)i * v->width);
    for (int i = 0; i < v->m; i++)
      lamc_row_less(width, -value[(ptrdiff_t)(v->nu + i) * across], held, v->goals + (ptrdiff_t)i * v->width);
  }
  if (s->tangents->directional != NULL) lamc_vary_directions(s, v, at, sens, rows);
  along(v->derivative, v->width, sens, rows, v->goals);
}

/* What Baumgarte's stabilisation adds to loops' goals: the derivatives of 2 b J u + b^2 phi along S */
static inline void lamc_vary_stabilise(const lamc_sensitivity *s, const variation *v, const lamc_real *y,
                                       const lamc_real *sens) {
  const lamc_real b = s->beside.baumgarte;
  const int part = v->nq + v->k, across = v->n + v->k;
  s->tangents->closure(s->beside.constants, y, y + v->nq, v->closure);
  for (int i = 0; i < v->m; i++) {
    const lamc_real *gap = v->closure + (ptrdiff_t)i * (part + across), *rate = gap + part;
    lamc_real *goal = v->goals + (ptrdiff_t)i * v->width;
    for (int j = 0; j < v->n; j++) {
      const lamc_real value = 2 * b * rate[j] + (j < v->nq ? b * b * gap[j] : 0);
      if (value != 0) lamc_row_less(v->width, -value, sens + (ptrdiff_t)j * v->width, goal);
    }
    for (int j = 0; j < v->k; j++) goal[j] += 2 * b * rate[v->n + j] + b * b * gap[v->nq + j];
  }
}

/* dS/dt (n, width) at a place with derivatives sens (n, width), from the residuals there in v->derivative */
static inline void lamc_vary_by(lamc_sensitivity *s, const variation *v, const lamc_place *at,
                                along_residuals along, const lamc_real *sens, lamc_real *slope) {
  const lamc_model *model = s->motion.model;
  lamc_real *late = slope + (ptrdiff_t)v->nq * v->width;
  lamc_vary_along(s, v, at, along, sens, late);
  if (s->beside.baumgarte != 0) lamc_vary_stabilise(s, v, at->y, sens);
  if (model->cut_count > 0) {
    const lamc_motion there = lamc_motion_at(s, at->work);
    lamc_vary_solve_loops(s->tangents, &there, v, at->count, s->column_count, late);
  } else if (lamc_is_system(model)) {
    lamc_solve_columns(v->nu, at->work, v->width, late);
  }
  if (model->rates == NULL) {
    memcpy(slope, sens + (ptrdiff_t)v->nq * v->width, (size_t)v->nq * (size_t)v->width * sizeof *slope);
    return;
  }
  const lamc_real *flow = v->derivative + (ptrdiff_t)(v->nu + v->m) * (v->by_state + v->k + v->held_count);
  variation only_state = *v;
  only_state.k = only_state.held_count = 0;
  for (int i = 0; i < v->nq; i++) {
    lamc_real *row = slope + (ptrdiff_t)i * v->width;
    lamc_minus_along(&only_state, v->n, flow + (ptrdiff_t)i * v->n, sens, row);
    lamc_row_scale(v->width, -1, row);
  }
}

/* dS/dt (n, width) at a place with derivatives sens (n, width) */
static inline void lamc_vary(lamc_sensitivity *s, const lamc_place *at, const lamc_real *sens,
                             lamc_real *slope) {
  const variation v = lamc_variation_of(s);
  lamc_series_put(&s->beside, at->t); /* a remembered place may be of an earlier time than the last */
  s->tangents->residuals(s->beside.constants, at->t, at->y, at->y + v.nq, at->udot, at->lambda, v.derivative);
  s->evaluations++;
  lamc_vary_by(s, &v, at, s->tangents->along, sens, slope);
}

/* How the rates in rows (nu, width) move coordinates: added to `out` (nq, width) */
static inline void lamc_vary_move(const lamc_sensitivity *s, const variation *v, const lamc_real *y,
                                  const lamc_real *rows, lamc_real *out) {
  if (s->motion.model->rates == NULL) {
    for (ptrdiff_t i = 0; i < (ptrdiff_t)v->nu * v->width; i++) out[i] += rows[i];
    return;
  }
  for (int c = 0; c < s->column_count; c++) {
    for (int i = 0; i < v->nu; i++) v->x[i] = rows[(ptrdiff_t)i * v->width + c];
    lamc_motion_rates(&s->beside, y, v->x, v->derivative);
    for (int i = 0; i < v->nq; i++) out[(ptrdiff_t)i * v->width + c] += v->derivative[i];
  }
}

/* S (n, width) brought to what closure asks for at a place: J dq + phi_p = 0, and the same of its rates, by the smallest
 * move in the mass metric. rows: (nu, width) of scratch */
static inline void lamc_vary_settle_at(lamc_sensitivity *s, const lamc_place *at, lamc_real *sens,
                                       lamc_real *rows) {
  variation v = lamc_variation_of(s);
  v.held_count = 0; /* closure knows nothing of it */
  const int part = v.nq + v.k, across = part + v.n + v.k;
  const lamc_motion there = lamc_motion_at(s, at->work);
  const lamc_real *y = at->y;
  lamc_real *late = sens + (ptrdiff_t)v.nq * v.width;
  s->tangents->closure(s->beside.constants, y, y + v.nq, v.closure);
  for (int level = 0; level < 2; level++) {
    for (int i = 0; i < v.m; i++) {
      const lamc_real *row = v.closure + (ptrdiff_t)i * across + (level == 0 ? 0 : part);
      lamc_real *goal = v.goals + (ptrdiff_t)i * v.width;
      lamc_minus_along(&v, level == 0 ? v.nq : v.n, row, sens, goal);
      lamc_row_scale(v.width, -1, goal);
    }
    memset(rows, 0, (size_t)v.nu * (size_t)v.width * sizeof *rows);
    lamc_vary_solve_loops(s->tangents, &there, &v, at->count, s->column_count, rows);
    if (level == 0) {
      lamc_vary_move(s, &v, y, rows, sens);
    } else {
      for (ptrdiff_t i = 0; i < (ptrdiff_t)v.nu * v.width; i++) late[i] += rows[i];
    }
  }
}

static inline void lamc_vary_settle(lamc_sensitivity *s, lamc_real t, const lamc_real *y, lamc_real *sens,
                                    lamc_real *rows) {
  if (s->motion.model->cut_count == 0 || s->beside.baumgarte != 0) return;
  const int count = lamc_loops_weigh(&s->beside, t, y, y + s->motion.model->coordinate_count);
  const lamc_place at = {t, y, NULL, NULL, count, s->beside.work};
  lamc_vary_settle_at(s, &at, sens, rows);
}

#endif /* LAMC_VARIATION_H */
