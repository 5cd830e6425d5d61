/* radau5.c, of lamc: the implicit Runge-Kutta method Radau IIA of order 5, with an error estimate of order 3.
 *
 * In: a lamc_run with y and dy/dt at t, and the Jacobian of its equation. Out: the new state, the error norm, the dense
 * output (the collocation polynomial). Never: iterates without a bound.
 *
 * E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed. (1996), section IV.8: simplified Newton
 * iterations on the three stages, which a change of basis splits into one real and one complex system. */
#include "implicit.h"

enum {
  MAX_ITERATIONS = 7,
  SLOT_Z = SLOT_OWN,       /* the three stages, less y */
  SLOT_W = SLOT_Z + 3,     /* the same in the basis of the eigenvectors */
  SLOT_F = SLOT_W + 3,     /* slopes at the stages */
  SLOT_DENSE = SLOT_F + 3, /* three coefficients of the collocation polynomial */
  SLOT_ERROR = SLOT_DENSE + 3,
  OWN_SLOTS = 13
};

/* sqrt(6) and cube roots of 3 inside */
static const lamc_real NODE[3] = {0.15505102572168222, 0.6449489742783178, 1.0};
static const lamc_real REAL_EIGENVALUE = 3.637834252744496;
static const lamc_real EIGENVALUE_PAIR[2] = {2.6810828736277523, -3.050430199247411};
static const lamc_real T[3][3] = {{0.09443876248897524, -0.14125529502095421, 0.03002919410514742},
                                  {0.25021312296533332, 0.20412935229379994, -0.38294211275726192},
                                  {1.0, 1.0, 0.0}};
static const lamc_real TI[3][3] = {{4.17871859155190428, 0.32768282076106237, 0.52337644549944951},
                                   {-4.17871859155190428, -0.32768282076106237, 0.47662355450055044},
                                   {0.50287263494578682, -2.57192694985560522, 0.59603920482822492}};
/* weights of the stages in the error estimate */
static const lamc_real E[3] = {-10.048809399827414, 1.382142733160748, -0.3333333333333333};
/* powers of the time within a step, by stage */
static const lamc_real P[3][3] = {{10.048809399827414, -25.62959144707664, 15.580782047249224},
                                  {-1.382142733160748, 10.296258113743303, -8.914115380582556},
                                  {0.3333333333333333, -2.6666666666666665, 3.3333333333333335}};

/* First guess of the stages: the collocation polynomial of the step before, continued; or the state itself. */
static void predict(lamc_run *run, lamc_real h) {
  const int n = run->ode.n;
  const lamc_real *d[3] = {slot(run, SLOT_DENSE), slot(run, SLOT_DENSE + 1), slot(run, SLOT_DENSE + 2)};
  const lamc_real ratio = run->has_polynomial ? h / run->h_last : 0.0;
  for (int s = 0; s < 3; s++) {
    lamc_real *z = slot(run, SLOT_Z + s);
    const lamc_real a = 1.0 + NODE[s] * ratio, b = a * a, c = b * a;
    for (int i = 0; i < n; i++)
      z[i] = ratio > 0.0 ? d[0][i] * (a - 1.0) + d[1][i] * (b - 1.0) + d[2][i] * (c - 1.0) : 0.0;
  }
}

/* out_r = sum over s of matrix[r][s] in_s, for three vectors each */
static void change_basis(const lamc_run *run, const lamc_real matrix[3][3], int from, int to) {
  const lamc_real *a = slot(run, from), *b = slot(run, from + 1), *c = slot(run, from + 2);
  for (int r = 0; r < 3; r++) {
    lamc_real *out = slot(run, to + r);
    for (int i = 0; i < run->ode.n; i++)
      out[i] = matrix[r][0] * a[i] + matrix[r][1] * b[i] + matrix[r][2] * c[i];
  }
}

