/* loop_equations.h, of lamc: which equations of the loops hold at a state, and what they leave free.
 *
 * In:    M, f and the rows of J in the work array. Out: free directions, accelerations along them, multipliers.
 * Never: calls a model; assumes that the equations are independent; allocates.
 *
 * Gauss's elimination of J with complete pivoting orders the equations by what each adds, and stops at the rank of a
 * generic position or where the rest is below 3e-5 of the first. Redundant equations differ from their partners at the
 * level of drift only, so a test at machine precision would take them in and lock the mechanism. With J = L (U, V) the
 * rows of N = (-U^-1 V, 1)^T are motions that keep the loops closed, and N^T M N is small, and regular: hinges that close
 * loops move no mass of their own (null-space method; R. A. Wehage and E. J. Haug, 1982). */
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
  int cut, beyond;  /* rates cut <= i < beyond have no mass of their own */
  lamc_real *mass;  /* (n (n + 1) / 2,): M, its lower triangle by rows */
  lamc_real *f;     /* (n,) */
  lamc_real *j;     /* (m, n): rows that were short or long with entries up to one */
  lamc_real *extra; /* (m,): phi or gamma, by what was asked last; divided as the rows */
  lamc_real *a; /* (m, n): J with rows and columns in order: the multipliers of elimination below U and V */
  lamc_real *rows;    /* (m,): the equation that row k of `a` is, a whole number */
  lamc_real *columns; /* (n,): the rate that column k of `a` is, likewise */
  lamc_real *peak;    /* (m,): the largest entry of row k of `a` that is left, in large loops */
  lamc_real *filled;  /* (m,): how many entries of row k that are left are not zero, likewise */
  lamc_real *free;    /* (n, n): as many rows as there are free directions */
  lamc_real *l;       /* (n, n): of N^T M N = L L^T */
  lamc_real *x;       /* (n,) */
  lamc_real *z;       /* (n,) */
  lamc_real *goal;    /* (m,) */
  lamc_real *qdot;    /* (nq,) */
  lamc_real *y;       /* (nq + n,): a settled copy of a state */
  lamc_real *
      state; /* (LAMC_LOOPS_KEPT,): equations taken when a state was last settled, steps in a row with too few,
                          accelerations with too few, steps with too few, 1 where a row of J fades */
  lamc_real *norms; /* (m,): what rows of J were divided by; 0: a row of none */
  lamc_real *reach; /* (m,): the largest angle that the row knows, rad */
  lamc_real *mean;  /* (n + m,): accelerations and multipliers from places around */
  lamc_real *step;  /* (n,): of a state that is brought to closure */
  lamc_real *raw;   /* what the model writes: the largest of its functions */
} lamc_loop_parts;

/* The largest angle that row i of J knows, rad: what fades as these angles do keeps its digits, and what fades elsewhere,
 * such as in a linkage that has turned into a line, does not */
static lamc_real lamc_loop_reach(const lamc_loop_parts *p, int i, const lamc_real *q) {
  const lamc_real *row = p->j + (ptrdiff_t)i * p->n;
  lamc_real largest = 0;
  for (int c = 0; c < p->n; c++) {
    if (row[c] != 0 && fabs(q[c]) > largest) largest = fabs(q[c]);
  }
  return largest;
}

/* 1 if row i of J is shorter than `tolerance`, by angles of one rad or more, or as much shorter than smaller ones */
static int lamc_loop_fades(const lamc_loop_parts *p, int i, lamc_real tolerance) {
  const lamc_real reach = p->reach[i] < 1 ? p->reach[i] : 1;
  return p->norms[i] > 0 && p->norms[i] < tolerance * reach;
}

/* The rows that are not plain, by what `norms` says; those that are to be let go stay as long as they are */
static void lamc_loop_divide(const lamc_loop_parts *p, lamc_real least) {
  int fades = 0;
  for (int i = 0; i < p->m; i++) fades |= lamc_loop_fades(p, i, PASSING);
  for (int i = 0; i < p->m; i++) {
    if (fades && lamc_loop_fades(p, i, TOGETHER)) p->norms[i] = 1;
    if (p->norms[i] == 1) continue;
    const lamc_real scale = 1 / (p->norms[i] > 0 ? p->norms[i] : least);
    lamc_real *row = p->j + (ptrdiff_t)i * p->n;
    for (int c = 0; c < p->n; c++) row[c] *= scale;
    p->extra[i] *= scale;
  }
}

