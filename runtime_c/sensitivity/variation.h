/* variation.h, of lamc: dS/dt = f_y S + f_p at a state, and S brought to what holds for the state.
 *
 * In the residual form, as in linearise.c: M d(udot) = J^T d(lambda) - dr, J d(udot) = -dc, with r and c differentiated at
 * constant udot and lambda along every column at once. */
#ifndef LAMC_VARIATION_H
#define LAMC_VARIATION_H

#include "lamc_sensitivity.h"

#include "cholesky.h"
#include "loop_columns.h"
#include "loops.h"
#include "method.h"
#include "motion.h"
#include "packs.h"
#include "series.h"
#include "system.h"

/* Counts of a model, and where its parts lie in scratch */
typedef struct variation {
  int nq, nu, m, n, k, width;
  int held_count, held_width; /* what clocks hold, and the width of its derivatives */
  const lamc_real *held;
  lamc_real *udot, *lambda, *derivative, *inertia, *l, *x, *goal, *goals, *packs, *closure;
} variation;

static inline long long lamc_variation_size(const lamc_model *model, int k, int width) {
  const long long nq = model->coordinate_count, nu = model->rate_count, m = model->closure_count, n = nq + nu;
  const long long flow = model->rates == NULL ? 0 : nq * n;
  const long long held = model->held_count, residuals = (nu + m) * (n + k + held) + flow,
                  closure = m * (nq + k + n + k);
  const long long guards = (model->guard_count + held) * (n + 1 + k + held);
  long long most = residuals > closure ? residuals : closure;
  if (guards > most) most = guards;
  return nu + m + most + nu * (nu + 1) / 2 + nu * nu + nu + m + m * width + lamc_loop_columns_size(model) +
         closure;
}

static inline variation lamc_variation_of(const lamc_sensitivity *s) {
  const lamc_model *model = s->motion.model;
  variation v;
  v.nq = model->coordinate_count;
  v.nu = model->rate_count;
  v.m = model->closure_count;
  v.n = v.nq + v.nu;
  v.k = s->tangents->column_count;
  v.width = s->width;
  v.held_count = model->held_count;
  v.held_width = s->held_width;
  v.held = s->held;
  v.udot = s->scratch;
  v.lambda = v.udot + v.nu;
  v.inertia = v.lambda + v.m;
  v.l = v.inertia + (ptrdiff_t)v.nu * (v.nu + 1) / 2;
  v.x = v.l + (ptrdiff_t)v.nu * v.nu;
  v.goal = v.x + v.nu;
  v.goals = v.goal + v.m;
  v.packs = v.goals + (ptrdiff_t)v.m * v.width;
  v.closure = v.packs + lamc_loop_columns_size(model);
  v.derivative = v.closure + (ptrdiff_t)v.m * (v.nq + v.k + v.n + v.k);
  return v;
}

/* out (width,) -= value times row */
static inline void lamc_row_less(int width, lamc_real value, const lamc_real *LAMC_RESTRICT row,
                                 lamc_real *LAMC_RESTRICT out) {
  for (int b = 0; b < width; b += LANES)
    for (int i = b; i < b + LANES; i++) out[i] -= value * row[i];
}