/* One Newton iteration: the change of W replaces the slopes; returns its norm, not finite where a slope is not. */
static lamc_real iterate(lamc_run *run, const implicit *parts, lamc_real h) {
  const int n = run->ode.n;
  const lamc_real pair[2] = {EIGENVALUE_PAIR[0] / h, EIGENVALUE_PAIR[1] / h};
  lamc_real *s = slot(run, SLOT_STAGE);
  const lamc_real *y = y_here(run);
  for (int k = 0; k < 3; k++) {
    const lamc_real *z = slot(run, SLOT_Z + k);
    for (int i = 0; i < n; i++) s[i] = y[i] + z[i];
    evaluate(run, run->t + NODE[k] * h, s, slot(run, SLOT_F + k));
    if (!all_finite(run, slot(run, SLOT_F + k))) return HUGE_VAL;
  }
  const lamc_real *w[3] = {slot(run, SLOT_W), slot(run, SLOT_W + 1), slot(run, SLOT_W + 2)};
  lamc_real *f[3] = {slot(run, SLOT_F), slot(run, SLOT_F + 1), slot(run, SLOT_F + 2)};
  for (int i = 0; i < n; i++) {
    const lamc_real a = f[0][i], b = f[1][i], c = f[2][i];
    f[0][i] = TI[0][0] * a + TI[0][1] * b + TI[0][2] * c - REAL_EIGENVALUE / h * w[0][i];
    f[1][i] = TI[1][0] * a + TI[1][1] * b + TI[1][2] * c - (pair[0] * w[1][i] - pair[1] * w[2][i]);
    f[2][i] = TI[2][0] * a + TI[2][1] * b + TI[2][2] * c - (pair[0] * w[2][i] + pair[1] * w[1][i]);
  }
  lamc_implicit_solve(parts, REAL_EIGENVALUE / h, f[0]);
  lamc_implicit_solve_pair(parts, pair, f[1], f[2]);
  return sqrt((weighed(run, f[0]) + weighed(run, f[1]) + weighed(run, f[2])) / (3.0 * n));
}

/* Round-off of the slopes can be larger than that of the state by far: where hinges are stiff, or loops nearly singular.
 * The rate of simplified Newton iterations hardly changes until it is reached, so a rate that has grown tells it. Changes
 * of that size are accepted as long as they are no more than a hundredth of the tolerance. */
static const lamc_real NO_MATTER = 1e-2, GROWN = 2.0;

/* Solves for the stages. 0 where the iteration does not converge, -1 where it meets what is not finite. */
static int solve_stages(lamc_run *run, const implicit *parts, lamc_real h) {
  const int n = run->ode.n;
  const lamc_real rtol = run->options.rtol;
  const lamc_real noise = 10.0 * LAMC_EPSILON / rtol; /* changes as small as this need not shrink any more */
  const lamc_real enough = larger(noise, smaller(0.03, sqrt(rtol)));
  lamc_real before = 0.0, fastest = HUGE_VAL;
  predict(run, h);
  change_basis(run, TI, SLOT_Z, SLOT_W);
  for (int round = 0; round < MAX_ITERATIONS; round++) {
    const lamc_real change = iterate(run, parts, h);
    if (!is_finite(change)) return -1;
    const lamc_real rate = round > 0 ? change / before : 0.0;
    const int stalls =
        round > 0 && (rate >= 1.0 || pow(rate, MAX_ITERATIONS - round) / (1.0 - rate) * change > enough);
    const int is_noise = change <= noise || (stalls && change <= NO_MATTER && rate > GROWN * fastest);
    if (stalls && !is_noise) return 0;
    for (int k = 0; k < 3; k++) {
      lamc_real *w = slot(run, SLOT_W + k);
      const lamc_real *dw = slot(run, SLOT_F + k);
      for (int i = 0; i < n; i++) w[i] += dw[i];
    }
    change_basis(run, T, SLOT_W, SLOT_Z);
    if (is_noise || (round > 0 && rate / (1.0 - rate) * change < enough)) return 1;
    before = change;
    if (round > 0) fastest = smaller(fastest, rate);
  }
  return 0;
}

