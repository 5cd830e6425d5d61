/* impacts.c, of lamc: rates after impacts that happen at one instant, solved together.
 *
 * In: guards that were struck, their gradients g by the rates u and their restitutions e. Out: rates that leave all of them.
 * Never: lets the order of the guards decide, or adds energy.
 *
 * With v = g u > 0 before, M (u+ - u) = -G^T l + J^T ..., J u+ = 0 and
 *     l >= 0,  v+ + e v <= 0,  l (v+ + e v) = 0   for each struck guard:
 * Newton's law where an impulse acts, none where the others alone drive a guard apart as fast (C. Glocker, F. Pfeiffer,
 * Nonlinear Dynamics 7 (1995) 471-497). v+ is unique, and 2 dT = -sum l (1 - e) v <= 0. With w the part of L^-1 g^T,
 * M = L L^T, that loops leave free, it is the least x = sum l w with w x >= (1 + e) v: C. L. Lawson, R. J. Hanson,
 * Solving Least Squares Problems (1974), chapter 23. Guards that an impact drives into their limits are struck next. */
#include "impacts.h"

#include "cholesky.h"
#include "loops.h"
#include "motion.h"
#include "series.h"
#include "tolerances.h"

#include <string.h>

enum { MAX_ROUNDS = 64 }; /* of guards that strike each other; what is left over is an event of its own */

static const lamc_real APART =
    64 * LAMC_EPSILON; /* of w w: what makes dependent guards share an impulse evenly */
static const lamc_real LEAST = 4096 * LAMC_EPSILON; /* of a rate before: round-off of those after */

/* The parts of the work for guards; k guards, n rates, m at most that are solved together */
typedef struct impacts {
  int k, n, m;
  lamc_real *restitution;                 /* (k,) */
  lamc_real *gradient;                    /* (k, n) */
  lamc_real *l;                           /* (n, n), of a motion without loops */
  lamc_real *raw;                         /* what the model writes of it */
  lamc_real *w;                           /* (m, n) */
  lamc_real *factor;                      /* (m, m) */
  lamc_real *x;                           /* (n,) */
  lamc_real *v, *goal, *impulse, *wanted; /* (m,) each */
  lamc_real *acts;                        /* (m,): 1 where the impulse is free, 0 where it is zero */
} impacts;

static int at_most(const lamc_model *model) {
  return model->guard_count < model->rate_count ? model->guard_count : model->rate_count;
}

long long lamc_impacts_work(const lamc_model *model) {
  const long long n = model->rate_count, k = model->guard_count, m = at_most(model);
  if (k == 0) return 0;
  return k + k * n + n * n + n * (n + 1) / 2 + n + m * n + m * m + n + 5 * m;
}

static impacts impacts_of(const lamc_motion *motion) {
  impacts p;
  p.k = motion->model->guard_count;
  p.n = motion->model->rate_count;
  p.m = at_most(motion->model);
  p.restitution = lamc_motion_guard_work(motion);
  p.gradient = p.restitution + p.k;
  p.l = p.gradient + (ptrdiff_t)p.k * p.n;
  p.raw = p.l + (ptrdiff_t)p.n * p.n;
  p.w = p.raw + (ptrdiff_t)p.n * (p.n + 1) / 2 + p.n;
  p.factor = p.w + (ptrdiff_t)p.m * p.n;
  p.x = p.factor + (ptrdiff_t)p.m * p.m;
  p.v = p.x + p.n;
  p.goal = p.v + p.m;
  p.impulse = p.goal + p.m;
  p.wanted = p.impulse + p.m;
  p.acts = p.wanted + p.m;
  return p;
}

/* M at a position, as L; how many equations of the loops count */
static int weigh(const lamc_motion *motion, const impacts *p, lamc_real t, const lamc_real *q,
                 const lamc_real *u) {
  const lamc_model *model = motion->model;
  if (model->cut_count > 0) return lamc_loops_weigh(motion, t, q, u);
  if (model->inertia != NULL) {
    model->inertia(motion->constants, q, p->raw);
  } else {
    model->system(motion->constants, t, q, u, p->raw); /* and f behind it */
  }
  lamc_cholesky(p->n, p->raw, p->l);
  return 0;
}

/* x = the part of L^-1 x that loops leave free */
static void make_free(const lamc_motion *motion, const impacts *p, int count, lamc_real *x) {
  if (motion->model->cut_count > 0) {
    lamc_loops_free(motion, count, x);
  } else {
    lamc_solve_lower(p->n, p->l, x);
  }
}

/* The change of u from x */
static void to_rates(const lamc_motion *motion, const impacts *p, int count, lamc_real *x) {
  if (motion->model->cut_count > 0) {
    lamc_loops_rates(motion, count, x);
  } else {
    lamc_solve_upper(p->n, p->l, x);
  }
}

/* The guards that go into their limits, as many as can be solved together: w, v and goal; how many */
static int collect(const lamc_motion *motion, const impacts *p, int count, const lamc_real *u,
                   const lamc_real *struck) {
  int found = 0;
  for (int g = 0; g < p->k && found < p->m; g++) {
    if (!(struck[g] > 0) || motion->model->guard_modes[g] != -1) continue;
    const lamc_real *gradient = p->gradient + (ptrdiff_t)g * p->n;
    const lamc_real v = lamc_dot(p->n, gradient, u);
    if (!(v > 0)) continue;
    lamc_real *w = p->w + (ptrdiff_t)found * p->n;
    memcpy(w, gradient, (size_t)p->n * sizeof *w);
    make_free(motion, p, count, w);
    if (!(lamc_dot(p->n, w, w) > 0)) continue; /* nothing can move it */
    p->v[found] = v;
    p->goal[found++] = (1 + p->restitution[g]) * v;
  }
  return found;
}

