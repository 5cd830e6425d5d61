/* method.h, of lamc: what run.c asks of an integration method, and what methods share.
 *
 * A method tries one step at a time on the vectors in a run's work array; run.c decides what becomes of it. Vectors are
 * padded with zeros to a multiple of LANES, and loops over them run in blocks of LANES: a compiler turns a block into
 * vector instructions without a remainder loop, at -O2 already. */
#ifndef LAMC_METHOD_H
#define LAMC_METHOD_H

#include "lamc.h"
#include "tolerances.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef __cplusplus
#define LAMC_RESTRICT __restrict
#else
#define LAMC_RESTRICT restrict
#endif

enum {
  LANES = 4,
  /* where each vector lies in work, in strides */
  SLOT_Y = 0,     /* and 1: y at t and at t_old, by side */
  SLOT_SLOPE = 2, /* and 3: dy/dt there */
  SLOT_STAGE = 4, /* argument of the stage being evaluated */
  SLOT_KEPT = 5,  /* and 6: y and dy/dt, kept for a while */
  SLOT_OWN = 7    /* the first of the method's own */
};

/* A quadrature over a step: nodes as parts of the step, and weights. It is exact for polynomials of degree
 * 2 (count - 1) at least. */
typedef struct rule {
  int count;
  const lamc_real *node, *weight;
} rule;

extern const rule lamc_gauss_4, lamc_gauss_7;

typedef struct method {
  int slots;               /* vectors of its own */
  int evaluations;         /* of rhs in one step, for comparisons */
  lamc_real alpha, beta;   /* PI control: the step changes by error^-alpha * error_old^beta */
  lamc_real grow_at_most;  /* change of the step from one to the next */
  int gives_slope;         /* 1: a step leaves dy/dt at the new state */
  int keeps_dense;         /* 1: the next step starts from the continuous extension of this one */
  lamc_real stable_extent; /* h times eigenvalue up to which steps are stable, imaginary ones too; 0: any */
  const rule
      *quadrature; /* for integrals along the run: as many nodes as the continuous extension has orders */
  /* numbers of its own after the vectors */
  long long (*extra)(const lamc_ode *ode);
  /* Tries a step of length h from t and leaves the new state at the other side. The square of the error norm: at most 1
   * is good enough, not finite means that a stage or the new state is not. */
  lamc_real (*attempt)(lamc_run *run, lamc_real h);
  /* Works out the continuous extension of the last accepted step. */
  void (*make_dense)(lamc_run *run);
  /* y at t_old + a h_last */
  void (*interpolate)(const lamc_run *run, lamc_real a, lamc_real *y);
  /* Size of the eigenvalues that the step just accepted met, 1/s; NULL: the method does not care */
  lamc_real (*eigenvalue)(const lamc_run *run);
} method;

/* Of run.c: the method by its number */
const method *lamc_method_of(int which);

#include "methods.h"

/* 1 unless x is NaN or infinite; of a double the bits are read, since -ffast-math makes isfinite() always true */
static inline int is_finite(lamc_real x) {
#ifdef LAMC_REAL_FLOAT
  return x - x == 0;
#else
  uint64_t bits;
  memcpy(&bits, &x, sizeof bits);
  return (bits & 0x7ff0000000000000u) != 0x7ff0000000000000u;
#endif
}

static inline lamc_real larger(lamc_real a, lamc_real b) {
  return a > b ? a : b;
}

static inline lamc_real smaller(lamc_real a, lamc_real b) {
  return a < b ? a : b;
}

/* n rounded up to whole blocks, and one block where n is 0 */
static inline int padded(int n) {
  return n > 0 ? (n + LANES - 1) / LANES * LANES : LANES;
}

static inline lamc_real *slot(const lamc_run *run, int index) {
  return run->work + (ptrdiff_t)index * run->stride;
}

/* y and dy/dt at t, where a step begins */
static inline lamc_real *y_here(const lamc_run *run) {
  return slot(run, SLOT_Y + run->side);
}

static inline lamc_real *slope_here(const lamc_run *run) {
  return slot(run, SLOT_SLOPE + run->side);
}

/* y and dy/dt of the other side: while a step is tried, where it leads; after it was accepted, where it began */
static inline lamc_real *y_there(const lamc_run *run) {
  return slot(run, SLOT_Y + 1 - run->side);
}

static inline lamc_real *slope_there(const lamc_run *run) {
  return slot(run, SLOT_SLOPE + 1 - run->side);
}

/* atol, or where that is zero the least number that can still be divided by */
static inline lamc_real floor_of_scale(const lamc_run *run) {
  return larger(run->options.atol, LAMC_LEAST);
}

static inline void evaluate(lamc_run *run, lamc_real t, const lamc_real *y, lamc_real *dydt) {
  run->ode.rhs(run->ode.context, t, y, dydt);
  run->evaluations++;
}

/* How many of the components of y = [q, u] are q */
static inline int coordinates_of(const lamc_ode *ode) {
  return ode->coordinate_count > 0 ? ode->coordinate_count : ode->n / 2;
}

/* Sum over the components of (v / tolerance)^2, the tolerance by the larger end of the step */
static inline lamc_real weighed(const lamc_run *run, const lamc_real *v) {
  const lamc_real *y = y_here(run), *y_new = y_there(run);
  const lamc_real atol = floor_of_scale(run), rtol = run->options.rtol;
  lamc_real sum = 0;
  for (int i = 0; i < run->ode.n; i++) {
    const lamc_real ratio = v[i] / (atol + rtol * larger(fabs(y[i]), fabs(y_new[i])));
    sum += ratio * ratio;
  }
  return sum;
}

/* 1 if all components are finite; an infinite state has an infinite tolerance, which would hide it */
static inline int all_finite(const lamc_run *run, const lamc_real *v) {
  lamc_real sum = 0;
  for (int i = 0; i < run->ode.n; i++) sum += fabs(v[i]);
  return is_finite(sum);
}

/* Size of the eigenvalues that two near states and their slopes tell of, 1/s, for y = [q, u] where dq/dt is u, or like it
 * in size. In the metric in which a mode of frequency w turns at a steady pace, w^2 is |change of udot| over |change of q|.
 * Where the change of q drowns in round-off, as under heavy damping, |change of udot| over |change of u| tells. */
static inline lamc_real steepness(const lamc_run *run, const lamc_real *fa, const lamc_real *fb,
                                  const lamc_real *a, const lamc_real *b) {
  const int nq = coordinates_of(&run->ode);
  lamc_real accelerations = 0, rates = 0, angles = 0, size = 0;
  for (int i = 0; i < nq; i++) {
    angles += (a[i] - b[i]) * (a[i] - b[i]);
    size += a[i] * a[i];
  }
  for (int i = nq; i < run->ode.n; i++) {
    accelerations += (fa[i] - fb[i]) * (fa[i] - fb[i]);
    rates += (a[i] - b[i]) * (a[i] - b[i]);
  }
  const lamc_real noise = 16 * LAMC_EPSILON;
  if (angles > noise * noise * size) return sqrt(sqrt(accelerations / angles));
  return rates > 0 ? sqrt(accelerations / rates) : 0;
}

#endif /* LAMC_METHOD_H */