/* The squared norm of (c I - J)^-1 (slope + E Z / h). The code RADAU5 tries again from the state less this error after a
 * refusal; here that would hide the error of the rates, which are the slope of the angles, and it is not done. */
static lamc_real estimate(lamc_run *run, const implicit *parts, lamc_real h) {
  const lamc_real *z[3] = {slot(run, SLOT_Z), slot(run, SLOT_Z + 1), slot(run, SLOT_Z + 2)};
  const lamc_real *slope = slope_here(run);
  lamc_real *error = slot(run, SLOT_ERROR);
  for (int i = 0; i < run->ode.n; i++)
    error[i] = slope[i] + (E[0] * z[0][i] + E[1] * z[1][i] + E[2] * z[2][i]) / h;
  lamc_implicit_solve(parts, REAL_EIGENVALUE / h, error);
  return weighed(run, error) / run->ode.n;
}

static lamc_real attempt(lamc_run *run, lamc_real h) {
  const lamc_real NOT_CONVERGED =
      1e6; /* an error so large that the step becomes as short as the control allows */
  const int n = run->ode.n;
  const implicit parts = lamc_implicit_parts(run, OWN_SLOTS);
  const lamc_real pair[2] = {EIGENVALUE_PAIR[0] / h, EIGENVALUE_PAIR[1] / h};
  const lamc_real *y = y_here(run);
  lamc_real *y_new = y_there(run);
  if (n == 0) return 0.0;
  lamc_implicit_jacobian(run, &parts);
  if (!lamc_implicit_factorise(run, &parts, REAL_EIGENVALUE / h)) return HUGE_VAL;
  if (!lamc_implicit_factorise_pair(run, &parts, pair)) return HUGE_VAL;
  memcpy(y_new, y,
         (size_t)n * sizeof *y); /* the tolerance of the iteration goes by the state before the step */
  const int solved = solve_stages(run, &parts, h);
  if (solved < 0) return HUGE_VAL;
  if (solved == 0) return NOT_CONVERGED;
  const lamc_real *last = slot(run, SLOT_Z + 2);
  for (int i = 0; i < n; i++) y_new[i] = y[i] + last[i];
  if (!all_finite(run, y_new)) return HUGE_VAL;
  return lamc_implicit_pass(run, &parts, REAL_EIGENVALUE / h, slot(run, SLOT_ERROR), estimate(run, &parts, h),
                            slot(run, SLOT_STAGE));
}

static void make_dense(lamc_run *run) {
  const lamc_real *z[3] = {slot(run, SLOT_Z), slot(run, SLOT_Z + 1), slot(run, SLOT_Z + 2)};
  run->has_polynomial = 1;
  for (int power = 0; power < 3; power++) {
    lamc_real *d = slot(run, SLOT_DENSE + power);
    for (int i = 0; i < run->ode.n; i++)
      d[i] = P[0][power] * z[0][i] + P[1][power] * z[1][i] + P[2][power] * z[2][i];
  }
}

static void interpolate(const lamc_run *run, lamc_real a, lamc_real *y) {
  const lamc_real *old = y_there(run);
  const lamc_real *d1 = slot(run, SLOT_DENSE), *d2 = slot(run, SLOT_DENSE + 1),
                  *d3 = slot(run, SLOT_DENSE + 2);
  for (int i = 0; i < run->ode.n; i++) y[i] = old[i] + a * (d1[i] + a * (d2[i] + a * d3[i]));
}

/* Integrals along a step from the stages, where the polynomial is of order 5 and nowhere else: the last row of A */
static const lamc_real WEIGHT[3] = {0.37640306270046725, 0.5124858261884216, 0.1111111111111111};
static const rule RADAU_3 = {3, NODE, WEIGHT};

const method lamc_method_radau5 = {
    OWN_SLOTS,          14,      0.25,       0.0,         8.0,  0, 1, 0.0, &RADAU_3,
    lamc_implicit_size, attempt, make_dense, interpolate, NULL,
};
