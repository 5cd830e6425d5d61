/* loops.c, of lamc: motion under the closure of loops, redundant equations and singular positions included.
 *
 * In:    M, f, J, gamma and phi from a model. Out: accelerations, and states brought back to closure.
 * Never: assumes that the equations are independent; allocates.
 *
 * M = L L^T. The columns of W = L^-1 J^T are the equations in the mass metric; a QR with column pivoting orders them
 * by what each adds, and stops at the rank of a generic position or where the rest is below 1e-6 of the first.
 * Redundant equations differ from their partners at the level of drift only, so a test at machine precision would take
 * them in and lock the mechanism. Forces then have the smallest norm, as they have in a compliant mechanism of equal
 * joints. */
#include "loops.h"

#include "cholesky.h"
#include "motion.h"
#include "tolerances.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

static const int MAX_ITERATIONS = 8;
static const lamc_real LONG_SINGULAR = 3000; /* steps in a row: a passage takes some hundred at 1e-13 */

/* The parts of the work array */
typedef struct parts {
  int n, m;         /* rates, equations */
  int nq;           /* coordinates */
  lamc_real *l;     /* (n, n): Cholesky factor, lower */
  lamc_real *f;     /* (n,) */
  lamc_real *j;     /* (m, n) */
  lamc_real *extra; /* (m,): phi or gamma, by what was asked last */
  lamc_real
      *q; /* (m, n): row k is the k-th orthonormal direction; before, the equations in the mass metric */
  lamc_real *r;     /* (m, m): r[k m + i], the part of equation i along direction k */
  lamc_real *g;     /* (m,) */
  lamc_real *order; /* (m,): the equation that direction k was taken from, a whole number */
  lamc_real *x;     /* (n,) */
  lamc_real *qdot;  /* (nq,) */
  lamc_real *y;     /* (nq + n,): a settled copy of a state */
  lamc_real *
      state; /* (LAMC_LOOPS_KEPT,): equations taken when a state was last settled, steps in a row with too few, accelerations
                    with too few, steps with too few */
  lamc_real *norms; /* (m,): of the rows of J before they were divided by them; 0: a row of none */
  lamc_real *raw;  /* what the model writes: the largest of its functions */
} parts;

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

