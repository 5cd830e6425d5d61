/* loop_equations.h, of lamc: which equations of the loops hold at a state, and what they impose on rates and accelerations.
 *
 * In:    the factor of M and the rows of J in the work array. Out: directions, accelerations on them, multipliers.
 * Never: calls a model; assumes that the equations are independent; allocates.
 *
 * M = L L^T. The columns of W = L^-1 J^T are the equations in the mass metric; a QR with column pivoting orders them
 * by what each adds, and stops at the rank of a generic position or where the rest is below 1e-6 of the first.
 * Redundant equations differ from their partners at the level of drift only, so a test at machine precision would take
 * them in and lock the mechanism. Forces then have the smallest norm, as they have in a compliant mechanism of equal
 * joints. */
#ifndef LAMC_LOOP_EQUATIONS_H
#define LAMC_LOOP_EQUATIONS_H

#include "cholesky.h"
#include "lamc.h"
#include "tolerances.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

/* The parts of the work array */
typedef struct lamc_loop_parts {
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
                    with too few, steps with too few, the weight of J^T J */
  lamc_real *norms; /* (m,): of the rows of J before they were divided by them; 0: a row of none */
  lamc_real *raw;   /* what the model writes: the largest of its functions */
} lamc_loop_parts;

static void lamc_loop_swap(lamc_real *a, lamc_real *b, int count) {
  for (int i = 0; i < count; i++) {
    const lamc_real keep = a[i];
    a[i] = b[i];
    b[i] = keep;
  }
}

enum { LAMC_PLAIN_METRIC = 0, LAMC_MASS_METRIC = 1 };

/* Orthonormal directions of the equations, at most `rank` and none below `tolerance` of the first; returns how many
 * were taken. Modified Gram-Schmidt with the largest column next. */
static int lamc_loop_decompose(const lamc_loop_parts *p, int rank, int metric, lamc_real tolerance) {
  for (int i = 0; i < p->m; i++) {
    lamc_real *w = p->q + (ptrdiff_t)i * p->n;
    memcpy(w, p->j + (ptrdiff_t)i * p->n, (size_t)p->n * sizeof *w);
    if (metric == LAMC_MASS_METRIC) lamc_solve_lower(p->n, p->l, w);
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
      lamc_loop_swap(p->q + (ptrdiff_t)k * p->n, p->q + (ptrdiff_t)best * p->n, p->n);
      lamc_loop_swap(p->order + k, p->order + best, 1);
      for (int row = 0; row < k; row++)
        lamc_loop_swap(p->r + (ptrdiff_t)row * p->m + k, p->r + (ptrdiff_t)row * p->m + best, 1);
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

/* Rows of J of length one, and what is in `extra` with them: an equation that fades in a flat position, with all its
 * digits, is as good as any. A row of nothing, which a geometry makes and round-off fills, or a misfit that was accepted,
 * becomes noughts: an axis that is off by the gap tilts equations by some gaps. */
static void lamc_loop_normalise(const lamc_motion *motion, const lamc_loop_parts *p) {
  const lamc_real least = 64 * LAMC_EPSILON + 10 * (motion->model->tolerance / motion->model->size);
  for (int i = 0; i < p->m; i++) {
    lamc_real *row = p->j + (ptrdiff_t)i * p->n;
    const lamc_real norm = sqrt(lamc_dot(p->n, row, row));
    const lamc_real scale = norm > least ? 1 / norm : 0;
    p->norms[i] = scale > 0 ? norm : 0;
    for (int c = 0; c < p->n; c++) row[c] *= scale;
    p->extra[i] *= scale;
  }
}

/* A mass that J^T J is multiplied by: that of a hinge, in the mean */
static lamc_real lamc_loop_weight(const lamc_loop_parts *p) {
  lamc_real sum = 0;
  for (int i = 0; i < p->n; i++) sum += p->raw[(ptrdiff_t)i * (i + 1) / 2 + i];
  return sum / (lamc_real)p->n;
}

/* L of M + weight J^T J, M in raw. Hinges that close loops move no mass of their own; where J udot is given, the sum
 * has the same udot, and is regular. */
static void lamc_loop_factor(const lamc_loop_parts *p) {
  const lamc_real weight = lamc_loop_weight(p);
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

/* Directions in the mass metric of the equations that hold here. Where an equation fades at a singular position, with
 * pivot s of the first, round-off turns the tangent of the branch by round-off / s^2, so it cannot be used all the way.
 * Doing without it leaves the branch to the forces, which turns rates by s or so. Both are least at some 1e-5 (measured:
 * a swing through flat that gravity drives keeps 1e-11; at 3e-4 it kept 1e-8). With one equation go all that fade with
 * it: the order of small pivots changes from stage to stage, and with it which directions are held.
 * Fading must show in the plain metric too: beside a light body pivots are small everywhere in the mass metric, as beside
 * a small loop in the plain one. */
static int lamc_loop_take(const lamc_motion *motion, const lamc_loop_parts *p) {
  const int rank = motion->model->rank;
  if (lamc_loop_decompose(p, rank, LAMC_MASS_METRIC, PASSING) == rank) return rank;
  int most = lamc_loop_decompose(p, rank, LAMC_PLAIN_METRIC, PASSING);
  if (most < rank) {
    const int by_mass = lamc_loop_decompose(p, rank, LAMC_MASS_METRIC, TOGETHER);
    most = lamc_loop_decompose(p, rank, LAMC_PLAIN_METRIC, TOGETHER);
    most = by_mass > most ? by_mass : most;
  }
  return lamc_loop_decompose(p, most, LAMC_MASS_METRIC, RANK_TOLERANCE);
}

/* x such that the taken equations have the values -goal: components g along the directions, added to x after what x
 * has along them is removed. */
static void lamc_loop_impose(const lamc_loop_parts *p, int count, const lamc_real *goal, lamc_real *x) {
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

/* The last pivot of the first; 0 where an equation was let go, 1 where there is none */
static lamc_real lamc_loop_last_pivot(const lamc_motion *motion, const lamc_loop_parts *p, int count) {
  if (count < motion->model->rank) return 0;
  return count > 0 ? p->r[(ptrdiff_t)(count - 1) * p->m + (count - 1)] / p->r[0] : 1;
}

/* lambda (m,) by the model's equations from x = L^T udot: R lambda = Q^T (x - L^-1 f) for the taken ones, and what the
 * added J^T J takes of the forces, J udot = -gamma, from all */
static void lamc_loop_lambda(const lamc_loop_parts *p, int count, const lamc_real *x, lamc_real *lambda) {
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

#endif /* LAMC_LOOP_EQUATIONS_H */
