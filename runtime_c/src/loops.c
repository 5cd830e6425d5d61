/* loops.c, of lamc: motion under the closure of loops, redundant equations and singular positions included.
 *
 * In:    M, f, J, gamma and phi from a model. Out: accelerations, and states brought back to closure.
 * Never: assumes that the equations are independent; allocates. */
#include "loops.h"

#include "cholesky.h"
#include "loop_equations.h"
#include "motion.h"
#include "tolerances.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

static const int MAX_ITERATIONS = 8;
static const lamc_real LONG_SINGULAR = 3000; /* steps in a row: a passage takes some hundred at 1e-13 */

static long long raw_size(long long n, long long m) {
  const long long system = n * (n + 1) / 2 + n;
  const long long closure = m * n + m;
  return system + closure;
}

long long lamc_loops_work(const lamc_model *model) {
  const long long n = model->rate_count, nq = model->coordinate_count;
  const long long m = model->closure_count;
  if (model->cut_count == 0) return 0;
  return n * n + n + m * n + m + m * n + m * m + m + m + n + nq + (nq + n) + LAMC_LOOPS_KEPT + m +
         raw_size(n, m);
}

static lamc_loop_parts parts_of(const lamc_motion *motion) {
  lamc_loop_parts p;
  p.n = motion->model->rate_count;
  p.nq = motion->model->coordinate_count;
  p.m = motion->model->closure_count;
  const size_t n = (size_t)p.n, nq = (size_t)p.nq;
  const size_t m = (size_t)p.m;
  p.l = motion->work;
  p.f = p.l + n * n;
  p.j = p.f + n;
  p.extra = p.j + m * n;
  p.q = p.extra + m;
  p.r = p.q + m * n;
  p.g = p.r + m * m;
  p.order = p.g + m;
  p.x = p.order + m;
  p.qdot = p.x + n;
  p.y = p.qdot + nq;
  p.state = p.y + nq + n;
  p.norms = p.state + LAMC_LOOPS_KEPT;
  p.raw = p.norms + m;
  return p;
}

/* L, and f, at a state, after its closure */
static void evaluate_system(const lamc_motion *motion, const lamc_loop_parts *p, lamc_real t,
                            const lamc_real *q, const lamc_real *u) {
  motion->model->system(motion->constants, t, q, u, p->raw);
  memcpy(p->f, p->raw + (ptrdiff_t)p->n * (p->n + 1) / 2, (size_t)p->n * sizeof *p->f);
  lamc_loop_factor(p);
}

/* L, f, J, gamma and the directions at a state; returns how many equations were taken */
static int prepare(const lamc_motion *motion, const lamc_loop_parts *p, lamc_real t, const lamc_real *q,
                   const lamc_real *u) {
  const size_t n = (size_t)p->n, entries = (size_t)p->m * n;
  const lamc_real *f = p->raw + n * (n + 1) / 2, *jacobian = f + n;
  motion->model->dynamics(motion->constants, t, q, u, p->raw);
  memcpy(p->f, f, n * sizeof *p->f);
  memcpy(p->j, jacobian, entries * sizeof *p->j);
  memcpy(p->extra, jacobian + entries, (size_t)p->m * sizeof *p->extra);
  lamc_loop_normalise(motion, p);
  lamc_loop_factor(p);
  return lamc_loop_take(motion, p);
}

/* 1 if an equation is about to become dependent, or fades: the state is near a singular position */
static int is_near_singular(const lamc_motion *motion, const lamc_loop_parts *p, int count) {
  if (lamc_loop_last_pivot(motion, p, count) < NEAR_SINGULAR) return 1;
  for (int i = 0; i < p->m; i++) {
    if (p->norms[i] > 0 && p->norms[i] < NEAR_SINGULAR) return 1;
  }
  return 0;
}

/* How far from closure, of the size, a state may be: what it is off, divided by the square of the last pivot, is an
 * acceleration out of nothing. No more is asked for: beside a light part, such as a mode of a link that bends, pivots
 * are small everywhere, and what moves such a part by its last digit is an acceleration out of nothing as well. */
