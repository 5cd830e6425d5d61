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
  const long long state = nq + n, around = n + m;
  return raw_size(n, m) + n * (n + 1) / 2 + 5 * n + 2 * m * n + 2 * n * n + 7 * m + nq + state +
         LAMC_LOOPS_KEPT + around;
}

static lamc_loop_parts parts_of(const lamc_motion *motion) {
  lamc_loop_parts p;
  p.n = motion->model->rate_count;
  p.nq = motion->model->coordinate_count;
  p.m = motion->model->closure_count;
  const size_t n = (size_t)p.n, nq = (size_t)p.nq;
  const size_t m = (size_t)p.m;
  p.beyond = motion->model->joint_count;
  p.cut = p.beyond - motion->model->cut_count;
  p.mass = motion->work;
  p.f = p.mass + n * (n + 1) / 2;
  p.j = p.f + n;
  p.extra = p.j + m * n;
  p.a = p.extra + m;
  p.rows = p.a + m * n;
  p.columns = p.rows + m;
  p.peak = p.columns + n;
  p.filled = p.peak + m;
  p.free = p.filled + m;
  p.l = p.free + n * n;
  p.x = p.l + n * n;
  p.z = p.x + n;
  p.goal = p.z + n;
  p.qdot = p.goal + m;
  p.y = p.qdot + nq;
  p.state = p.y + nq + n;
  p.norms = p.state + LAMC_LOOPS_KEPT;
  p.reach = p.norms + m;
  p.mean = p.reach + m;
  p.step = p.mean + n + m;
  p.raw = p.step + n;
  return p;
}

/* The larger of two, which are not negative; NaN where one is */
static lamc_real larger(lamc_real most, lamc_real next) {
  return next > most || next != next ? next : most;
}

static lamc_real largest(int n, const lamc_real *v) {
  lamc_real most = 0;
  for (int i = 0; i < n; i++) most = larger(most, fabs(v[i]));
  return most;
}

/* M, f, J, gamma and what is free at a state; returns how many equations were taken */
static int prepare(const lamc_motion *motion, const lamc_loop_parts *p, lamc_real t, const lamc_real *q,
                   const lamc_real *u) {
  motion->model->dynamics(motion->constants, t, q, u, p->mass); /* and f, J, gamma behind it */
  lamc_loop_normalise(motion, p, q);
  return lamc_loop_take(motion, p);
}

/* 1 if an equation is about to become dependent, or fades: the state is near a singular position */
static int is_near_singular(const lamc_motion *motion, const lamc_loop_parts *p, int count) {
  const lamc_real share =
      p->n > LARGE ? (lamc_real)LARGE / (lamc_real)p->n : 1; /* pivots of long chains are small */
  if (lamc_loop_last_pivot(motion, p, count) < NEAR_SINGULAR * share) return 1;
  for (int i = 0; i < p->m; i++) {
    if (p->norms[i] > 0 && p->norms[i] < NEAR_SINGULAR) return 1;
  }
  return 0;
}

/* How far from closure the equation of row i may be: what it is off, divided by the square of the last pivot, is an
 * acceleration out of nothing, and less than its round-off cannot be had. No more is asked for: beside a light part, such
 * as a mode of a link that bends, pivots are small everywhere, and what moves such a part by its last digit is an
 * acceleration out of nothing as well. */
static lamc_real close_enough(const lamc_loop_parts *p, int i, lamc_real pivot) {
  const lamc_real reach = p->reach[i];
  const lamc_real exact = EXACT * reach * (reach < 1 ? reach : 1);
  const lamc_real fading = p->norms[i] < 1 ? p->norms[i] * pivot : pivot;
  const lamc_real enough = OUT_OF_NOTHING * fading * fading;
  if (enough > CLOSED) return CLOSED;
  return enough > exact ? enough : exact;
}

/* How far from closure the state is, in what is close enough; in `extra` phi by the rows of J. At most 1: it is closed */
static lamc_real openness(const lamc_motion *motion, const lamc_loop_parts *p, int count) {
  const lamc_real pivot = lamc_loop_last_pivot(motion, p, count);
  lamc_real most = 0;
  for (int i = 0; i < p->m; i++) {
    const lamc_real gap = fabs(p->extra[i]) * p->norms[i]; /* a misfit cannot be closed */
    if (gap == 0) continue;
    most = larger(most, gap / close_enough(p, i, pivot));
  }
  return most;
}

