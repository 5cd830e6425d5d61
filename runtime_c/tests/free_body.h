/* free_body.h: a rigid body that floats, written by hand in the form that lamc generates: seven coordinates, six rates.
 *
 * q = position (3), quaternion (4) world from body; u = velocity (3) in world axes, angular velocity (3) in body axes.
 * A spring pulls the body's height to zero with stiffness k, and it may bounce on the ground z = 0. */
#ifndef LAMC_TESTS_FREE_BODY_H
#define LAMC_TESTS_FREE_BODY_H

#include "lamc.h"

#include <math.h>
#include <string.h>

enum { NQ = 7, NU = 6, SIZE = NQ + NU };

/* constants: mass kg, moments of inertia A, B, C kg m^2, gravity m/s^2, stiffness k N/m */
static inline void body_setup(const double *p, double *c) {
  for (int i = 0; i < 6; i++) c[i] = p[i];
}

/* dq/dt = q w / 2 */
static inline void body_rates(const double *c, const double *q, const double *u, double *qdot) {
  const double *p = q + 3, *w = u + 3;
  (void)c;
  for (int i = 0; i < 3; i++) qdot[i] = u[i];
  qdot[3] = 0.5 * (-p[1] * w[0] - p[2] * w[1] - p[3] * w[2]);
  qdot[4] = 0.5 * (p[0] * w[0] + p[2] * w[2] - p[3] * w[1]);
  qdot[5] = 0.5 * (p[0] * w[1] + p[3] * w[0] - p[1] * w[2]);
  qdot[6] = 0.5 * (p[0] * w[2] + p[1] * w[1] - p[2] * w[0]);
}

static inline void body_system(const double *c, double t, const double *q, const double *u, double *out) {
  const double *w = u + 3;
  const double moment[3] = {(c[2] - c[3]) * w[1] * w[2], (c[3] - c[1]) * w[2] * w[0],
                            (c[1] - c[2]) * w[0] * w[1]};
  (void)t;
  memset(out, 0, (NU * (NU + 1) / 2 + NU) * sizeof *out);
  for (int i = 0; i < NU; i++) out[i * (i + 1) / 2 + i] = i < 3 ? c[0] : c[i - 2];
  double *f = out + NU * (NU + 1) / 2;
  f[2] = -c[0] * c[4] - c[5] * q[2];
  for (int i = 0; i < 3; i++) f[3 + i] = moment[i];
}

/* Derivatives of M udot - f by q, u and t, then of dq/dt by q and u */
static inline void body_jacobian(const double *c, double t, const double *q, const double *u,
                                 const double *udot, const double *lambda, double *out) {
  const double *p = q + 3, *w = u + 3;
  (void)t, (void)udot, (void)lambda;
  memset(out, 0, (NU * (SIZE + 1) + NQ * SIZE) * sizeof *out);
  const double gap[3] = {c[2] - c[3], c[3] - c[1], c[1] - c[2]};
  out[2 * (SIZE + 1) + 2] = c[5];
  for (int i = 0; i < 3; i++) {
    double *row = out + (3 + i) * (SIZE + 1) + NQ + 3;
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    row[j] = -gap[i] * w[k];
    row[k] = -gap[i] * w[j];
  }
  double *flow = out + NU * (SIZE + 1);
  for (int i = 0; i < 3; i++) flow[i * SIZE + NQ + i] = 1.0;
  const double by_p[4][4] = {{0.0, -w[0], -w[1], -w[2]},
                             {w[0], 0.0, w[2], -w[1]},
                             {w[1], -w[2], 0.0, w[0]},
                             {w[2], w[1], -w[0], 0.0}};
  const double by_w[4][3] = {
      {-p[1], -p[2], -p[3]}, {p[0], -p[3], p[2]}, {p[3], p[0], -p[1]}, {-p[2], p[1], p[0]}};
  for (int i = 0; i < 4; i++) {
    for (int j = 0; j < 4; j++) flow[(3 + i) * SIZE + 3 + j] = 0.5 * by_p[i][j];
    for (int j = 0; j < 3; j++) flow[(3 + i) * SIZE + NQ + 3 + j] = 0.5 * by_w[i][j];
  }
}