static lamc_real close_enough(const lamc_motion *motion, const lamc_loop_parts *p, int count) {
  const lamc_real pivot = lamc_loop_last_pivot(motion, p, count);
  const lamc_real enough = OUT_OF_NOTHING * pivot * pivot;
  if (enough > CLOSED) return CLOSED;
  return enough > EXACT ? enough : EXACT;
}

/* Baumgarte's stabilisation: with b the rate, gamma + 2 b J u + b^2 phi in place of gamma */
static void pull_back(const lamc_motion *motion, const lamc_loop_parts *p, const lamc_real *q,
                      const lamc_real *u) {
  const lamc_real b = motion->baumgarte;
  motion->model->closure(motion->constants, q, p->raw);
  for (int i = 0; i < p->m; i++) {
    const lamc_real rate = lamc_dot(p->n, p->j + (ptrdiff_t)i * p->n, u);
    if (p->norms[i] > LAMC_LEAST) p->extra[i] += 2 * b * rate + b * b * (p->raw[i] / p->norms[i]);
  }
}

int lamc_loops_acceleration(const lamc_motion *motion, lamc_real t, const lamc_real *q, const lamc_real *u,
                            lamc_real *udot, lamc_real *lambda) {
  const lamc_loop_parts p = parts_of(motion);
  int count = prepare(motion, &p, t, q, u);
  if (motion->baumgarte != 0) {
    pull_back(motion, &p, q, u);
  } else if (is_near_singular(motion, &p, count)) {
    /* A stage of a Runge-Kutta step is off closure by the square of the step or so; divided by the square of the last
     * pivot that is an acceleration out of nothing. On closure it is none. */
    lamc_real moved = 0;
    memcpy(p.y, q, (size_t)p.nq * sizeof *q);
    memcpy(p.y + p.nq, u, (size_t)p.n * sizeof *u);
    if (lamc_motion_settle(motion, t, p.y, &moved) == LAMC_OK) {
      count = prepare(motion, &p, t, p.y, p.y + p.nq);
    }
  }
  if (count < motion->model->rank) p.state[2] += 1;
  memcpy(udot, p.f, (size_t)p.n * sizeof *udot);
  lamc_solve_lower(p.n, p.l, udot);
  lamc_loop_impose(&p, count, p.extra, udot);
  if (lambda != NULL) lamc_loop_lambda(&p, count, udot, lambda);
  lamc_solve_upper(p.n, p.l, udot);
  return count;
}

void lamc_loops_response(const lamc_motion *motion, int count, const lamc_real *goal, lamc_real *x) {
  const lamc_loop_parts p = parts_of(motion);
  for (int i = 0; i < p.m; i++) p.extra[i] = p.norms[i] > LAMC_LEAST ? goal[i] / p.norms[i] : 0;
  lamc_solve_lower(p.n, p.l, x);
  lamc_loop_impose(&p, count, p.extra, x);
  lamc_solve_upper(p.n, p.l, x);
}

int lamc_loops_weigh(const lamc_motion *motion, lamc_real t, const lamc_real *q, const lamc_real *u) {
  const lamc_loop_parts p = parts_of(motion);
  return prepare(motion, &p, t, q, u);
}

void lamc_loops_free(const lamc_motion *motion, int count, lamc_real *x) {
  const lamc_loop_parts p = parts_of(motion);
  lamc_solve_lower(p.n, p.l, x);
  for (int k = 0; k < count; k++) {
    const lamc_real *direction = p.q + (ptrdiff_t)k * p.n;
    const lamc_real along = lamc_dot(p.n, direction, x);
    for (int i = 0; i < p.n; i++) x[i] -= along * direction[i];
  }
}

void lamc_loops_rates(const lamc_motion *motion, lamc_real *x) {
  const lamc_loop_parts p = parts_of(motion);
  lamc_solve_upper(p.n, p.l, x);
}

static lamc_real largest(int n, const lamc_real *v) {
  lamc_real most = 0;
  for (int i = 0; i < n; i++) {
    if (!(fabs(v[i]) <= most)) most = fabs(v[i]);
  }
  return most;
}

/* phi and J at q, rows of J normalised; returns the largest of phi before that, rad or parts of the size */
static lamc_real evaluate_closure(const lamc_motion *motion, const lamc_loop_parts *p, const lamc_real *q) {
  motion->model->closure(motion->constants, q, p->raw);
  memcpy(p->extra, p->raw, (size_t)p->m * sizeof *p->extra);
  memcpy(p->j, p->raw + p->m, (size_t)p->m * (size_t)p->n * sizeof *p->j);
  const lamc_real gap = largest(p->m, p->extra);
  lamc_loop_normalise(motion, p);
  return gap;
}

