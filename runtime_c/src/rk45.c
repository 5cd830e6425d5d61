/* rk45.c: the explicit Runge-Kutta pair of Dormand and Prince, order 5 with an error estimate of order 4.
 *
 * In: a lamc_run with y and dy/dt at t. Out: stages, the new state with its slope, the error norm, the dense output.
 * Never: decides anything; that is run.c.
 *
 * Stages are summed number by number, to n. In vectors of two numbers a run of three hinges took 9 % longer (measured): it
 * seems that a load of two numbers waits for the two stores by which an evaluation has just left them.
 *
 * Coefficients: J. R. Dormand, P. J. Prince, J. Comput. Appl. Math. 6 (1980) 19-26, table 2, "RK5(4)7M"; continuous
 * extension: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed. (1993), section
 * II.6, as in its code DOPRI5, whose PI control and steps these are. */
#include "rk45.h"
#include "method.h"

enum {
  SLOT_K2 = SLOT_OWN,        /* stages 2 to 6; 1 and 7 are the slopes at the two ends of a step */
  SLOT_DENSE = SLOT_OWN + 5, /* four vectors of the continuous extension; the fifth is y at t_old */
  OWN_SLOTS = 9
};

/* d_i of the continuous extension */
static const lamc_real D1 = -12715105075.0 / 11282082432.0, D3 = 87487479700.0 / 32700410799.0,
                       D4 = -10690763975.0 / 1880347072.0, D5 = 701980252875.0 / 199316789632.0,
                       D6 = -1453857185.0 / 822651844.0, D7 = 69997945.0 / 29380423.0;

/* The stages of a step of length h from t. Fills k2 .. k6, y and slope at the far end; six evaluations. */
static void take_stages(lamc_run *run, lamc_real h) {
  const int n = run->ode.n;
  const lamc_real t = run->t;
  const lamc_real *LAMC_RESTRICT y = slot(run, SLOT_Y + run->side);
  const lamc_real *LAMC_RESTRICT k1 = slot(run, SLOT_SLOPE + run->side);
  lamc_real *LAMC_RESTRICT y_new = slot(run, SLOT_Y + 1 - run->side);
  lamc_real *LAMC_RESTRICT k7 = slot(run, SLOT_SLOPE + 1 - run->side);
  lamc_real *LAMC_RESTRICT k2 = slot(run, SLOT_K2);
  lamc_real *LAMC_RESTRICT k3 = slot(run, SLOT_K2 + 1);
  lamc_real *LAMC_RESTRICT k4 = slot(run, SLOT_K2 + 2);
  lamc_real *LAMC_RESTRICT k5 = slot(run, SLOT_K2 + 3);
  lamc_real *LAMC_RESTRICT k6 = slot(run, SLOT_K2 + 4);
  lamc_real *LAMC_RESTRICT s = slot(run, SLOT_STAGE);

  for (int i = 0; i < n; i++) s[i] = y[i] + h * (RK45_A21 * k1[i]);
  evaluate(run, t + RK45_C2 * h, s, k2);
  for (int i = 0; i < n; i++) s[i] = y[i] + h * (RK45_A31 * k1[i] + RK45_A32 * k2[i]);
  evaluate(run, t + RK45_C3 * h, s, k3);
  for (int i = 0; i < n; i++) s[i] = y[i] + h * (RK45_A41 * k1[i] + RK45_A42 * k2[i] + RK45_A43 * k3[i]);
  evaluate(run, t + RK45_C4 * h, s, k4);
  for (int i = 0; i < n; i++)
    s[i] = y[i] + h * (RK45_A51 * k1[i] + RK45_A52 * k2[i] + RK45_A53 * k3[i] + RK45_A54 * k4[i]);
  evaluate(run, t + RK45_C5 * h, s, k5);
  for (int i = 0; i < n; i++)
    s[i] = y[i] +
           h * (RK45_A61 * k1[i] + RK45_A62 * k2[i] + RK45_A63 * k3[i] + RK45_A64 * k4[i] + RK45_A65 * k5[i]);
  evaluate(run, t + h, s, k6);
  for (int i = 0; i < n; i++)
    y_new[i] =
        y[i] + h * (RK45_B1 * k1[i] + RK45_B3 * k3[i] + RK45_B4 * k4[i] + RK45_B5 * k5[i] + RK45_B6 * k6[i]);
  evaluate(run, t + h, y_new, k7);
}

/* Square of the error norm of the step just taken; at most 1 means good enough, and not finite means that a stage
 * or the new state is not. */