/* kinetic, gravity, spring */
static inline void body_energy(const double *c, double t, const double *q, const double *u, double *e) {
  (void)t;
  e[0] = 0.5 * c[0] * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]) +
         0.5 * (c[1] * u[3] * u[3] + c[2] * u[4] * u[4] + c[3] * u[5] * u[5]);
  e[1] = c[0] * c[4] * q[2];
  e[2] = 0.5 * c[5] * q[2] * q[2];
}

static inline void body_power(const double *c, double t, const double *q, const double *u, const double *udot,
                              double *power) {
  (void)t, (void)udot;
  power[0] = -c[0] * c[4] * u[2];
  power[1] = -c[5] * q[2] * u[2];
}

static inline void body_poses(const double *c, double t, const double *q, double *out) {
  const double size = q[3] * q[3] + q[4] * q[4] + q[5] * q[5] + q[6] * q[6];
  const double w = q[3], x = q[4], y = q[5], z = q[6], s = 2.0 / size;
  const double rotation[9] = {
      1.0 - s * (y * y + z * z), s * (x * y - w * z),       s * (x * z + w * y),
      s * (x * y + w * z),       1.0 - s * (x * x + z * z), s * (y * z - w * x),
      s * (x * z - w * y),       s * (y * z + w * x),       1.0 - s * (x * x + y * y)};
  (void)c, (void)t;
  memcpy(out, q, 3 * sizeof *q);
  memcpy(out + 3, rotation, sizeof rotation);
}

/* The ground is met where -z becomes positive */
static inline void body_guards(const double *c, double t, const double *q, const double *u, double *guards) {
  (void)c, (void)t;
  guards[0] = -q[2];
  guards[1] = -u[2];
}

static inline void body_impacts(const double *c, double t, const double *q, double *impacts) {
  (void)c, (void)t, (void)q;
  memset(impacts, 0, (1 + NU) * sizeof *impacts);
  impacts[0] = 0.5;
  impacts[1 + 2] = -1.0;
}

static const char *const BODY_COORDINATES[] = {"x", "y", "z", "qw", "qx", "qy", "qz"};
static const char *const BODY_COORDINATE_UNITS[] = {"m", "m", "m", "1", "1", "1", "1"};
static const char *const BODY_RATES[] = {"vx", "vy", "vz", "wx", "wy", "wz"};
static const char *const BODY_RATE_UNITS[] = {"m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s"};
static const char *const BODY_ENERGIES[] = {"kinetic", "gravity", "spring"};
static const char *const BODY_GUARDS[] = {"ground"};
static const int BODY_MODES[] = {-1};

static inline lamc_model free_body(int is_analytic, int bounces) {
  lamc_model model;
  memset(&model, 0, sizeof model);
  model.name = "free body";
  model.digest = "0";
  model.coordinate_count = NQ;
  model.rate_count = NU;
  model.body_count = 1;
  model.constant_count = model.parameter_count = 6;
  model.energy_count = 3;
  model.power_count = 2;
  model.coordinate_names = BODY_COORDINATES;
  model.coordinate_units = BODY_COORDINATE_UNITS;
  model.rate_names = BODY_RATES;
  model.rate_units = BODY_RATE_UNITS;
  model.energy_names = BODY_ENERGIES;
  model.power_names = BODY_ENERGIES + 1;
  model.jacobian_cost = 2.0;
  model.setup = body_setup;
  model.rates = body_rates;
  model.system = body_system;
  model.energy = body_energy;
  model.poses = body_poses;
  model.power = body_power;
  if (is_analytic) model.jacobian = body_jacobian;
  if (bounces) {
    model.guard_count = 1;
    model.guard_names = BODY_GUARDS;
    model.guard_modes = BODY_MODES;
    model.guards = body_guards;
    model.impacts = body_impacts;
  }
  return model;
}

#endif