/* Baumgarte's stabilisation: with b the rate, gamma + 2 b J u + b^2 phi in place of gamma */
static void pull_back(const lamc_motion *motion, const lamc_loop_parts *p, const lamc_real *q,
                      const lamc_real *u) {
  const lamc_real b = motion->baumgarte;
  motion->model->closure(motion->constants, q, p->raw);
  for (int i = 0; i < p->m; i++) {
    const lamc_real rate = lamc_dot(p->n, p->j + (ptrdiff_t)i * p->n, u);
    if (p->norms[i] > 0) p->extra[i] += 2 * b * rate + b * b * (p->raw[i] / p->norms[i]);
  }
}

/* udot and lambda of a state that was prepared */
static void solve(const lamc_loop_parts *p, int count, lamc_real *udot, lamc_real *lambda) {
  lamc_loop_solve(p, count, p->extra, p->f, udot);
  if (lambda != NULL) lamc_loop_lambda(p, count, udot, lambda);
}

/* 1 if the loops know more than angles of hinges: what is stiff must not be moved that far */
static int something_yields(const lamc_loop_parts *p) {
  for (int i = 0; i < p->m; i++) {
    for (int c = p->beyond; c < p->n; c++) {
      if (p->j[(ptrdiff_t)i * p->n + c] != 0) return 1;
    }
  }
  return 0;
}

/* Where equations fade without their digits, such as in a linkage that passes its line, accelerations from three closed
 * places on each side along the hinges' rates, by the polynomial through them: they are smooth along a branch, and there
 * is no other way to know them from so near. Returns 0 where it is no passage; the work is then that of another place. */
static int solve_around(const lamc_motion *motion, const lamc_loop_parts *p, lamc_real t, const lamc_real *q,
                        const lamc_real *u, lamc_real *udot, lamc_real *lambda) {
  static const lamc_real WEIGHTS[3] = {LAMC_R(0.75), LAMC_R(-0.3), LAMC_R(0.05)};
  const lamc_real pace = largest(p->beyond, u); /* a base stays where it is: it moves no loop */
  lamc_real *sum = p->mean, *forces = p->mean + p->n;
  if (!(pace > LAMC_LEAST) || something_yields(p)) return 0;
  memset(sum, 0, (size_t)(p->n + p->m) * sizeof *sum);
  for (int k = 0; k < 6; k++) {
    const lamc_real way = (lamc_real)(k / 2 + 1) * (k % 2 == 0 ? AROUND : -AROUND) / pace;
    lamc_real moved = 0;
    memcpy(p->y, q, (size_t)p->nq * sizeof *q);
    for (int i = 0; i < p->beyond; i++) p->y[i] += way * u[i];
    memcpy(p->y + p->nq, u, (size_t)p->n * sizeof *u);
    if (lamc_motion_settle(motion, t, p->y, &moved) != LAMC_OK) return 0;
    const int count = prepare(motion, p, t, p->y, p->y + p->nq);
    if (count < motion->model->rank) return 0;
    solve(p, count, udot, lambda);
    for (int i = 0; i < p->n; i++) sum[i] += WEIGHTS[k / 2] * udot[i];
    for (int i = 0; i < p->m && lambda != NULL; i++) forces[i] += WEIGHTS[k / 2] * lambda[i];
  }
  memcpy(udot, sum, (size_t)p->n * sizeof *udot);
  if (lambda != NULL) memcpy(lambda, forces, (size_t)p->m * sizeof *lambda);
  return 1;
}