/* wanted: impulses of the acting guards that reach all their goals */
static void solve_acting(const impacts *p, int found) {
  for (int i = 0; i < found; i++) {
    lamc_real *row = p->factor + (ptrdiff_t)i * p->m;
    p->wanted[i] = p->acts[i] > 0 ? p->goal[i] : 0;
    for (int j = 0; j <= i; j++) {
      const lamc_real *other = p->factor + (ptrdiff_t)j * p->m;
      lamc_real entry = 0;
      if (p->acts[i] > 0 && p->acts[j] > 0)
        entry = lamc_dot(p->n, p->w + (ptrdiff_t)i * p->n, p->w + (ptrdiff_t)j * p->n);
      if (i == j) entry = p->acts[i] > 0 ? (1 + APART) * entry : 1;
      entry -= lamc_dot(j, row, other);
      row[j] = i == j ? 1 / sqrt(entry) : entry * other[j];
    }
  }
  for (int i = 0; i < found; i++) {
    const lamc_real *row = p->factor + (ptrdiff_t)i * p->m;
    p->wanted[i] = (p->wanted[i] - lamc_dot(i, row, p->wanted)) * row[i];
  }
  for (int i = found - 1; i >= 0; i--) {
    lamc_real sum = p->wanted[i];
    for (int j = i + 1; j < found; j++) sum -= p->factor[(ptrdiff_t)j * p->m + i] * p->wanted[j];
    p->wanted[i] = sum * p->factor[(ptrdiff_t)i * p->m + i];
  }
}

/* Impulses go towards those wanted, until one would pull: its guard acts no longer. 1 if all could be had */
static int approach(const impacts *p, int found) {
  lamc_real part = 1;
  int first = -1;
  for (int i = 0; i < found; i++) {
    if (p->acts[i] > 0 && !(p->wanted[i] > 0)) {
      const lamc_real ratio = p->impulse[i] > 0 ? p->impulse[i] / (p->impulse[i] - p->wanted[i]) : 0;
      if (first < 0 || ratio < part) {
        part = ratio;
        first = i;
      }
    }
  }
  for (int i = 0; i < found; i++) p->impulse[i] += part * (p->wanted[i] - p->impulse[i]);
  if (first < 0) return 1;
  p->acts[first] = p->impulse[first] = 0;
  return 0;
}

/* x = sum of impulse times w */
static void add_up(const impacts *p, int found) {
  memset(p->x, 0, (size_t)p->n * sizeof *p->x);
  for (int i = 0; i < found; i++) {
    const lamc_real *w = p->w + (ptrdiff_t)i * p->n;
    for (int c = 0; c < p->n && p->acts[i] > 0; c++) p->x[c] += p->impulse[i] * w[c];
  }
}

/* The guard that is farthest from its goal, of it; -1 where all have theirs */
static int farthest(const impacts *p, int found) {
  int worst = -1;
  lamc_real most = LEAST;
  for (int i = 0; i < found; i++) {
    const lamc_real missing = p->goal[i] - lamc_dot(p->n, p->w + (ptrdiff_t)i * p->n, p->x);
    if (!(p->acts[i] > 0) && missing > most * p->goal[i]) {
      most = missing / p->goal[i];
      worst = i;
    }
  }
  return worst;
}

/* x of the impacts on `found` guards */
static void solve_together(const impacts *p, int found) {
  for (int i = 0; i < found; i++) p->impulse[i] = p->acts[i] = 0;
  add_up(p, found);
  for (int round = 0; round < 3 * found;
       round++) { /* Lawson and Hanson's bound; found is enough nearly always */
    const int next = farthest(p, found);
    if (next < 0) return;
    p->acts[next] = 1;
    for (int i = 0; i <= found; i++) {
      solve_acting(p, found);
      if (approach(p, found)) break;
    }
    add_up(p, found);
  }
}

void lamc_impacts(const lamc_motion *motion, lamc_real t, lamc_real *y, const lamc_real *struck) {
  const impacts p = impacts_of(motion);
  lamc_real *q = y, *u = y + motion->model->coordinate_count;
  lamc_series_put(motion, t);
  motion->model->impacts(motion->constants, t, q, p.restitution);
  const int count = weigh(motion, &p, t, q, u);
  for (int round = 0; round < MAX_ROUNDS; round++) {
    const int found = collect(motion, &p, count, u, struck);
    if (found == 0) return;
    if (found == 1) {
      const lamc_real impulse = p.goal[0] / lamc_dot(p.n, p.w, p.w);
      memcpy(p.x, p.w, (size_t)p.n * sizeof *p.x);
      to_rates(motion, &p, count, p.x);
      for (int i = 0; i < p.n; i++) u[i] -= impulse * p.x[i];
    } else {
      solve_together(&p, found);
      to_rates(motion, &p, count, p.x);
      for (int i = 0; i < p.n; i++) u[i] -= p.x[i];
    }
  }
}
