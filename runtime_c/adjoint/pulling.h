/* pulling.h, of lamc: derivatives of weighted slopes dy/dt at a state, and of weighted states that were brought to closure.
 *
 * In the residual form of variation.h, transposed: with v the weights of udot, M w = v + J^T mu, J w = 0, it is
 * -w . r + mu . c that is differentiated, at constant udot and lambda. */
#ifndef LAMC_PULLING_H
#define LAMC_PULLING_H

#include "lamc_adjoint.h"

#include "entries.h"
#include "loop_equations.h"
#include "loop_work.h"
#include "loops.h"
#include "motion.h"
#include "series.h"
#include "system.h"

enum { STAGES = 16, FINE_PARTS = 24 };

/* Counts of a model, and where its parts lie in scratch. slopes, states, weights of slopes: (STAGES, n); fine: states at the
 * ends of the parts of a step */
typedef struct room {
  int nq, nu, m, n, k;
  lamc_real *udot, *lambda, *none, *weights, *out, *slopes, *states, *pulls, *kept, *first, *second, *third;
  lamc_real *begin, *seed, *error, *jacobian, *matrix, *right, *fine;
} room;

static inline long long lamc_most(long long a, long long b) {
  return a > b ? a : b;
}

static inline long long lamc_scratch_of(const lamc_model *model, const lamc_pullbacks *pullbacks, room *r,
                                        lamc_real *scratch) {
  const long long nq = model->coordinate_count, nu = model->rate_count, m = model->closure_count, n = nq + nu;
  long long weights = lamc_most(nq + nu + m, 2 * m);
  weights = lamc_most(weights, (long long)model->guard_count * (1 + nu) + 1 + 2 * nu + 2 * m);
  weights = lamc_most(weights, (long long)model->clock_count + model->held_count);
  const long long sizes[] = {nu,
                             m,
                             m,
                             weights,
                             n + 1 + pullbacks->source_count + model->held_count,
                             STAGES * n,
                             STAGES * n,
                             STAGES * n,
                             STAGES * n,
                             n,
                             n,
                             n,
                             n,
                             n,
                             n,
                             RADAU_NODES * n * n,
                             RADAU_NODES * n * RADAU_NODES * n,
                             RADAU_NODES * n,
                             (FINE_PARTS + 1) * n};
  enum { PARTS = sizeof sizes / sizeof sizes[0] };
  long long at = 0;
  if (r == NULL) {
    for (int i = 0; i < PARTS; i++) at += sizes[i];
    return at;
  }
  lamc_real **const parts[PARTS] = {&r->udot,     &r->lambda, &r->none,  &r->weights, &r->out,
                                    &r->slopes,   &r->states, &r->pulls, &r->kept,    &r->first,
                                    &r->second,   &r->third,  &r->begin, &r->seed,    &r->error,
                                    &r->jacobian, &r->matrix, &r->right, &r->fine};
  for (int i = 0; i < PARTS; i++) {
    *parts[i] = scratch + at;
    at += sizes[i];
  }
  r->nq = (int)nq;
  r->nu = (int)nu;
  r->m = (int)m;
  r->n = (int)n;
  r->k = pullbacks->source_count + model->held_count;
  return at;
}

static inline room lamc_room_of(const lamc_adjoint *a) {
  room r;
  (void)lamc_scratch_of(a->motion.model, a->pullbacks, &r, a->scratch);
  return r;
}

static inline int lamc_is_plain(const lamc_model *model) {
  return model->acceleration != NULL && model->cut_count == 0;
}

/* udot, lambda, and what solves for them, at a state; how many equations of loops count */
static inline int lamc_prepare(lamc_adjoint *a, const room *r, lamc_real t, const lamc_real *y) {
  const lamc_real *u = y + r->nq;
  lamc_series_put(&a->motion, t);
  if (lamc_is_plain(a->motion.model)) return 0;
  a->evaluations++;
  if (a->motion.model->cut_count > 0) return lamc_loops_acceleration(&a->motion, t, y, u, r->udot, r->lambda);
  lamc_motion_accelerate(&a->motion, t, y, u, r->udot);
  return 0;
}

/* dy/dt */
static inline void lamc_slope(lamc_adjoint *a, const room *r, lamc_real t, const lamc_real *y,
                              lamc_real *out) {
  a->evaluations++;
  lamc_motion_rates(&a->motion, y, y + r->nq, out);
  lamc_motion_accelerate(&a->motion, t, y, y + r->nq, out + r->nq);
}

