/* loop_equations.h, of lamc: which equations of the loops hold at a state, and what they leave free.
 *
 * In:    M and f, or functions of a model that apply them; the rows of J. Out: free directions, accelerations along them,
 *        multipliers.
 * Never: assumes that the equations are independent; allocates.
 *
 * J is eliminated, as one array in small loops (loop_dense.h), row by row in large ones (loop_sparse.h). The rows of N are
 * motions that keep the loops closed, one for each rate that is left over, and N^T M N is small, and regular: hinges that
 * close loops move no mass of their own (null-space method; R. A. Wehage and E. J. Haug, 1982). */
#ifndef LAMC_LOOP_EQUATIONS_H
#define LAMC_LOOP_EQUATIONS_H

#include "cholesky.h"
#include "loop_dense.h"
#include "loop_sparse.h"

/* How many equations hold here, at most those of a generic position */
static inline int lamc_loop_order(lamc_loop_parts *p) {
  const int rank = p->motion->model->rank, most = rank < p->n ? rank : p->n;
  return p->is_sparse ? lamc_sparse_order(p, most) : lamc_dense_order(p, most);
}

/* x (n,) such that the taken equations have the values -goal (m,) */
static inline void lamc_loop_impose(const lamc_loop_parts *p, int count, const lamc_real *goal,
                                    lamc_real *x) {
  if (p->is_sparse) {
    lamc_sparse_impose(p, count, goal, x);
  } else {
    lamc_dense_impose(p, count, goal, x);
  }
}