int lamc_loops_acceleration(const lamc_motion *motion, lamc_real t, const lamc_real *q, const lamc_real *u,
                            lamc_real *udot, lamc_real *lambda) {
  const lamc_loop_parts p = parts_of(motion);
  int count = prepare(motion, &p, t, q, u);
  if (motion->baumgarte != 0) {
    pull_back(motion, &p, q, u);
  } else if (is_near_singular(motion, &p, count)) {
    if ((p.state[4] > 0 || lamc_loop_last_pivot(motion, &p, count) < FADING) &&
        solve_around(motion, &p, t, q, u, udot, lambda)) {
      p.state[0] = (lamc_real)motion->model->rank; /* none is let go for good */
      return motion->model->rank;
    }
    /* A stage of a Runge-Kutta step is off closure by the square of the step or so; divided by the square of the last
     * pivot that is an acceleration out of nothing. On closure it is none. */
    lamc_real moved = 0;
    memcpy(p.y, q, (size_t)p.nq * sizeof *q);
    memcpy(p.y + p.nq, u, (size_t)p.n * sizeof *u);
    if (lamc_motion_settle(motion, t, p.y, &moved) == LAMC_OK) {
      count = prepare(motion, &p, t, p.y, p.y + p.nq);
    } else {
      count = prepare(motion, &p, t, q, u);
    }
  }
  if (count < motion->model->rank) p.state[2] += 1;
  solve(&p, count, udot, lambda);
  return count;
}

void lamc_loops_response(const lamc_motion *motion, int count, const lamc_real *goal, lamc_real *x) {
  const lamc_loop_parts p = parts_of(motion);
  for (int i = 0; i < p.m; i++) p.goal[i] = p.norms[i] > 0 ? goal[i] / p.norms[i] : 0;
  memcpy(p.f, x, (size_t)p.n * sizeof *x);
  lamc_loop_solve(&p, count, p.goal, p.f, x);
}

int lamc_loops_weigh(const lamc_motion *motion, lamc_real t, const lamc_real *q, const lamc_real *u) {
  const lamc_loop_parts p = parts_of(motion);
  return prepare(motion, &p, t, q, u);
}

void lamc_loops_free(const lamc_motion *motion, int count, lamc_real *x) {
  const lamc_loop_parts p = parts_of(motion);
  memset(p.x, 0, (size_t)p.n * sizeof *p.x);
  lamc_loop_along(&p, count, x, p.x);
  memcpy(x, p.x, (size_t)p.n * sizeof *x);
}

void lamc_loops_rates(const lamc_motion *motion, int count, lamc_real *x) {
  const lamc_loop_parts p = parts_of(motion);
  memcpy(p.x, x, (size_t)p.n * sizeof *x);
  memset(x, 0, (size_t)p.n * sizeof *x);
  lamc_loop_add(&p, count, p.x, x);
}

/* phi and J at q, rows of J normalised; returns the largest of phi before that, rad or parts of the size */
static lamc_real evaluate_closure(const lamc_motion *motion, const lamc_loop_parts *p, const lamc_real *q) {
  motion->model->closure(motion->constants, q, p->raw);
  memcpy(p->extra, p->raw, (size_t)p->m * sizeof *p->extra);
  memcpy(p->j, p->raw + p->m, (size_t)p->m * (size_t)p->n * sizeof *p->j);
  const lamc_real gap = largest(p->m, p->extra);
  lamc_loop_normalise(motion, p, q);
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
  motion->model->system(motion->constants, t, q, u, p.mass); /* and f */
  int count = lamc_loop_take(motion, &p);
  lamc_real gap = openness(motion, &p, count);
  for (int round = 0; round < MAX_ITERATIONS; round++) {
    if (gap <= 1) break;
    lamc_loop_solve(&p, count, p.extra, NULL, p.step);
    lamc_motion_rates(motion, q, p.step, p.qdot);
    for (int i = 0; i < p.nq; i++) q[i] += p.qdot[i];
    *moved += largest(p.n, p.step);
    open = evaluate_closure(motion, &p, q);
    count = lamc_loop_take(motion, &p);
    const lamc_real before = gap;
    gap = openness(motion, &p, count);
    if (!(gap < LAMC_R(0.5) * before)) break; /* round-off, or a singular position: no closer from here */
  }
  const lamc_real tolerance = model->tolerance / model->size;
  if (!(open <= (LOST > tolerance ? LOST : tolerance))) return LAMC_CLOSURE_LOST;
  /* Rates, by what of them opens the loops: the rest keeps its last digit */
  for (int i = 0; i < p.m; i++) p.goal[i] = lamc_dot(p.n, p.j + (ptrdiff_t)i * p.n, u);
  lamc_loop_solve(&p, count, p.goal, NULL, p.step);
  const lamc_real change = largest(p.n, p.step);
  if (change > *moved) *moved = change;
  for (int i = 0; i < p.n; i++) u[i] += p.step[i];
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
