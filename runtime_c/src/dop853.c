/* dop853.c: the explicit Runge-Kutta method of Dormand and Prince of order 8, with error estimates of orders 5 and 3.
 *
 * In: a lamc_run with y and dy/dt at t. Out: the new state, the error norm, the dense output of order 7.
 * Never: decides anything; that is run.c.
 *
 * E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed. (1993), section II.10, with
 * the coefficients and the error norm of its code DOP853. */
#include "dop853.h"
#include "method.h"

enum {
  STAGES = 12,
  ALL_STAGES = 16,            /* the 13th is the slope at the new state; three more serve the dense output */
  SLOT_K = SLOT_OWN,          /* stages 2 to 12 */
  SLOT_K_EXTRA = SLOT_K + 11, /* stages 14 to 16 */
  SLOT_DENSE = SLOT_OWN + DOP853_DENSE, /* seven vectors of the continuous extension */
  OWN_SLOTS = 11 + 3 + 7
};

/* Stage k (from 0): the slopes at the two ends of a step are stages 0 and 12. `begin` and `end` are those. */
static const lamc_real *stage(const lamc_run *run, int k, const lamc_real *begin, const lamc_real *end) {
  if (k == 0) return begin;
  if (k == STAGES) return end;
  return slot(run, k < STAGES ? SLOT_K + k - 1 : SLOT_K_EXTRA + k - STAGES - 1);
}

/* out = sum over the first `count` stages of weight * stage */
static void combine(const lamc_run *run, const lamc_real *weights, int count, const lamc_real *begin,
                    const lamc_real *end, lamc_real *LAMC_RESTRICT out) {
  const int m = run->stride;
  memset(out, 0, (size_t)m * sizeof *out);
  for (int k = 0; k < count; k++) {
    const lamc_real w = weights[k];
    if (w == 0.0) continue;
    const lamc_real *LAMC_RESTRICT v = stage(run, k, begin, end);
    for (int b = 0; b < m; b += LANES)
      for (int i = b; i < b + LANES; i++) out[i] += w * v[i];
  }
}

/* The argument of stage `row` */
static void argument(const lamc_run *run, int row, lamc_real h, const lamc_real *y, const lamc_real *begin,
                     const lamc_real *end, lamc_real *LAMC_RESTRICT out) {
  const int m = run->stride;
  combine(run, DOP853_A[row], row, begin, end, out);
  for (int b = 0; b < m; b += LANES)
    for (int i = b; i < b + LANES; i++) out[i] = y[i] + h * out[i];
}

static lamc_real attempt(lamc_run *run, lamc_real h) {
  const lamc_real *y = y_here(run), *begin = slope_here(run);
  lamc_real *y_new = y_there(run), *s = slot(run, SLOT_STAGE), *error = slot(run, SLOT_DENSE);
  for (int k = 1; k < STAGES; k++) {
    argument(run, k, h, y, begin, begin, s);
    evaluate(run, run->t + DOP853_C[k] * h, s, slot(run, SLOT_K + k - 1));
  }
  argument(run, STAGES, h, y, begin, begin, y_new);
  if (!all_finite(run, y_new)) return HUGE_VAL;
  combine(run, DOP853_E5, STAGES, begin, begin, error);
  const lamc_real fifth = weighed(run, error);
  combine(run, DOP853_E3, STAGES, begin, begin, error);
  const lamc_real third = weighed(run, error);
  const lamc_real both = fifth + 0.01 * third;
  return both > 0.0 ? h * h * fifth * fifth / (both * run->ode.n) : 0.0;
}

static void make_dense(lamc_run *run) {
  const int n = run->ode.n;
  const lamc_real h = run->h_last;
  const lamc_real *y = y_there(run), *y_new = y_here(run), *begin = slope_there(run), *end = slope_here(run);
  lamc_real *s = slot(run, SLOT_DENSE); /* not SLOT_STAGE, of which eigenvalue() asks later */
  for (int k = STAGES + 1; k < ALL_STAGES; k++) {
    argument(run, k, h, y, begin, end, s);
    evaluate(run, run->t_old + DOP853_C[k] * h, s, slot(run, SLOT_K_EXTRA + k - STAGES - 1));
  }
  lamc_real *f0 = slot(run, SLOT_DENSE), *f1 = slot(run, SLOT_DENSE + 1), *f2 = slot(run, SLOT_DENSE + 2);
  for (int k = 0; k < 4; k++)
    combine(run, DOP853_D[k], ALL_STAGES, begin, end, slot(run, SLOT_DENSE + 3 + k));
  for (int i = 0; i < n; i++) {
    const lamc_real change = y_new[i] - y[i];
    f0[i] = change;
    f1[i] = h * begin[i] - change;
    f2[i] = 2.0 * change - h * (end[i] + begin[i]);
  }
}

static void interpolate(const lamc_run *run, lamc_real a, lamc_real *y) {
  const lamc_real *start = y_there(run);
  const lamc_real b = 1.0 - a;
  for (int i = 0; i < run->ode.n; i++) {
    lamc_real sum = 0.0;
    for (int k = 6; k >= 0; k--) {
      const lamc_real weight = k >= 3 ? run->h_last : 1.0;
      sum = (sum + weight * slot(run, SLOT_DENSE + k)[i]) * (k % 2 == 0 ? a : b);
    }
    y[i] = start[i] + sum;
  }
}

static lamc_real eigenvalue(const lamc_run *run) {
  return steepness(run, slope_here(run), slot(run, SLOT_K + STAGES - 2), y_here(run), slot(run, SLOT_STAGE));
}

/* PI control with 0.05 of the last error: a third of the refusals that the code DOP853 without it has, for the same work
 * (measured: four-bar, five-bar, origami) */
const method lamc_method_dop853 = {
    OWN_SLOTS,     12,   0.1,     0.05,       6.0,         0,          0, 3.0,
    &lamc_gauss_7, NULL, attempt, make_dense, interpolate, eigenvalue,
};