static inline void lamc_add_to(ptrdiff_t count, lamc_real weight, const lamc_real *v, lamc_real *out) {
  for (ptrdiff_t i = 0; i < count; i++) out[i] += weight * v[i];
}

/* What loops make of weights (nu,) of rates, w of M w = weights + J^T mu, J w = 0; and mu (m,) */
static inline void lamc_pull_loops(lamc_adjoint *a, const room *r, int count, lamc_real *weights,
                                   lamc_real *multipliers) {
  lamc_loop_parts p;
  memcpy(r->third, weights, (size_t)r->nu * sizeof *weights);
  lamc_loops_response(&a->motion, count, r->none, weights);
  lamc_loop_parts_of(&a->motion, &p);
  memset(multipliers, 0, (size_t)r->m * sizeof *multipliers);
  lamc_loop_momenta(&p, weights, p.z);
  for (int i = 0; i < r->nu; i++) p.z[i] -= r->third[i];
  if (p.is_sparse) {
    lamc_sparse_lambda(&p, count, p.z, multipliers);
  } else {
    lamc_dense_lambda(&p, count, p.z, multipliers);
  }
  for (int i = 0; i < r->m; i++) multipliers[i] = p.norms[i] > 0 ? multipliers[i] / p.norms[i] : 0;
}

/* Adds to `into` (n,) the derivatives of v . dy/dt by the state, at one that was prepared, and to `sources`, unless NULL, those
 * by the sources */
static inline void lamc_pull(lamc_adjoint *a, const room *r, lamc_real t, const lamc_real *y, int count,
                             const lamc_real *v, lamc_real *into, lamc_real *sources) {
  const lamc_model *model = a->motion.model;
  lamc_real *w = r->weights, *after = w + r->nu;
  memcpy(w, v + r->nq, (size_t)r->nu * sizeof *w);
  if (model->cut_count > 0) {
    lamc_pull_loops(a, r, count, w, after);
    for (int i = 0; i < r->m; i++) after[i] = -after[i];
    after += r->m;
  } else if (lamc_is_system(model)) {
    lamc_system_response(&a->motion, w);
  }
  if (model->rates != NULL) {
    memcpy(after, v, (size_t)r->nq * sizeof *w);
  } else {
    for (int i = 0; i < r->nq; i++) into[r->nq + i] += v[i];
  }
  a->pulls++;
  a->pullbacks->motion(a->motion.constants, t, y, y + r->nq, r->udot, r->lambda, w, r->out);
  lamc_add_to(r->n, 1, r->out, into);
  if (sources != NULL) lamc_add_to(r->k, 1, r->out + r->n, sources);
}

/* Weights (nu,) of rates from those of dq/dt (nq,), at a state */
static inline void lamc_pull_rates(lamc_adjoint *a, const room *r, lamc_real t, const lamc_real *y,
                                   const lamc_real *v, lamc_real *rates) {
  if (a->motion.model->rates == NULL) {
    memcpy(rates, v, (size_t)r->nu * sizeof *rates);
    return;
  }
  memset(r->weights, 0, (size_t)(r->nu + r->m) * sizeof *rates);
  memcpy(r->weights + r->nu + r->m, v, (size_t)r->nq * sizeof *rates);
  a->pullbacks->motion(a->motion.constants, t, y, y + r->nq, r->udot, r->lambda, r->weights, r->out);
  memcpy(rates, r->out + r->nq, (size_t)r->nu * sizeof *rates);
}

/* The derivatives by a state (n,) that was brought to closure at a place, replaced by those by what it was before:
 * lamc_vary_settle, transposed */
static inline void lamc_pull_settle(lamc_adjoint *a, const room *r, lamc_real t, const lamc_real *y,
                                    lamc_real *state) {
  if (a->motion.model->cut_count == 0) return;
  lamc_real *w = r->weights, *rates = r->second;
  lamc_series_put(&a->motion, t);
  const int count = lamc_loops_weigh(&a->motion, t, y, y + r->nq);
  for (int level = 1; level >= 0; level--) {
    if (level == 1) {
      memcpy(rates, state + r->nq, (size_t)r->nu * sizeof *rates);
    } else {
      lamc_pull_rates(a, r, t, y, state, rates);
    }
    memset(w, 0, 2 * (size_t)r->m * sizeof *w);
    lamc_pull_loops(a, r, count, rates, w + (ptrdiff_t)level * r->m);
    a->pullbacks->closure(a->motion.constants, y, y + r->nq, w, r->out);
    lamc_add_to(r->n, 1, r->out, state);
    lamc_add_to(r->k, 1, r->out + r->n, a->sources);
  }
}

#endif /* LAMC_PULLING_H */