lamc_status lamc_motion_settle(const lamc_motion *motion, lamc_real t, lamc_real *y, lamc_real *moved) {
  const lamc_model *model = motion->model;
  const lamc_loop_parts p = parts_of(motion);
  lamc_real *q = y;
  lamc_real *u = y + p.nq;
  *moved = 0;
  if (model->cut_count == 0) return LAMC_OK;
  lamc_real open = evaluate_closure(motion, &p, q);
  evaluate_system(motion, &p, t, q, u);
  int count = lamc_loop_take(motion, &p);
  lamc_real gap = largest(p.m, p.extra);
  for (int round = 0; round < MAX_ITERATIONS; round++) {
    if (gap <= close_enough(motion, &p, count)) break;
    memset(p.x, 0, (size_t)p.n * sizeof *p.x);
    lamc_loop_impose(&p, count, p.extra, p.x);
    lamc_solve_upper(p.n, p.l, p.x);
    lamc_motion_rates(motion, q, p.x, p.qdot);
    for (int i = 0; i < p.nq; i++) q[i] += p.qdot[i];
    *moved += largest(p.n, p.x);
    open = evaluate_closure(motion, &p, q);
    count = lamc_loop_take(motion, &p);
    const lamc_real before = gap;
    gap = largest(p.m, p.extra);
    if (!(gap < LAMC_R(0.5) * before)) break; /* round-off, or a singular position: no closer from here */
  }
  const lamc_real tolerance = model->tolerance / model->size;
  if (!(open <= (LOST > tolerance ? LOST : tolerance))) return LAMC_CLOSURE_LOST;
  /* Rates: x = L^T u, without its parts along the equations */
  for (int i = 0; i < p.n; i++) {
    lamc_real sum = u[i] / p.l[(ptrdiff_t)i * p.n + i];
    for (int k = i + 1; k < p.n; k++) sum += p.l[(ptrdiff_t)k * p.n + i] * u[k];
    p.x[i] = sum;
  }
  memset(p.extra, 0, (size_t)p.m * sizeof *p.extra);
  lamc_loop_impose(&p, count, p.extra, p.x);
  lamc_solve_upper(p.n, p.l, p.x);
  for (int i = 0; i < p.n; i++) {
    const lamc_real change = fabs(p.x[i] - u[i]);
    if (change > *moved) *moved = change;
    u[i] = p.x[i];
  }
  p.state[0] = (lamc_real)count;
  return LAMC_OK;
}

void lamc_loops_keep(const lamc_motion *motion, lamc_real *kept) {
  const lamc_loop_parts p = parts_of(motion);
  memcpy(kept, p.state, LAMC_LOOPS_KEPT * sizeof *kept);
}

void lamc_loops_put_back(const lamc_motion *motion, const lamc_real *kept) {
  const lamc_loop_parts p = parts_of(motion);
  memcpy(p.state, kept, LAMC_LOOPS_KEPT * sizeof *kept);
}

void lamc_loops_begin(const lamc_motion *motion) {
  const lamc_loop_parts p = parts_of(motion);
  p.state[1] = p.state[2] = p.state[3] = 0;
}

long long lamc_loops_doubts(const void *context) {
  const lamc_loop_parts p = parts_of((const lamc_motion *)context);
  return (long long)p.state[2];
}

long long lamc_motion_singular_steps(const lamc_motion *motion) {
  return motion->model->cut_count > 0 ? (long long)parts_of(motion).state[3] : 0;
}

lamc_status lamc_loops_judge(const void *context) {
  const lamc_motion *motion = (const lamc_motion *)context;
  const lamc_loop_parts p = parts_of(motion);
  const int is_singular = p.state[0] < (lamc_real)motion->model->rank;
  p.state[1] = is_singular ? p.state[1] + 1 : 0;
  if (is_singular) p.state[3] += 1;
  return p.state[1] > LONG_SINGULAR ? LAMC_RANK_LOST : LAMC_OK;
}
