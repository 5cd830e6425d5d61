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
  SLOT_DENSE = SLOT_K_EXTRA + 3, /* seven vectors of the continuous extension */
  OWN_SLOTS = 11 + 3 + 7
};

/* d_ij of the continuous extension */
static const lamc_real D[4][16] = {
    {-8.428938276109013, 0.0, 0.0, 0.0, 0.0, 0.5667149535193777, -3.0689499459498917, 2.38466765651207,
     2.117034582445028, -0.871391583777973, 2.2404374302607883, 0.6315787787694688, -0.08899033645133331,
     18.148505520854727, -9.194632392478356, -4.436036387594894},
    {10.427508642579134, 0.0, 0.0, 0.0, 0.0, 242.28349177525817, 165.20045171727028, -374.5467547226902,
     -22.113666853125306, 7.733432668472264, -30.674084731089398, -9.332130526430229, 15.697238121770845,
     -31.139403219565178, -9.35292435884448, 35.81684148639408},
    {19.985053242002433, 0.0, 0.0, 0.0, 0.0, -387.0373087493518, -189.17813819516758, 527.8081592054236,
     -11.57390253995963, 6.8812326946963, -1.0006050966910838, 0.7777137798053443, -2.778205752353508,
     -60.19669523126412, 84.32040550667716, 11.99229113618279},
    {-25.69393346270375, 0.0, 0.0, 0.0, 0.0, -154.18974869023643, -231.5293791760455, 357.6391179106141,
     93.40532418362432, -37.45832313645163, 104.0996495089623, 29.8402934266605, -43.53345659001114,
     96.32455395918828, -39.17726167561544, -149.72683625798564}};

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
  for (int k = 0; k < 4; k++) combine(run, D[k], ALL_STAGES, begin, end, slot(run, SLOT_DENSE + 3 + k));
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
