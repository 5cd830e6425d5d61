/* problems.h: differential equations with known answers, for the tests of the integrators. */
#ifndef LAMC_TESTS_PROBLEMS_H
#define LAMC_TESTS_PROBLEMS_H

#include "lamc.h"

#include <math.h>
#include <string.h>

/* y'' = -y from (0, 1): (sin t, cos t) */
static inline void oscillator(const void *context, double t, const double *y, double *dydt) {
  (void)context, (void)t;
  dydt[0] = y[1];
  dydt[1] = -y[0];
}

/* y' = y cos t from 1: exp(sin t); tells whether the stages get the right times */
static inline void driven(const void *context, double t, const double *y, double *dydt) {
  (void)context;
  dydt[0] = y[0] * cos(t);
}

/* Kepler's orbit, y = [x, y, vx, vy]; from (1 - e, 0, 0, sqrt((1 + e)/(1 - e))) it closes after 2 pi */
static inline void kepler(const void *context, double t, const double *y, double *dydt) {
  (void)context, (void)t;
  const double r2 = y[0] * y[0] + y[1] * y[1];
  const double r3 = r2 * sqrt(r2);
  dydt[0] = y[2];
  dydt[1] = y[3];
  dydt[2] = -y[0] / r3;
  dydt[3] = -y[1] / r3;
}

/* Arenstorf's orbit around earth and moon (Hairer, Norsett, Wanner I, eq. II.0.1) */
static const double ARENSTORF_START[4] = {0.994, 0.0, 0.0, -2.00158510637908252240537862224};
static const double ARENSTORF_PERIOD = 17.0652165601579625588917206249;

static inline void arenstorf(const void *context, double t, const double *y, double *dydt) {
  (void)context, (void)t;
  const double mu = 0.012277471, nu = 1.0 - mu;
  const double a = (y[0] + mu) * (y[0] + mu) + y[1] * y[1];
  const double b = (y[0] - nu) * (y[0] - nu) + y[1] * y[1];
  const double a3 = a * sqrt(a), b3 = b * sqrt(b);
  dydt[0] = y[2];
  dydt[1] = y[3];
  dydt[2] = y[0] + 2.0 * y[3] - nu * (y[0] + mu) / a3 - mu * (y[0] - nu) / b3;
  dydt[3] = y[1] - 2.0 * y[2] - nu * y[1] / a3 - mu * y[1] / b3;
}

/* y' = y^2 from 1: 1 / (1 - t), infinite at t = 1 */
static inline void blow_up(const void *context, double t, const double *y, double *dydt) {
  (void)context, (void)t;
  dydt[0] = y[0] * y[0];
}

/* y' = -sqrt(1 - t): not defined after t = 1 */
static inline void ends_at_one(const void *context, double t, const double *y, double *dydt) {
  (void)context, (void)y;
  dydt[0] = -sqrt(1.0 - t);
}

static inline lamc_ode make_ode(int n, void (*rhs)(const void *, double, const double *, double *)) {
  lamc_ode ode;
  memset(&ode, 0, sizeof ode);
  ode.n = n;
  ode.rhs = rhs;
  return ode;
}

static inline lamc_rows make_rows(double *t, double *y, long long capacity) {
  lamc_rows rows = {t, y, capacity, 0, NULL, NULL, 0, 0, NULL};
  return rows;
}

/* y'' = -k y - c y' + k cos t - c sin t - cos t from (1, 0): cos t whatever k and c; context is {k, c} */
static inline void follower(const void *context, double t, const double *y, double *dydt) {
  const double k = ((const double *)context)[0], c = ((const double *)context)[1];
  dydt[0] = y[1];
  dydt[1] = -k * (y[0] - cos(t)) - c * (y[1] + sin(t)) - cos(t);
}

static inline void follower_jacobian(const void *context, double t, const double *y, double *by_q,
                                     double *by_u, double *by_t, double *scratch) {
  const double k = ((const double *)context)[0], c = ((const double *)context)[1];
  (void)y, (void)scratch;
  by_q[0] = -k;
  by_u[0] = -c;
  by_t[0] = -k * sin(t) - c * cos(t) + sin(t);
}

/* Van der Pol, y'' = mu (1 - y^2) y' - y; context is mu */
static inline void van_der_pol(const void *context, double t, const double *y, double *dydt) {
  const double mu = *(const double *)context;
  (void)t;
  dydt[0] = y[1];
  dydt[1] = mu * (1.0 - y[0] * y[0]) * y[1] - y[0];
}

static inline void van_der_pol_jacobian(const void *context, double t, const double *y, double *by_q,
                                        double *by_u, double *by_t, double *scratch) {
  const double mu = *(const double *)context;
  (void)t, (void)scratch;
  by_q[0] = -2.0 * mu * y[0] * y[1] - 1.0;
  by_u[0] = mu * (1.0 - y[0] * y[0]);
  by_t[0] = 0.0;
}

/* Kepler's orbit again, with what implicit methods ask for */
static inline void kepler_jacobian(const void *context, double t, const double *y, double *by_q, double *by_u,
                                   double *by_t, double *scratch) {
  (void)context, (void)t, (void)scratch;
  const double r2 = y[0] * y[0] + y[1] * y[1];
  const double r5 = r2 * r2 * sqrt(r2);
  by_q[0] = (3.0 * y[0] * y[0] - r2) / r5;
  by_q[1] = by_q[2] = 3.0 * y[0] * y[1] / r5;
  by_q[3] = (3.0 * y[1] * y[1] - r2) / r5;
  for (int i = 0; i < 4; i++) by_u[i] = 0.0;
  by_t[0] = by_t[1] = 0.0;
}

static inline lamc_options tolerance(double rtol) {
  lamc_options options = {rtol, rtol * 1e-2, 0.0, 0.0, 1000000};
  return options;
}

/* steps of one length: tolerances that nothing exceeds, and a limit that every step meets */
static inline lamc_options fixed_step(double h) {
  lamc_options options = {1.0, 1e6, h, h, 1000000};
  return options;
}

#endif
