/* implicit.h, of lamc: the linear algebra of implicit methods, of half the size where y = [q, u] with dq/dt = u. */
#ifndef LAMC_IMPLICIT_H
#define LAMC_IMPLICIT_H

#include "method.h"

/* What an implicit method keeps behind its vectors; k = n / 2 where dq/dt = u, else n */
typedef struct implicit {
  int has_structure; /* 1: dq/dt = u */
  int k;
  int late;            /* n - k: the first component that by_t is about */
  lamc_real *by_q;     /* (k, k): d(udot)/dq; without structure, of dy/dt by y */
  lamc_real *by_u;     /* (k, k): d(udot)/du; without structure nothing */
  lamc_real *by_t;     /* (k,): of the last k components of dy/dt by t */
  lamc_real *real;     /* (k, k): factors for a real shift */
  lamc_real *real_row; /* (k,): the row that each pivot came from */
  lamc_real *pair;     /* (k, k, 2): factors for a complex shift */
  lamc_real *pair_row; /* (k,) */
  lamc_real *buffer;   /* (k, 2) */
  lamc_real *scratch;  /* of ode.jacobian */
} implicit;

/* Numbers that it takes; 0 where the equation has no Jacobian */
long long lamc_implicit_size(const lamc_ode *ode);

/* The parts, behind `slots` vectors of the method's own */
implicit lamc_implicit_parts(const lamc_run *run, int slots);

/* The Jacobian at the state where the run stands, unless it is there already */
void lamc_implicit_jacobian(lamc_run *run, const implicit *parts);

/* Factors of c I - J. 0 if it is singular or not finite. */
int lamc_implicit_factorise(lamc_run *run, const implicit *parts, lamc_real c);

/* v = (c I - J)^-1 v, v (n,) */
void lamc_implicit_solve(const implicit *parts, lamc_real c, lamc_real *v);

/* The same for a complex shift c[0] + i c[1]; v = re + i im, (n,) each */
int lamc_implicit_factorise_pair(lamc_run *run, const implicit *parts, const lamc_real *c);
void lamc_implicit_solve_pair(const implicit *parts, const lamc_real *c, lamc_real *re, lamc_real *im);

/* The squared error norm that counts. `error` is that of a step, `squared` its norm, c the shift of the factors.
 *
 * A fast oscillation that is too small to matter may still be above the tolerance of the rates. No step control gets past
 * it: steps near its period resolve it, longer ones are refused. So the first step of an implicit method may leave out up
 * to 100 tolerances of motion that c (c I - J)^-1 takes off, as the steps after it do (they are L-stable), if what is left
 * is within the tolerance. For an oscillation of frequency w that is an error of its rate / w in the angle, within the
 * tolerance by far. `room` (n,). */
lamc_real lamc_implicit_pass(const lamc_run *run, const implicit *parts, lamc_real c, const lamc_real *error,
                             lamc_real squared, lamc_real *room);

#endif /* LAMC_IMPLICIT_H */