/* Rows of J that are short or long, and what is in `extra` with them, divided by their largest entry: an equation that
 * fades in a flat position, with all its digits, is as good as any. What is left of a misfit, or of round-off, is not made
 * large; nor is what fades without its digits, to be let go. */
static void lamc_loop_normalise(const lamc_motion *motion, const lamc_loop_parts *p, const lamc_real *q) {
  const lamc_real misfit = OF_MISFIT * motion->model->tolerance / motion->model->size;
  const lamc_real least = misfit > NO_EQUATION ? misfit : NO_EQUATION;
  int fades = 0, odd = 0;
  for (int i = 0; i < p->m; i++) {
    const lamc_real *row = p->j + (ptrdiff_t)i * p->n;
    lamc_real norm = 0;
    for (int c = 0; c < p->n; c++) {
      if (fabs(row[c]) > norm) norm = fabs(row[c]);
    }
    const int plain = norm > LAMC_R(0.25) && norm < 4;
    p->norms[i] = plain ? 1 : norm > least ? norm : 0;
    p->reach[i] = 1;
    odd |= !plain;
    if (norm > least && norm < FADING) {
      p->reach[i] = lamc_loop_reach(p, i, q);
      fades |= lamc_loop_fades(p, i, FADING);
    }
  }
  p->state[4] = (lamc_real)fades;
  if (odd) lamc_loop_divide(p, least);
}

static void lamc_loop_swap(lamc_real *a, lamc_real *b, int count, int stride) {
  for (int i = 0; i < count; i++) {
    const lamc_real keep = a[(ptrdiff_t)i * stride];
    a[(ptrdiff_t)i * stride] = b[(ptrdiff_t)i * stride];
    b[(ptrdiff_t)i * stride] = keep;
  }
}

enum {
  LARGE = 10
}; /* rates: from here on most entries of J are zero (measured: a folding box of 16 takes 2/3 of it) */

/* Takes what pivot k has from the rows below; where the largest that is left is, as a place in `a` */
static int lamc_loop_eliminate(const lamc_loop_parts *p, int k) {
  const int n = p->n;
  const lamc_real *pivot = p->a + (ptrdiff_t)k * n;
  const lamc_real inverse = 1 / pivot[k];
  lamc_real most = -1;
  int best = 0;
  for (int i = k + 1; i < p->m; i++) {
    lamc_real *ai = p->a + (ptrdiff_t)i * n;
    const lamc_real part = ai[k] *= inverse;
    for (int c = k + 1; c < n; c++) {
      const lamc_real left = ai[c] -= part * pivot[c];
      const int larger = fabs(left) > most;
      most = larger ? fabs(left) : most;
      best = larger ? i * n + c : best;
    }
  }
  return best;
}

/* In large loops: among the rows whose largest is at least a tenth of the largest of all, the one with the fewest entries
 * comes next, so that few rows fill up; where its largest is */
static int lamc_loop_sparsest(const lamc_loop_parts *p, int k) {
  lamc_real most = 0;
  int row = k;
  for (int i = k; i < p->m; i++) most = p->peak[i] > most ? p->peak[i] : most;
  for (int i = k; i < p->m; i++) {
    const int is_better = p->peak[row] < LAMC_R(0.1) * most || p->filled[i] < p->filled[row];
    if (p->peak[i] >= LAMC_R(0.1) * most && is_better) row = i;
  }
  const lamc_real *next = p->a + (ptrdiff_t)row * p->n;
  int column = k;
  for (int c = k + 1; c < p->n; c++) column = fabs(next[c]) > fabs(next[column]) ? c : column;
  return row * p->n + column;
}

/* Of row i from column k on: its largest, and how many entries are not zero */
static void lamc_loop_look(const lamc_loop_parts *p, int i, int k) {
  const lamc_real *ai = p->a + (ptrdiff_t)i * p->n;
  lamc_real most = 0;
  int filled = 0;
  for (int c = k; c < p->n; c++) {
    most = fabs(ai[c]) > most ? fabs(ai[c]) : most;
    filled += ai[c] != 0;
  }
  p->peak[i] = most;
  p->filled[i] = (lamc_real)filled;
}

/* The same in large loops: rows that do not know the pivot stay as they are */
static int lamc_loop_eliminate_sparse(const lamc_loop_parts *p, int k) {
  const int n = p->n;
  const lamc_real *pivot = p->a + (ptrdiff_t)k * n;
  const lamc_real inverse = 1 / pivot[k];
  for (int i = k + 1; i < p->m; i++) {
    lamc_real *ai = p->a + (ptrdiff_t)i * n;
    if (ai[k] == 0) continue;
    const lamc_real part = ai[k] *= inverse;
    for (int c = k + 1; c < n; c++) ai[c] -= part * pivot[c];
    lamc_loop_look(p, i, k + 1);
  }
  return lamc_loop_sparsest(p, k + 1);
}