static parts parts_of(const lamc_motion *motion) {
  parts p;
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

static void swap(lamc_real *a, lamc_real *b, int count) {
  for (int i = 0; i < count; i++) {
    const lamc_real keep = a[i];
    a[i] = b[i];
    b[i] = keep;
  }
}

enum { PLAIN_METRIC = 0, MASS_METRIC = 1 };

/* Orthonormal directions of the equations, at most `rank` and none below `tolerance` of the first; returns how many
 * were taken. Modified Gram-Schmidt with the largest column next. */
static int decompose(const parts *p, int rank, int metric, lamc_real tolerance) {
  for (int i = 0; i < p->m; i++) {
    lamc_real *w = p->q + (ptrdiff_t)i * p->n;
    memcpy(w, p->j + (ptrdiff_t)i * p->n, (size_t)p->n * sizeof *w);
    if (metric == MASS_METRIC) lamc_solve_lower(p->n, p->l, w);
    p->order[i] = (lamc_real)i;
  }
  const int most = rank < p->n ? rank : p->n;
  lamc_real first = 0;
  for (int k = 0; k < most; k++) {
    int best = k;
    lamc_real best_norm = -1;
    for (int i = k; i < p->m; i++) {
      const lamc_real *w = p->q + (ptrdiff_t)i * p->n;
      const lamc_real norm = lamc_dot(p->n, w, w);
      if (norm > best_norm) {
        best_norm = norm;
        best = i;
      }
    }
    const lamc_real length = sqrt(best_norm);
    if (k == 0) first = length;
    if (!(length > tolerance * first)) return k;
    if (best != k) {
      swap(p->q + (ptrdiff_t)k * p->n, p->q + (ptrdiff_t)best * p->n, p->n);
      swap(p->order + k, p->order + best, 1);
      for (int row = 0; row < k; row++)
        swap(p->r + (ptrdiff_t)row * p->m + k, p->r + (ptrdiff_t)row * p->m + best, 1);
    }
    lamc_real *direction = p->q + (ptrdiff_t)k * p->n;
    for (int i = 0; i < p->n; i++) direction[i] /= length;
    p->r[(ptrdiff_t)k * p->m + k] = length;
    for (int i = k + 1; i < p->m; i++) {
      lamc_real *w = p->q + (ptrdiff_t)i * p->n;
      const lamc_real along = lamc_dot(p->n, direction, w);
      p->r[(ptrdiff_t)k * p->m + i] = along;
      for (int c = 0; c < p->n; c++) w[c] -= along * direction[c];
    }
  }
  return most;
}

/* Directions in the mass metric of the equations that hold here. Where an equation fades at a singular position, with
 * pivot s of the first, round-off turns the tangent of the branch by round-off / s^2, so it cannot be used all the way.
 * Doing without it leaves the branch to the forces, which turns rates by s or so. Both are least at some 1e-5 (measured:
 * a swing through flat that gravity drives keeps 1e-11; at 3e-4 it kept 1e-8). With one equation go all that fade with
 * it: the order of small pivots changes from stage to stage, and with it which directions are held.
 * Fading must show in the plain metric too: beside a light body pivots are small everywhere in the mass metric, as beside
 * a small loop in the plain one. */
static int take_equations(const lamc_motion *motion, const parts *p) {
  const int rank = motion->model->rank;
  if (decompose(p, rank, MASS_METRIC, PASSING) == rank) return rank;
  int most = decompose(p, rank, PLAIN_METRIC, PASSING);
  if (most < rank) {
    const int by_mass = decompose(p, rank, MASS_METRIC, TOGETHER);
    most = decompose(p, rank, PLAIN_METRIC, TOGETHER);
    most = by_mass > most ? by_mass : most;
  }
  return decompose(p, most, MASS_METRIC, RANK_TOLERANCE);
}

/* x such that the taken equations have the values -goal: components g along the directions, added to x after what x
 * has along them is removed. */
static void impose(const parts *p, int count, const lamc_real *goal, lamc_real *x) {
  for (int k = 0; k < count; k++) {
    lamc_real rest = -goal[(int)p->order[k]];
    for (int i = 0; i < k; i++) rest -= p->r[(ptrdiff_t)i * p->m + k] * p->g[i];
    p->g[k] = rest / p->r[(ptrdiff_t)k * p->m + k];
  }
  for (int k = 0; k < count; k++) {
    const lamc_real *direction = p->q + (ptrdiff_t)k * p->n;
    const lamc_real change = p->g[k] - lamc_dot(p->n, direction, x);
    for (int i = 0; i < p->n; i++) x[i] += change * direction[i];
  }
}

/* Rows of J of length one, and what is in `extra` with them: an equation that fades in a flat position, with all its
 * digits, is as good as any. A row of nothing stays so. */
static void normalise(const parts *p) {
  for (int i = 0; i < p->m; i++) {
    lamc_real *row = p->j + (ptrdiff_t)i * p->n;
    const lamc_real norm = sqrt(lamc_dot(p->n, row, row));
    const lamc_real scale = norm > LAMC_LEAST ? 1 / norm : 0;
    p->norms[i] = norm;
    for (int c = 0; c < p->n; c++) row[c] *= scale;
    p->extra[i] *= scale;
  }
}

/* A mass that J^T J is multiplied by: that of a hinge, in the mean */
static lamc_real weight_of(const parts *p) {
  lamc_real sum = 0;
  for (int i = 0; i < p->n; i++) sum += p->raw[(ptrdiff_t)i * (i + 1) / 2 + i];
  return sum / (lamc_real)p->n;
}

/* L of M + weight J^T J, M in raw. Hinges that close loops move no mass of their own; where J udot is given, the sum
 * has the same udot, and is regular. */
static void factor(const parts *p) {
  const lamc_real weight = weight_of(p);
  for (int k = 0; k < p->m; k++) {
    const lamc_real *row = p->j + (ptrdiff_t)k * p->n;
    for (int i = 0; i < p->n; i++) {
      const lamc_real part = weight * row[i];
      if (part == 0) continue;
      lamc_real *entries = p->raw + (ptrdiff_t)i * (i + 1) / 2;
      for (int j = 0; j <= i; j++) entries[j] += part * row[j];
    }
  }
  p->state[4] = weight;
  lamc_cholesky(p->n, p->raw, p->l);
}

/* L, and f, at a state, after its closure */
static void evaluate_system(const lamc_motion *motion, const parts *p, lamc_real t, const lamc_real *q,
                            const lamc_real *u) {
  motion->model->system(motion->constants, t, q, u, p->raw);
  memcpy(p->f, p->raw + (ptrdiff_t)p->n * (p->n + 1) / 2, (size_t)p->n * sizeof *p->f);
  factor(p);
}

/* L, f, J, gamma and the directions at a state; returns how many equations were taken */
static int prepare(const lamc_motion *motion, const parts *p, lamc_real t, const lamc_real *q,
                   const lamc_real *u) {
  const size_t n = (size_t)p->n, entries = (size_t)p->m * n;
  const lamc_real *f = p->raw + n * (n + 1) / 2, *jacobian = f + n;
  motion->model->dynamics(motion->constants, t, q, u, p->raw);
  memcpy(p->f, f, n * sizeof *p->f);
  memcpy(p->j, jacobian, entries * sizeof *p->j);
  memcpy(p->extra, jacobian + entries, (size_t)p->m * sizeof *p->extra);
  normalise(p);
  factor(p);
  return take_equations(motion, p);
}

/* The last pivot of the first; 0 where an equation was let go, 1 where there is none */
static lamc_real last_pivot(const lamc_motion *motion, const parts *p, int count) {
  if (count < motion->model->rank) return 0;
  return count > 0 ? p->r[(ptrdiff_t)(count - 1) * p->m + (count - 1)] / p->r[0] : 1;
}

/* 1 if an equation is about to become dependent, or fades: the state is near a singular position */
static int is_near_singular(const lamc_motion *motion, const parts *p, int count) {
  if (last_pivot(motion, p, count) < NEAR_SINGULAR) return 1;
  for (int i = 0; i < p->m; i++) {
    if (p->norms[i] < NEAR_SINGULAR) return 1;
  }
  return 0;
}

/* How far from closure, of the size, a state may be: what it is off, divided by the square of the last pivot, is an
 * acceleration out of nothing. No more is asked for: beside a light part, such as a mode of a link that bends, pivots
 * are small everywhere, and what moves such a part by its last digit is an acceleration out of nothing as well. */
static lamc_real close_enough(const lamc_motion *motion, const parts *p, int count) {
  const lamc_real pivot = last_pivot(motion, p, count);
  const lamc_real enough = OUT_OF_NOTHING * pivot * pivot;
  if (enough > CLOSED) return CLOSED;
  return enough > EXACT ? enough : EXACT;
}

/* lambda (m,) by the model's equations from x = L^T udot: R lambda = Q^T (x - L^-1 f) for the taken ones, and what the
 * added J^T J takes of the forces, J udot = -gamma, from all */
static void find_lambda(const parts *p, int count, const lamc_real *x, lamc_real *lambda) {
  memset(lambda, 0, (size_t)p->m * sizeof *lambda);
  memcpy(p->x, p->f, (size_t)p->n * sizeof *p->x);
  lamc_solve_lower(p->n, p->l, p->x);
  for (int i = 0; i < p->n; i++) p->x[i] = x[i] - p->x[i];
  for (int k = count - 1; k >= 0; k--) {
    lamc_real rest = lamc_dot(p->n, p->q + (ptrdiff_t)k * p->n, p->x);
    for (int i = k + 1; i < count; i++) rest -= p->r[(ptrdiff_t)k * p->m + i] * lambda[(int)p->order[i]];
    lambda[(int)p->order[k]] = rest / p->r[(ptrdiff_t)k * p->m + k];
  }
  for (int i = 0; i < p->m; i++) {
    lambda[i] += p->state[4] * p->extra[i];
    lambda[i] = p->norms[i] > LAMC_LEAST ? lambda[i] / p->norms[i] : 0;
  }
}

/* Baumgarte's stabilisation: with b the rate, gamma + 2 b J u + b^2 phi in place of gamma */
static void pull_back(const lamc_motion *motion, const parts *p, const lamc_real *q, const lamc_real *u) {
  const lamc_real b = motion->baumgarte;
  motion->model->closure(motion->constants, q, p->raw);
  for (int i = 0; i < p->m; i++) {
    const lamc_real rate = lamc_dot(p->n, p->j + (ptrdiff_t)i * p->n, u);
    if (p->norms[i] > LAMC_LEAST) p->extra[i] += 2 * b * rate + b * b * (p->raw[i] / p->norms[i]);
  }
}

int lamc_loops_acceleration(const lamc_motion *motion, lamc_real t, const lamc_real *q, const lamc_real *u,
                            lamc_real *udot, lamc_real *lambda) {
  const parts p = parts_of(motion);
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
  impose(&p, count, p.extra, udot);
  if (lambda != NULL) find_lambda(&p, count, udot, lambda);
  lamc_solve_upper(p.n, p.l, udot);
  return count;
}

void lamc_loops_response(const lamc_motion *motion, int count, const lamc_real *goal, lamc_real *x) {
  const parts p = parts_of(motion);
  lamc_solve_lower(p.n, p.l, x);
  impose(&p, count, goal, x);
  lamc_solve_upper(p.n, p.l, x);
}

int lamc_loops_weigh(const lamc_motion *motion, lamc_real t, const lamc_real *q, const lamc_real *u) {
  const parts p = parts_of(motion);
  return prepare(motion, &p, t, q, u);
}

void lamc_loops_free(const lamc_motion *motion, int count, lamc_real *x) {
  const parts p = parts_of(motion);
  lamc_solve_lower(p.n, p.l, x);
  for (int k = 0; k < count; k++) {
    const lamc_real *direction = p.q + (ptrdiff_t)k * p.n;
    const lamc_real along = lamc_dot(p.n, direction, x);
    for (int i = 0; i < p.n; i++) x[i] -= along * direction[i];
  }
}

void lamc_loops_rates(const lamc_motion *motion, lamc_real *x) {
  const parts p = parts_of(motion);
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
static lamc_real evaluate_closure(const lamc_motion *motion, const parts *p, const lamc_real *q) {
  motion->model->closure(motion->constants, q, p->raw);
  memcpy(p->extra, p->raw, (size_t)p->m * sizeof *p->extra);
  memcpy(p->j, p->raw + p->m, (size_t)p->m * (size_t)p->n * sizeof *p->j);
  const lamc_real gap = largest(p->m, p->extra);
  normalise(p);
  return gap;
}

lamc_status lamc_motion_settle(const lamc_motion *motion, lamc_real t, lamc_real *y, lamc_real *moved) {
  const lamc_model *model = motion->model;
  const parts p = parts_of(motion);
  lamc_real *q = y;
  lamc_real *u = y + p.nq;
  *moved = 0;
  if (model->cut_count == 0) return LAMC_OK;
  lamc_real open = evaluate_closure(motion, &p, q);
  evaluate_system(motion, &p, t, q, u);
  int count = take_equations(motion, &p);
  lamc_real gap = largest(p.m, p.extra);
  for (int round = 0; round < MAX_ITERATIONS; round++) {
    if (gap <= close_enough(motion, &p, count)) break;
    memset(p.x, 0, (size_t)p.n * sizeof *p.x);
    impose(&p, count, p.extra, p.x);
    lamc_solve_upper(p.n, p.l, p.x);
    lamc_motion_rates(motion, q, p.x, p.qdot);
    for (int i = 0; i < p.nq; i++) q[i] += p.qdot[i];
    *moved += largest(p.n, p.x);
    open = evaluate_closure(motion, &p, q);
    count = take_equations(motion, &p);
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
  impose(&p, count, p.extra, p.x);
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
  const parts p = parts_of(motion);
  memcpy(kept, p.state, LAMC_LOOPS_KEPT * sizeof *kept);
}

void lamc_loops_put_back(const lamc_motion *motion, const lamc_real *kept) {
  const parts p = parts_of(motion);
  memcpy(p.state, kept, LAMC_LOOPS_KEPT * sizeof *kept);
}

void lamc_loops_begin(const lamc_motion *motion) {
  const parts p = parts_of(motion);
  p.state[1] = p.state[2] = p.state[3] = 0;
}

long long lamc_loops_doubts(const void *context) {
  const parts p = parts_of((const lamc_motion *)context);
  return (long long)p.state[2];
}

long long lamc_motion_singular_steps(const lamc_motion *motion) {
  return motion->model->cut_count > 0 ? (long long)parts_of(motion).state[3] : 0;
}

lamc_status lamc_loops_judge(const void *context) {
  const lamc_motion *motion = (const lamc_motion *)context;
  const parts p = parts_of(motion);
  const int is_singular = p.state[0] < (lamc_real)motion->model->rank;
  p.state[1] = is_singular ? p.state[1] + 1 : 0;
  if (is_singular) p.state[3] += 1;
  return p.state[1] > LONG_SINGULAR ? LAMC_RANK_LOST : LAMC_OK;
}
