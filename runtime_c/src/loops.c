/* loops.c, of lamc: motion under the closure of loops, redundant equations and singular positions included.
 *
 * In:    a model's M and f, or what applies them; J, gamma and phi. Out: accelerations, and states brought back to closure.
 * Never: assumes that the equations are independent; allocates. */
#include "loops.h"

#include "loop_equations.h"
#include "loop_work.h"
#include "motion.h"
#include "series.h"
#include "tolerances.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

static const int MAX_ITERATIONS = 8;
static const lamc_real MANY = 30;             /* times: round-off of all that a closure sums up, at most */
static const lamc_real NEARBY = LAMC_R(1e-3); /* rad: from there closure needs no least correction */
static const lamc_real LONG_SINGULAR = 3000;  /* steps in a row: a passage takes some hundred at 1e-13 */

long long lamc_loops_work(const lamc_model *model) {
  return model->cut_count == 0 ? 0 : lamc_loop_work_size(model);
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
static int prepare(const lamc_motion *motion, lamc_loop_parts *p, lamc_real t, const lamc_real *q,
                   const lamc_real *u) {
  if (p->has_mass) {
    motion->model->dynamics(motion->constants, t, q, u, p->mass); /* and f, J, gamma behind it */
  } else {
    motion->model->constraints(motion->constants, q, u, p->j); /* and gamma behind it */
    memcpy(p->place, q, (size_t)p->nq * sizeof *q);
  }
  lamc_loop_normalise(p, q);
  lamc_loop_count_work(p, (lamc_real)WORK_OF_CLOSURE * (lamc_real)p->n);
  return lamc_loop_take(p);
}

/* 1 if an equation is about to become dependent, or fades: the state is near a singular position */
static int is_near_singular(const lamc_loop_parts *p, int count) {
  const lamc_real share =
      p->n > LARGE ? (lamc_real)LARGE / (lamc_real)p->n : 1; /* pivots of long chains are small */
  if (lamc_loop_last_pivot(p, count) < NEAR_SINGULAR * share) return 1;
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
static lamc_real openness(const lamc_loop_parts *p, int count) {
  const lamc_real pivot = lamc_loop_last_pivot(p, count);
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
    const lamc_real rate = lamc_loop_row(p, i, u);
    if (p->norms[i] > 0) p->extra[i] += 2 * b * rate + b * b * (p->raw[i] / p->norms[i]);
  }
}

/* udot and lambda of a state that was prepared */
static void solve(const lamc_loop_parts *p, int count, lamc_real t, const lamc_real *u, lamc_real *udot,
                  lamc_real *lambda) {
  lamc_loop_accelerate(p, count, t, u, udot);
  lamc_loop_count_work(p, (lamc_real)WORK_OF_CLOSURE * (lamc_real)p->n);
  if (lambda != NULL) lamc_loop_lambda(p, count, t, u, udot, lambda);
}

/* 1 if the loops know more than angles of hinges: what is stiff must not be moved that far */
static int something_yields(const lamc_loop_parts *p) {
  for (int e = 0; e < p->pattern->row_start[p->m]; e++) {
    if (p->pattern->column[e] >= p->beyond && p->j[e] != 0) return 1;
  }
  return 0;
}

/* phi and J at q, rows of J normalised; returns the largest of phi before that, rad or parts of the size */
static lamc_real evaluate_closure(const lamc_motion *motion, const lamc_loop_parts *p, const lamc_real *q) {
  motion->model->closure(motion->constants, q, p->raw);
  memcpy(p->extra, p->raw, (size_t)p->m * sizeof *p->extra);
  memcpy(p->j, p->raw + p->m, (size_t)p->pattern->row_start[p->m] * sizeof *p->j);
  memcpy(p->place, q, (size_t)p->nq * sizeof *q);
  const lamc_real gap = largest(p->m, p->extra);
  lamc_loop_count_work(p, (lamc_real)WORK_OF_CLOSURE * (lamc_real)p->n);
  lamc_loop_normalise(p, q);
  return gap;
}

/* As lamc_motion_settle, with the work of a caller */
static lamc_status settle(const lamc_motion *motion, lamc_loop_parts *p, lamc_real t, lamc_real *y,
                          lamc_real *moved) {
  const lamc_model *model = motion->model;
  *moved = 0;
  lamc_real *q = y;
  lamc_real *u = y + p->nq;
  lamc_real open = evaluate_closure(motion, p, q);
  if (p->has_mass) {
    lamc_series_put(motion, t);
    model->system(motion->constants, t, q, u, p->mass); /* and f */
  }
  int count = lamc_loop_take(p);
  lamc_real gap = openness(p, count);
  for (int round = 0; round < MAX_ITERATIONS; round++) {
    if (gap <= 1) break;
    lamc_loop_solve(p, count, p->extra, NULL, p->step);
    lamc_motion_rates(motion, q, p->step, p->qdot);
    for (int i = 0; i < p->nq; i++) q[i] += p->qdot[i];
    const lamc_real change = largest(p->n, p->step);
    *moved += change;
    open = evaluate_closure(motion, p, q);
    count = change < NEARBY ? lamc_loop_take_nearby(p, count) : lamc_loop_take(p);
    const lamc_real before = gap;
    gap = openness(p, count);
    if (!(gap < LAMC_R(0.5) * before)) break; /* round-off, or a singular position: no closer from here */
  }
  const lamc_real tolerance = lamc_loop_gap(motion);
  if (!(open <= (LOST > tolerance ? LOST : tolerance))) return LAMC_CLOSURE_LOST;
  if (p->count < 0) count = lamc_loop_take(p); /* what was taken nearby is not exact */
  /* Rates, by what of them opens the loops: the rest keeps its last digit */
  for (int i = 0; i < p->m; i++) p->goal[i] = lamc_loop_row(p, i, u);
  lamc_loop_solve(p, count, p->goal, NULL, p->step);
  const lamc_real last = largest(p->n, p->step);
  if (last > *moved) *moved = last;
  for (int i = 0; i < p->n; i++) u[i] += p->step[i];
  p->state[0] = (lamc_real)count;
  return LAMC_OK;
}

/* What comes of places around a state */
typedef enum places { ALSO_SINGULAR, UNEVEN, SMOOTHLY } places;

/* Round-off of accelerations at a state by itself, of the largest, at most: closure has so much, and what the weakest
 * equation holds divides it twice */
static lamc_real round_off(const lamc_loop_parts *p, int count) {
  lamc_real least = lamc_loop_last_pivot(p, count);
  for (int i = 0; i < p->m; i++) {
    if (p->norms[i] > 0 && p->norms[i] < least) least = p->norms[i];
  }
  return MANY * EXACT / (least * least);
}

/* 1 if `share` times sum (n,) differs from the plain accelerations by no more than `most` of the largest of them */
static int is_alike(const lamc_loop_parts *p, const lamc_real *sum, lamc_real share, lamc_real most) {
  lamc_real off = 0;
  for (int i = 0; i < p->n; i++) off = larger(off, fabs(share * sum[i] - p->plain[i]));
  return off <= most * largest(p->n, p->plain);
}

/* As solve_around, from places that are `apart`, rad, from one to the next. ALSO_SINGULAR where one of them is singular
 * itself, or nearly so; UNEVEN where they are not the smooth motion that the state is on. */
static places solve_apart(const lamc_motion *motion, lamc_loop_parts *p, lamc_real t, const lamc_real *q,
                          const lamc_real *u, lamc_real apart, lamc_real plain_off, lamc_real *udot,
                          lamc_real *lambda) {
  static const lamc_real WEIGHTS[3] = {LAMC_R(0.75), LAMC_R(-0.3), LAMC_R(0.05)};
  const lamc_real pace = largest(p->beyond, u); /* a base stays where it is: it moves no loop */
  lamc_real *sum = p->mean, *forces = p->mean + p->n;
  memset(sum, 0, (size_t)(p->n + p->m) * sizeof *sum);
  for (int k = 0; k < 6; k++) {
    const lamc_real way = (lamc_real)(k / 2 + 1) * (k % 2 == 0 ? apart : -apart) / pace;
    lamc_real moved = 0;
    memcpy(p->y, q, (size_t)p->nq * sizeof *q);
    for (int i = 0; i < p->beyond; i++) p->y[i] += way * u[i];
    memcpy(p->y + p->nq, u, (size_t)p->n * sizeof *u);
    if (settle(motion, p, t, p->y, &moved) != LAMC_OK) return ALSO_SINGULAR;
    const int count = prepare(motion, p, t, p->y, p->y + p->nq);
    if (count < motion->model->rank || lamc_loop_is_faint(p, count, LAMC_R(0.5) * FADING))
      return ALSO_SINGULAR;
    solve(p, count, t, p->y + p->nq, udot, lambda);
    for (int i = 0; i < p->n; i++) sum[i] += WEIGHTS[k / 2] * udot[i];
    for (int i = 0; i < p->m && lambda != NULL; i++) forces[i] += WEIGHTS[k / 2] * lambda[i];
    if (k == 1 && !is_alike(p, sum, LAMC_R(0.5) / WEIGHTS[0], SMOOTH + plain_off)) return UNEVEN;
  }
  if (!is_alike(p, sum, 1, ALIKE + plain_off)) return UNEVEN;
  memcpy(udot, sum, (size_t)p->n * sizeof *udot);
  if (lambda != NULL) memcpy(lambda, forces, (size_t)p->m * sizeof *lambda);
  return SMOOTHLY;
}

/* Of large loops, in which a place around takes long: 1 if equations fade as much a little along the hinges' rates as
 * they do here. The state is then on no way through a singular position, and nothing is gained from there. Looked at
 * without closing the place, which is as far from closure as the square of the way: what is near the limit is left to
 * solve_apart. */
static int stays_faint(const lamc_motion *motion, lamc_loop_parts *p, const lamc_real *q, const lamc_real *u,
                       lamc_real apart) {
  const lamc_real way = apart / largest(p->beyond, u);
  memcpy(p->y, q, (size_t)p->nq * sizeof *q);
  for (int i = 0; i < p->beyond; i++) p->y[i] += way * u[i];
  evaluate_closure(motion, p, p->y);
  p->count = -1;
  return lamc_loop_is_faint(p, lamc_loop_order(p), LAMC_R(0.4) * FADING);
}

/* Where equations fade without their digits, such as in a linkage that passes its line, accelerations from three closed
 * places on each side along the hinges' rates, by the polynomial through them: they are smooth along a branch, and there
 * is no other way to know them from so near. Where one of the places is as near to the singular position as this one was,
 * they are taken farther apart. Motions of several freedoms pass beside the singular position as well, where accelerations
 * turn with the state within the distance from it: the places, which are farther away, then know nothing of them. The
 * state's own, in p->plain, are off by `plain_off` of themselves, and tell. Returns 0 where it is no passage; the work is
 * then that of another place. */
static int solve_around(const lamc_motion *motion, lamc_loop_parts *p, lamc_real t, const lamc_real *q,
                        const lamc_real *u, lamc_real plain_off, lamc_real *udot, lamc_real *lambda) {
  if (!(largest(p->beyond, u) > LAMC_LEAST) || something_yields(p)) return 0;
  for (int k = 2; k <= 4; k++) {
    const lamc_real apart = LAMC_R(0.5) * (lamc_real)k * AROUND;
    if (p->is_sparse && stays_faint(motion, p, q, u, apart)) continue;
    const places found = solve_apart(motion, p, t, q, u, apart, plain_off, udot, lambda);
    if (found != ALSO_SINGULAR) return found == SMOOTHLY;
  }
  return 0;
}

/* Into p->settled the state on closure, if it comes there; returns how many equations hold at it. A stage of a Runge-Kutta
 * step is off closure by the square of the step or so; divided by the square of the last pivot that is an acceleration out
 * of nothing. On closure it is none. */
static int prepare_settled(const lamc_motion *motion, lamc_loop_parts *p, lamc_real t, const lamc_real *q,
                           const lamc_real *u) {
  lamc_real moved = 0, *place = p->settled;
  memcpy(place, q, (size_t)p->nq * sizeof *q);
  memcpy(place + p->nq, u, (size_t)p->n * sizeof *u);
  if (settle(motion, p, t, place, &moved) != LAMC_OK) {
    memcpy(place, q, (size_t)p->nq * sizeof *q);
    memcpy(place + p->nq, u, (size_t)p->n * sizeof *u);
  }
  return prepare(motion, p, t, place, place + p->nq);
}

int lamc_loops_acceleration(const lamc_motion *motion, lamc_real t, const lamc_real *q, const lamc_real *u,
                            lamc_real *udot, lamc_real *lambda) {
  lamc_loop_parts p;
  lamc_loop_parts_of(motion, &p);
  const lamc_real *rates = u;
  const int rank = motion->model->rank;
  int count = prepare(motion, &p, t, q, u);
  if (motion->baumgarte != 0) {
    pull_back(motion, &p, q, u);
  } else if (is_near_singular(&p, count)) {
    const int fades = p.state[4] > 0 || lamc_loop_is_faint(&p, count, FADING);
    count = prepare_settled(motion, &p, t, q, u);
    rates = p.settled + p.nq;
    if (fades) {
      const lamc_real off = count == rank ? round_off(&p, count) : LAMC_GREATEST;
      solve(&p, count, t, rates, p.plain, NULL);
      if (solve_around(motion, &p, t, q, u, off, udot, lambda)) {
        p.state[0] = (lamc_real)rank; /* none is let go for good */
        return rank;
      }
      count = prepare(motion, &p, t, p.settled, rates);
      p.state[0] = (lamc_real)count; /* the places settled last */
    }
  }
  if (count < rank) p.state[2] += 1;
  solve(&p, count, t, rates, udot, lambda);
  return count;
}

void lamc_loops_response(const lamc_motion *motion, int count, const lamc_real *goal, lamc_real *x) {
  lamc_loop_parts p;
  lamc_loop_parts_of(motion, &p);
  for (int i = 0; i < p.m; i++) p.goal[i] = p.norms[i] > 0 ? goal[i] / p.norms[i] : 0;
  memcpy(p.step, x, (size_t)p.n * sizeof *x);
  lamc_loop_solve(&p, count, p.goal, p.step, x);
}

int lamc_loops_weigh(const lamc_motion *motion, lamc_real t, const lamc_real *q, const lamc_real *u) {
  lamc_loop_parts p;
  lamc_loop_parts_of(motion, &p);
  return prepare(motion, &p, t, q, u);
}

void lamc_loops_free(const lamc_motion *motion, int count, lamc_real *x) {
  lamc_loop_parts p;
  lamc_loop_parts_of(motion, &p);
  memset(p.x, 0, (size_t)p.n * sizeof *p.x);
  lamc_loop_along(&p, count, x, p.x);
  memcpy(x, p.x, (size_t)p.n * sizeof *x);
}

void lamc_loops_rates(const lamc_motion *motion, int count, lamc_real *x) {
  lamc_loop_parts p;
  lamc_loop_parts_of(motion, &p);
  memcpy(p.x, x, (size_t)p.n * sizeof *x);
  memset(x, 0, (size_t)p.n * sizeof *x);
  lamc_loop_add(&p, count, p.x, x);
}

lamc_status lamc_motion_settle(const lamc_motion *motion, lamc_real t, lamc_real *y, lamc_real *moved) {
  *moved = 0;
  if (motion->model->cut_count == 0) return LAMC_OK;
  lamc_loop_parts p;
  lamc_loop_parts_of(motion, &p);
  return settle(motion, &p, t, y, moved);
}

void lamc_loops_keep(const lamc_motion *motion, lamc_real *kept) {
  lamc_loop_parts p;
  lamc_loop_parts_of(motion, &p);
  memcpy(kept, p.state, LAMC_LOOPS_KEPT * sizeof *kept);
}

void lamc_loops_put_back(const lamc_motion *motion, const lamc_real *kept) {
  lamc_loop_parts p;
  lamc_loop_parts_of(motion, &p);
  memcpy(p.state, kept, LAMC_LOOPS_KEPT * sizeof *kept);
}

void lamc_loops_begin(const lamc_motion *motion) {
  lamc_loop_parts p;
  lamc_loop_parts_of(motion, &p);
  p.state[1] = p.state[2] = p.state[3] = p.state[6] = 0;
}

long long lamc_loops_doubts(const void *context) {
  lamc_loop_parts p;
  lamc_loop_parts_of((const lamc_motion *)context, &p);
  return (long long)p.state[2];
}

long long lamc_motion_singular_steps(const lamc_motion *motion) {
  if (motion->model->cut_count == 0) return 0;
  lamc_loop_parts p;
  lamc_loop_parts_of(motion, &p);
  return (long long)p.state[3];
}

lamc_real *lamc_loops_counter(const void *context) {
  lamc_loop_parts p;
  lamc_loop_parts_of((const lamc_motion *)context, &p);
  return p.state + 6;
}

lamc_real lamc_motion_work_done(const lamc_motion *motion) {
  return motion->model->cut_count == 0 ? 0 : *lamc_loops_counter(motion);
}

lamc_status lamc_loops_judge(const void *context) {
  const lamc_motion *motion = (const lamc_motion *)context;
  lamc_loop_parts p;
  lamc_loop_parts_of(motion, &p);
  const int is_singular = p.state[0] < (lamc_real)motion->model->rank;
  p.state[1] = is_singular ? p.state[1] + 1 : 0;
  if (is_singular) p.state[3] += 1;
  return p.state[1] > LONG_SINGULAR ? LAMC_RANK_LOST : LAMC_OK;
}

void lamc_loops_closure(const lamc_motion *motion, const lamc_real *q, lamc_real *closure) {
  lamc_loop_parts p;
  lamc_loop_parts_of(motion, &p);
  lamc_real *dense = closure + p.m;
  motion->model->closure(motion->constants, q, p.raw);
  memcpy(closure, p.raw, (size_t)p.m * sizeof *closure);
  memset(dense, 0, (size_t)p.m * (size_t)p.n * sizeof *dense);
  for (int i = 0; i < p.m; i++) {
    for (int e = p.pattern->row_start[i]; e < p.pattern->row_start[i + 1]; e++) {
      dense[(ptrdiff_t)i * p.n + p.pattern->column[e]] = p.raw[p.m + e];
    }
  }
}