/* J as it is into `a`; where its largest is */
static int lamc_loop_copy(const lamc_loop_parts *p) {
  lamc_real most = -1;
  int best = 0;
  for (int i = 0; i < p->m * p->n; i++) {
    p->a[i] = p->j[i];
    const int larger = fabs(p->j[i]) > most;
    most = larger ? fabs(p->j[i]) : most;
    best = larger ? i : best;
  }
  for (int i = 0; i < p->m; i++) {
    p->rows[i] = (lamc_real)i;
    if (p->n > LARGE) lamc_loop_look(p, i, 0);
  }
  for (int c = 0; c < p->n; c++) p->columns[c] = (lamc_real)c;
  return p->n > LARGE ? lamc_loop_sparsest(p, 0) : best;
}

static lamc_real lamc_loop_pivot(const lamc_loop_parts *p, int k) {
  return fabs(p->a[(ptrdiff_t)k * p->n + k]);
}

/* How many equations hold here, at most `rank`. Where one fades at a singular position, with pivot s of the first,
 * round-off turns the tangent of the branch by round-off / s^2, so it cannot be used all the way. Doing without it leaves
 * the branch to the forces, which turns rates by s or so. Both are least at some 1e-5. With one equation go all that fade
 * with it: the order of small pivots changes from stage to stage, and with it which directions are held. */
static int lamc_loop_order(const lamc_loop_parts *p, int rank) {
  const int n = p->n, most = rank < n ? rank : n;
  int count = 0, best = lamc_loop_copy(p);
  for (; count < most; count++) {
    const int row = best / n, column = best % n;
    if (row != count) {
      lamc_loop_swap(p->a + (ptrdiff_t)count * n, p->a + (ptrdiff_t)row * n, n, 1);
      lamc_loop_swap(p->rows + count, p->rows + row, 1, 1);
      lamc_loop_swap(p->peak + count, p->peak + row, 1, 1);
      lamc_loop_swap(p->filled + count, p->filled + row, 1, 1);
    }
    if (column != count) {
      lamc_loop_swap(p->a + count, p->a + column, p->m, n);
      lamc_loop_swap(p->columns + count, p->columns + column, 1, 1);
    }
    if (!(lamc_loop_pivot(p, count) > PASSING * lamc_loop_pivot(p, 0))) break;
    if (count + 1 < most) {
      best = n > LARGE ? lamc_loop_eliminate_sparse(p, count) : lamc_loop_eliminate(p, count);
    }
  }
  while (count < most && count > 0 && lamc_loop_pivot(p, count - 1) < TOGETHER * lamc_loop_pivot(p, 0))
    count--;
  return count;
}

/* x (n,) such that the taken equations have the values -goal (m,), with nothing along the free rates */
static void lamc_loop_impose(const lamc_loop_parts *p, int count, const lamc_real *goal, lamc_real *x) {
  const int n = p->n;
  lamc_real *y = p->z;
  memset(x, 0, (size_t)n * sizeof *x);
  for (int k = 0; k < count; k++) {
    y[k] = -goal[(int)p->rows[k]] - lamc_dot(k, p->a + (ptrdiff_t)k * n, y);
  }
  for (int k = count - 1; k >= 0; k--) {
    const lamc_real *row = p->a + (ptrdiff_t)k * n;
    for (int i = k + 1; i < count; i++) y[k] -= row[i] * y[i];
    y[k] /= row[k];
    x[(int)p->columns[k]] = y[k];
  }
}

/* N: the rows of `free` */
static void lamc_loop_find_free(const lamc_loop_parts *p, int count) {
  const int n = p->n;
  lamc_real *y = p->z;
  memset(p->free, 0, (size_t)(n - count) * (size_t)n * sizeof *p->free);
  for (int c = count; c < n; c++) {
    lamc_real *direction = p->free + (ptrdiff_t)(c - count) * n;
    direction[(int)p->columns[c]] = 1;
    for (int k = count - 1; k >= 0; k--) {
      const lamc_real *row = p->a + (ptrdiff_t)k * n;
      lamc_real rest = -row[c];
      for (int i = k + 1; i < count; i++) rest -= row[i] * y[i];
      y[k] = rest / row[k];
      direction[(int)p->columns[k]] = y[k];
    }
  }
}