static lamc_real squared_error(const lamc_run *run, lamc_real h) {
  const int m = run->stride;
  const lamc_real *LAMC_RESTRICT y = slot(run, SLOT_Y + run->side);
  const lamc_real *LAMC_RESTRICT y_new = slot(run, SLOT_Y + 1 - run->side);
  const lamc_real *LAMC_RESTRICT k1 = slot(run, SLOT_SLOPE + run->side);
  const lamc_real *LAMC_RESTRICT k7 = slot(run, SLOT_SLOPE + 1 - run->side);
  const lamc_real *LAMC_RESTRICT k3 = slot(run, SLOT_K2 + 1);
  const lamc_real *LAMC_RESTRICT k4 = slot(run, SLOT_K2 + 2);
  const lamc_real *LAMC_RESTRICT k5 = slot(run, SLOT_K2 + 3);
  const lamc_real *LAMC_RESTRICT k6 = slot(run, SLOT_K2 + 4);
  const lamc_real atol = floor_of_scale(run);
  const lamc_real rtol = run->options.rtol;
  lamc_real sum[LANES] = {0.0, 0.0, 0.0, 0.0};
  lamc_real size[LANES] = {0.0, 0.0, 0.0, 0.0};

  for (int b = 0; b < m; b += LANES)
    for (int j = 0; j < LANES; j++) {
      const int i = b + j;
      const lamc_real error = RK45_E1 * k1[i] + RK45_E3 * k3[i] + RK45_E4 * k4[i] + RK45_E5 * k5[i] +
                              RK45_E6 * k6[i] + RK45_E7 * k7[i]; /* over h */
      const lamc_real old_size = fabs(y[i]), new_size = fabs(y_new[i]);
      const lamc_real ratio = h * error / (atol + rtol * (new_size > old_size ? new_size : old_size));
      sum[j] += ratio * ratio;
      size[j] += new_size;
    }
  /* An infinite y_new has an infinite scale, which would hide it. */
  if (!is_finite(size[0] + size[1] + size[2] + size[3])) return HUGE_VAL;
  return run->ode.n > 0 ? (sum[0] + sum[1] + sum[2] + sum[3]) / run->ode.n : 0.0;
}

/* Works out the continuous extension of the last accepted step: Hairer, Norsett, Wanner I, section II.6, in the
 * nested form of DOPRI5. */
static void make_dense(lamc_run *run) {
  const int m = run->stride;
  const lamc_real h = run->h_last;
  const lamc_real *LAMC_RESTRICT y = slot(run, SLOT_Y + 1 - run->side);
  const lamc_real *LAMC_RESTRICT y_new = slot(run, SLOT_Y + run->side);
  const lamc_real *LAMC_RESTRICT k1 = slot(run, SLOT_SLOPE + 1 - run->side);
  const lamc_real *LAMC_RESTRICT k7 = slot(run, SLOT_SLOPE + run->side);
  const lamc_real *LAMC_RESTRICT k3 = slot(run, SLOT_K2 + 1);
  const lamc_real *LAMC_RESTRICT k4 = slot(run, SLOT_K2 + 2);
  const lamc_real *LAMC_RESTRICT k5 = slot(run, SLOT_K2 + 3);
  const lamc_real *LAMC_RESTRICT k6 = slot(run, SLOT_K2 + 4);
  lamc_real *LAMC_RESTRICT r2 = slot(run, SLOT_DENSE);
  lamc_real *LAMC_RESTRICT r3 = slot(run, SLOT_DENSE + 1);
  lamc_real *LAMC_RESTRICT r4 = slot(run, SLOT_DENSE + 2);
  lamc_real *LAMC_RESTRICT r5 = slot(run, SLOT_DENSE + 3);

  for (int b = 0; b < m; b += LANES)
    for (int i = b; i < b + LANES; i++) {
      const lamc_real change = y_new[i] - y[i];
      const lamc_real bend = h * k1[i] - change;
      r2[i] = change;
      r3[i] = bend;
      r4[i] = change - h * k7[i] - bend;
      r5[i] = h * (D1 * k1[i] + D3 * k3[i] + D4 * k4[i] + D5 * k5[i] + D6 * k6[i] + D7 * k7[i]);
    }
  run->dense = LAMC_DENSE_READY;
}

static void interpolate(const lamc_run *run, lamc_real a, lamc_real *y) {
  const lamc_real *r1 = y_there(run);
  const lamc_real *r2 = slot(run, SLOT_DENSE);
  const lamc_real *r3 = slot(run, SLOT_DENSE + 1);
  const lamc_real *r4 = slot(run, SLOT_DENSE + 2);
  const lamc_real *r5 = slot(run, SLOT_DENSE + 3);
  const lamc_real b = 1.0 - a;
  for (int i = 0; i < run->ode.n; i++) y[i] = r1[i] + a * (r2[i] + b * (r3[i] + a * (r4[i] + b * r5[i])));
}

static lamc_real attempt(lamc_run *run, lamc_real h) {
  take_stages(run, h);
  return squared_error(run, h);
}

static lamc_real eigenvalue(const lamc_run *run) {
  return steepness(run, slope_here(run), slot(run, SLOT_K2 + 4), y_here(run), slot(run, SLOT_STAGE));
}

const method lamc_method_rk45 = {
    OWN_SLOTS,     6,    0.2 - 0.04 * 0.75, 0.04,       10.0,        1,          0, 1.0,
    &lamc_gauss_4, NULL, attempt,           make_dense, interpolate, eigenvalue,
};