static inline void lamc_row_scale(int width, lamc_real value, lamc_real *out) {
  for (int b = 0; b < width; b += LANES)
    for (int i = b; i < b + LANES; i++) out[i] *= value;
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

/* udot and lambda at a state, and the factors that lamc_vary_solve uses; how many equations of loops count.
 * known: udot, where it is known, of a model that gives it as it is; NULL: it is worked out */
static inline int lamc_vary_prepare(const lamc_sensitivity *s, const variation *v, lamc_real t,
                                    const lamc_real *y, const lamc_real *known) {
  const lamc_model *model = s->motion.model;
  lamc_series_put(&s->beside, t);
  if (model->cut_count > 0) return lamc_loops_acceleration(&s->beside, t, y, y + v->nq, v->udot, v->lambda);
  if (lamc_is_system(model)) {
    lamc_motion_accelerate(&s->beside, t, y, y + v->nq, v->udot);
    return 0;
  }
  if (known != NULL) {
    memcpy(v->udot, known, (size_t)v->nu * sizeof *known);
  } else {
    lamc_motion_accelerate(&s->beside, t, y, y + v->nq, v->udot);
  }
  model->inertia(s->beside.constants, y, v->inertia);
  lamc_cholesky(v->nu, v->inertia, v->l);
  return 0;
}

/* rows (nu, width) replaced by x of M x = rows + J^T ..., J x + goals = 0, by columns; goals (m, width) */
static inline void lamc_vary_solve_loops(const lamc_sensitivity *s, const variation *v, int count,
                                         int columns, lamc_real *rows) {
  lamc_loop_parts p;
  lamc_loop_parts_of(&s->beside, &p);
  if (lamc_has_loop_columns(&p)) {
    lamc_loop_columns(&p, count, v->width, v->goals, rows, v->packs);
    return;
  }
  for (int c = 0; c < columns; c++) {
    for (int i = 0; i < v->nu; i++) v->x[i] = rows[(ptrdiff_t)i * v->width + c];
    for (int i = 0; i < v->m; i++) v->goal[i] = v->goals[(ptrdiff_t)i * v->width + c];
    lamc_loops_response(&s->beside, count, v->goal, v->x);
    for (int i = 0; i < v->nu; i++) rows[(ptrdiff_t)i * v->width + c] = v->x[i];
  }
}

/* Derivatives of c = J udot + gamma with what Baumgarte's stabilisation adds to it, 2 b J u + b^2 phi */
static inline void lamc_vary_stabilise(const lamc_sensitivity *s, const variation *v, const lamc_real *y) {
  const lamc_real b = s->beside.baumgarte;
  const int part = v->nq + v->k, across = v->n + v->k;
  s->tangents->closure(s->beside.constants, y, y + v->nq, v->closure);
  for (int i = 0; i < v->m; i++) {
    const lamc_real *gap = v->closure + (ptrdiff_t)i * (part + across), *rate = gap + part;
    lamc_real *row = v->derivative + (ptrdiff_t)(v->nu + i) * (across + v->held_count);
    for (int j = 0; j < across; j++) row[j] += 2 * b * rate[j];
    for (int j = 0; j < v->nq; j++) row[j] += b * b * gap[j];
    for (int j = 0; j < v->k; j++) row[v->n + j] += b * b * gap[v->nq + j];
  }
}

/* dS/dt (n, width) at a state y with derivatives sens (n, width). known: as for lamc_vary_prepare */
static inline void lamc_vary(lamc_sensitivity *s, lamc_real t, const lamc_real *y, const lamc_real *known,
                             const lamc_real *sens, lamc_real *slope) {
  const lamc_model *model = s->motion.model;
  const variation v = lamc_variation_of(s);
  const int across = v.n + v.k + v.held_count;
  lamc_series_put(&s->beside, t);
  const int count = lamc_vary_prepare(s, &v, t, y, known);
  lamc_real *late = slope + (ptrdiff_t)v.nq * v.width;
  s->tangents->residuals(s->beside.constants, t, y, y + v.nq, v.udot, v.lambda, v.derivative);
  if (s->beside.baumgarte != 0) lamc_vary_stabilise(s, &v, y);
  s->evaluations++;
  for (int i = 0; i < v.nu; i++)
    lamc_minus_along(&v, v.n, v.derivative + (ptrdiff_t)i * across, sens, late + (ptrdiff_t)i * v.width);
  if (model->cut_count > 0) {
    for (int i = 0; i < v.m; i++) {
      lamc_real *goal = v.goals + (ptrdiff_t)i * v.width;
      lamc_minus_along(&v, v.n, v.derivative + (ptrdiff_t)(v.nu + i) * across, sens, goal);
      lamc_row_scale(v.width, -1, goal);
    }
    lamc_vary_solve_loops(s, &v, count, s->column_count, late);
  } else {
    lamc_solve_columns(v.nu, lamc_is_system(model) ? s->beside.work : v.l, v.width, late);
  }
  if (model->rates == NULL) {
    memcpy(slope, sens + (ptrdiff_t)v.nq * v.width, (size_t)v.nq * (size_t)v.width * sizeof *slope);
    return;
  }
  const lamc_real *flow = v.derivative + (ptrdiff_t)(v.nu + v.m) * across;
  variation only_state = v;
  only_state.k = only_state.held_count = 0;
  for (int i = 0; i < v.nq; i++) {
    lamc_real *row = slope + (ptrdiff_t)i * v.width;
    lamc_minus_along(&only_state, v.n, flow + (ptrdiff_t)i * v.n, sens, row);
    lamc_row_scale(v.width, -1, row);
  }
}

/* How the rates in rows (nu, width) move coordinates: added to `out` (nq, width) */
static inline void lamc_vary_move(const lamc_sensitivity *s, const variation *v, const lamc_real *y,
                                  const lamc_real *rows, lamc_real *out) {
  for (int c = 0; c < s->column_count; c++) {
    for (int i = 0; i < v->nu; i++) v->x[i] = rows[(ptrdiff_t)i * v->width + c];
    lamc_motion_rates(&s->beside, y, v->x, v->derivative);
    for (int i = 0; i < v->nq; i++) out[(ptrdiff_t)i * v->width + c] += v->derivative[i];
  }
}

/* S (n, width) brought to what closure asks for: J dq + phi_p = 0, and the same of its rates, by the smallest move in the
 * mass metric. rows: (nu, width) of scratch */
static inline void lamc_vary_settle(lamc_sensitivity *s, lamc_real t, const lamc_real *y, lamc_real *sens,
                                    lamc_real *rows) {
  if (s->motion.model->cut_count == 0 || s->beside.baumgarte != 0) return;
  variation v = lamc_variation_of(s);
  v.held_count = 0; /* closure knows nothing of it */
  const int part = v.nq + v.k, across = part + v.n + v.k;
  const int count = lamc_loops_weigh(&s->beside, t, y, y + v.nq);
  lamc_real *late = sens + (ptrdiff_t)v.nq * v.width;
  for (int level = 0; level < 2; level++) {
    s->tangents->closure(s->beside.constants, y, y + v.nq, v.derivative);
    for (int i = 0; i < v.m; i++) {
      const lamc_real *row = v.derivative + (ptrdiff_t)i * across + (level == 0 ? 0 : part);
      lamc_real *goal = v.goals + (ptrdiff_t)i * v.width;
      lamc_minus_along(&v, level == 0 ? v.nq : v.n, row, sens, goal);
      lamc_row_scale(v.width, -1, goal);
    }
    memset(rows, 0, (size_t)v.nu * (size_t)v.width * sizeof *rows);
    lamc_vary_solve_loops(s, &v, count, s->column_count, rows);
    if (level == 0) {
      lamc_vary_move(s, &v, y, rows, sens);
    } else {
      for (ptrdiff_t i = 0; i < (ptrdiff_t)v.nu * v.width; i++) late[i] += rows[i];
    }
  }
}

#endif /* LAMC_VARIATION_H */