/* M v */
static void lamc_loop_momenta(const lamc_loop_parts *p, const lamc_real *v, lamc_real *momenta) {
  const lamc_real *row = p->mass;
  for (int i = 0; i < p->n; i++, row += i) {
    momenta[i] = 0;
    if (i >= p->cut && i < p->beyond) continue;
    lamc_real sum = row[i] * v[i];
    for (int k = 0; k < i; k++) {
      sum += row[k] * v[k];
      momenta[k] += row[k] * v[i];
    }
    momenta[i] = sum;
  }
}

/* N and L of N^T M N */
static void lamc_loop_reduce(const lamc_loop_parts *p, int count) {
  const int free = p->n - count;
  lamc_real *entries = p->raw;
  lamc_loop_find_free(p, count);
  for (int a = 0; a < free; a++) {
    lamc_loop_momenta(p, p->free + (ptrdiff_t)a * p->n, p->z);
    for (int b = 0; b <= a; b++) *entries++ = lamc_dot(p->n, p->free + (ptrdiff_t)b * p->n, p->z);
  }
  lamc_cholesky(free, p->raw, p->l);
}

/* Which equations hold at a state, and what they leave free */
static int lamc_loop_take(const lamc_motion *motion, const lamc_loop_parts *p) {
  const int count = lamc_loop_order(p, motion->model->rank);
  lamc_loop_reduce(p, count);
  return count;
}

/* The part of `force` that moves what is free: the first n - count numbers of `found`, by L^-1 */
static void lamc_loop_along(const lamc_loop_parts *p, int count, const lamc_real *force, lamc_real *found) {
  const int free = p->n - count;
  for (int a = 0; a < free; a++) found[a] = lamc_dot(p->n, p->free + (ptrdiff_t)a * p->n, force);
  lamc_solve_lower(free, p->l, found);
}

/* x += N L^-T amounts */
static void lamc_loop_add(const lamc_loop_parts *p, int count, lamc_real *amounts, lamc_real *x) {
  const int free = p->n - count;
  lamc_solve_upper(free, p->l, amounts);
  for (int a = 0; a < free; a++) {
    const lamc_real *direction = p->free + (ptrdiff_t)a * p->n;
    for (int i = 0; i < p->n; i++) x[i] += amounts[a] * direction[i];
  }
}

/* x with the equations at -goal, and M x = force but for what the equations push */
static void lamc_loop_solve(const lamc_loop_parts *p, int count, const lamc_real *goal,
                            const lamc_real *force, lamc_real *x) {
  lamc_loop_impose(p, count, goal, x);
  lamc_loop_momenta(p, x, p->z);
  for (int i = 0; i < p->n; i++) p->z[i] = (force != NULL ? force[i] : 0) - p->z[i];
  lamc_loop_along(p, count, p->z, p->x);
  lamc_loop_add(p, count, p->x, x);
}

/* The last pivot of the first; 0 where an equation was let go, 1 where there is none */
static lamc_real lamc_loop_last_pivot(const lamc_motion *motion, const lamc_loop_parts *p, int count) {
  if (count < motion->model->rank) return 0;
  return count > 0 ? lamc_loop_pivot(p, count - 1) / lamc_loop_pivot(p, 0) : 1;
}

/* lambda (m,) of M udot = f + J^T lambda, by the model's equations: of the taken ones, zero for the others */
static void lamc_loop_lambda(const lamc_loop_parts *p, int count, const lamc_real *udot, lamc_real *lambda) {
  const int n = p->n;
  memset(lambda, 0, (size_t)p->m * sizeof *lambda);
  lamc_loop_momenta(p, udot, p->z);
  for (int k = 0; k < count; k++) {
    const int column = (int)p->columns[k];
    lamc_real rest = p->z[column] - p->f[column];
    for (int i = 0; i < k; i++) rest -= p->a[(ptrdiff_t)i * n + k] * p->x[i];
    p->x[k] = rest / p->a[(ptrdiff_t)k * n + k];
  }
  for (int k = count - 1; k >= 0; k--) {
    for (int i = k + 1; i < count; i++) p->x[k] -= p->a[(ptrdiff_t)i * n + k] * p->x[i];
    const int row = (int)p->rows[k];
    lambda[row] = p->norms[row] > 0 ? p->x[k] / p->norms[row] : 0;
  }
}

#endif /* LAMC_LOOP_EQUATIONS_H */