/* M v */
static inline void lamc_loop_momenta(const lamc_loop_parts *p, const lamc_real *v, lamc_real *momenta) {
  if (!p->has_mass) {
    p->motion->model->momenta(p->motion->constants, p->place, v, momenta);
    return;
  }
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

/* z = M a - f, at the position that was prepared */
static inline void lamc_loop_unbalanced(const lamc_loop_parts *p, lamc_real t, const lamc_real *u,
                                        const lamc_real *a, lamc_real *z) {
  if (!p->has_mass) {
    p->motion->model->residual(p->motion->constants, t, p->place, u, a, z);
    return;
  }
  lamc_loop_momenta(p, a, z);
  for (int i = 0; i < p->n; i++) z[i] -= p->f[i];
}

/* The first `count` free directions times z, which has nothing for hinges that close loops: momenta */
static inline void lamc_loop_pair(const lamc_loop_parts *p, int count, const lamc_real *z, lamc_real *sums) {
  const int beyond = p->n - p->beyond;
  lamc_dots(count, p->cut, p->free, p->n, z, sums);
  for (int k = 0; k < count && beyond > 0; k++) {
    sums[k] += lamc_dot(beyond, p->free + (ptrdiff_t)k * p->n + p->beyond, z + p->beyond);
  }
}

/* N and L of N^T M N */
static inline void lamc_loop_reduce(const lamc_loop_parts *p, int count) {
  const int free = p->n - count;
  lamc_real *entries = p->raw;
  if (p->is_sparse) {
    lamc_sparse_find_free(p, count);
  } else {
    lamc_dense_find_free(p, count);
  }
  for (int a = 0; a < free; a++) {
    lamc_loop_momenta(p, p->free + (ptrdiff_t)a * p->n, p->z);
    lamc_loop_pair(p, a + 1, p->z, entries);
    entries += a + 1;
  }
  lamc_cholesky(free, p->raw, p->l);
}

static inline int lamc_loop_same(ptrdiff_t n, const lamc_real *a, const lamc_real *b) {
  for (ptrdiff_t i = 0; i < n; i++) {
    if (!(a[i] == b[i])) return 0;
  }
  return 1;
}

/* Work of both, but for sparse elimination, which counts its own */
static inline void lamc_loop_count_take(const lamc_loop_parts *p, int count) {
  const lamc_real n = (lamc_real)p->n, free = n - (lamc_real)count;
  const lamc_real dense = p->is_sparse ? 0 : LAMC_R(0.5) * (lamc_real)p->m * n * (lamc_real)count;
  const lamc_real reduced =
      free * ((lamc_real)WORK_OF_MOMENTA * n + LAMC_R(0.2) * n * free + free * free / 10);
  lamc_loop_count_work(p, dense + reduced);
}

/* 1 if these J and place, to the last digit, were eliminated last. Else they are kept, as those that will be. */
static inline int lamc_loop_is_taken(const lamc_loop_parts *p) {
  const int rows = p->pattern->row_start[p->m];
  lamc_real *place = p->taken + rows;
  if (p->count >= 0 && lamc_loop_same(rows, p->taken, p->j) && lamc_loop_same(p->nq, place, p->place))
    return 1;
  memcpy(p->taken, p->j, (size_t)rows * sizeof *p->j);
  memcpy(place, p->place, (size_t)p->nq * sizeof *place);
  return 0;
}

/* Which equations hold at a state, and what they leave free. Near singular positions states are settled before use, and
 * often were closed already: the same is not eliminated twice. A model that writes M down does so by more than one
 * function, which may differ in the last digit, and its loops are small. */
static inline int lamc_loop_take(lamc_loop_parts *p) {
  if (!p->has_mass && lamc_loop_is_taken(p)) return p->count;
  p->count = lamc_loop_order(p);
  lamc_loop_reduce(p, p->count);
  lamc_loop_count_take(p, p->count);
  return p->count;
}

/* As lamc_loop_take, a little way from where `count` equations were taken. Of large loops the directions that are free, and
 * what moves along them, stay those of there: a correction need not be the least one, and takes no masses then. They are
 * to be taken again before anything is that has to be exact. */
static inline int lamc_loop_take_nearby(lamc_loop_parts *p, int count) {
  if (p->is_sparse && !p->has_mass) {
    p->count = -1;
    if (lamc_loop_order(p) == count) return count;
  }
  return lamc_loop_take(p);
}

/* The part of `force` that moves what is free: the first n - count numbers of `found`, by L^-1 */
static inline void lamc_loop_along(const lamc_loop_parts *p, int count, const lamc_real *force,
                                   lamc_real *found) {
  const int free = p->n - count;
  lamc_dots(free, p->n, p->free, p->n, force, found);
  lamc_solve_lower(free, p->l, found);
}

/* x += N L^-T amounts */
static inline void lamc_loop_add(const lamc_loop_parts *p, int count, lamc_real *amounts, lamc_real *x) {
  const int free = p->n - count;
  lamc_solve_upper(free, p->l, amounts);
  for (int a = 0; a < free; a++) {
    const lamc_real *direction = p->free + (ptrdiff_t)a * p->n;
    for (int i = 0; i < p->n; i++) x[i] += amounts[a] * direction[i];
  }
}

/* x with the equations at -goal, and M x = force but for what the equations push */
static inline void lamc_loop_solve(const lamc_loop_parts *p, int count, const lamc_real *goal,
                                   const lamc_real *force, lamc_real *x) {
  lamc_loop_impose(p, count, goal, x);
  lamc_loop_momenta(p, x, p->z);
  for (int i = 0; i < p->n; i++) p->z[i] = (force != NULL ? force[i] : 0) - p->z[i];
  lamc_loop_along(p, count, p->z, p->x);
  lamc_loop_add(p, count, p->x, x);
}

/* udot with the equations at -extra, and M udot = f but for what they push */
static inline void lamc_loop_accelerate(const lamc_loop_parts *p, int count, lamc_real t, const lamc_real *u,
                                        lamc_real *udot) {
  lamc_loop_impose(p, count, p->extra, udot);
  lamc_loop_unbalanced(p, t, u, udot, p->z);
  for (int i = 0; i < p->n; i++) p->z[i] = -p->z[i];
  lamc_loop_along(p, count, p->z, p->x);
  lamc_loop_add(p, count, p->x, udot);
}

/* The last pivot of the first; 0 where an equation was let go, 1 where there is none */
static inline lamc_real lamc_loop_last_pivot(const lamc_loop_parts *p, int count) {
  if (count < p->motion->model->rank) return 0;
  if (p->is_sparse) return lamc_sparse_least(p, count);
  return count > 0 ? lamc_dense_pivot(p, count - 1) / lamc_dense_pivot(p, 0) : 1;
}

/* 1 if one of the equations that were taken has less than `least` of its say: by its pivot, or by the length of its row */
static inline int lamc_loop_is_faint(const lamc_loop_parts *p, int count, lamc_real least) {
  if (lamc_loop_last_pivot(p, count) < least) return 1;
  for (int k = 0; k < count; k++) {
    const int i = p->is_sparse ? lamc_at(p->steps.row, k) : (int)p->rows[k];
    if (lamc_loop_fades(p, i, least)) return 1;
  }
  return 0;
}

/* lambda (m,) of M udot = f + J^T lambda, by the model's equations: of the taken ones, zero for the others */
static inline void lamc_loop_lambda(const lamc_loop_parts *p, int count, lamc_real t, const lamc_real *u,
                                    const lamc_real *udot, lamc_real *lambda) {
  memset(lambda, 0, (size_t)p->m * sizeof *lambda);
  lamc_loop_unbalanced(p, t, u, udot, p->z);
  if (p->is_sparse) {
    lamc_sparse_lambda(p, count, p->z, lambda);
  } else {
    lamc_dense_lambda(p, count, p->z, lambda);
  }
  for (int i = 0; i < p->m; i++) lambda[i] = p->norms[i] > 0 ? lambda[i] / p->norms[i] : 0;
}

#endif /* LAMC_LOOP_EQUATIONS_H */
