/* test_motion.c: rows of accelerations, energies and poses of a compiled model, and its run. The model is written by
 * hand in the form that lamc generates: a point mass on a massless rod that turns about the y axis. */
#include "check.h"
#include "lamc.h"
#include "problems.h"

#include <math.h>
#include <string.h>

enum { ROWS = 3, WORK = 16 * 4 };

/* parameters: length m, gravity m/s^2, mass kg; constants: g / L, m L^2 / 2, m g L, L */
static void setup(const double *p, double *c) {
  c[0] = p[1] / p[0];
  c[1] = 0.5 * p[2] * p[0] * p[0];
  c[2] = p[2] * p[1] * p[0];
  c[3] = p[0];
}

static void acceleration(const double *c, double t, const double *q, const double *u, double *udot) {
  (void)t, (void)u;
  udot[0] = -c[0] * sin(q[0]);
}

static void energy(const double *c, double t, const double *q, const double *u, double *energies) {
  (void)t;
  energies[0] = c[1] * u[0] * u[0];
  energies[1] = -c[2] * cos(q[0]);
}

static void poses(const double *c, double t, const double *q, double *out) {
  (void)t;
  const double cosine = cos(q[0]), sine = sin(q[0]);
  const double pose[12] = {-c[3] * sine, 0.0, -c[3] * cosine, cosine, 0.0,   sine, 0.0,
                           1.0,          0.0, -sine,          0.0,    cosine};
  memcpy(out, pose, sizeof pose);
}

static const char *const JOINTS[] = {"pivot"}, *const BODIES[] = {"bob"};
static const char *const PARAMETERS[] = {"length", "gravity", "mass"}, *const UNITS[] = {"m", "m/s^2", "kg"};
static const char *const ENERGIES[] = {"kinetic", "gravity"};
static const double DEFAULTS[] = {0.5, 9.81, 2.0};
static const lamc_model PENDULUM = {.name = "pendulum",
                                    .digest = "0",
                                    .joint_count = 1,
                                    .coordinate_count = 1,
                                    .rate_count = 1,
                                    .body_count = 1,
                                    .parameter_count = 3,
                                    .constant_count = 4,
                                    .energy_count = 2,
                                    .joint_names = JOINTS,
                                    .coordinate_names = JOINTS,
                                    .rate_names = JOINTS,
                                    .body_names = BODIES,
                                    .parameter_names = PARAMETERS,
                                    .parameter_units = UNITS,
                                    .energy_names = ENERGIES,
                                    .parameter_defaults = DEFAULTS,
                                    .setup = setup,
                                    .acceleration = acceleration,
                                    .energy = energy,
                                    .poses = poses};

static void rows_are_evaluated_one_by_one(check_counts *counts) {
  double constants[4], udot[ROWS], energies[2 * ROWS], pose_rows[12 * ROWS];
  const double t[ROWS] = {0.0, 0.1, 0.2}, y[2 * ROWS] = {0.0, 1.0, 0.5, -1.0, -2.0, 0.25};
  PENDULUM.setup(PENDULUM.parameter_defaults, constants);
  const lamc_motion motion = {&PENDULUM, constants, NULL, 0.0, NULL};
  CHECK(counts, lamc_motion_accelerations(&motion, ROWS, t, y, udot) == LAMC_OK);
  CHECK(counts, lamc_motion_energies(&motion, ROWS, t, y, energies) == LAMC_OK);
  CHECK(counts, lamc_motion_poses(&motion, ROWS, t, y, pose_rows) == LAMC_OK);
  for (int row = 0; row < ROWS; row++) {
    const double q = y[2 * row], u = y[2 * row + 1];
    CHECK(counts, fabs(udot[row] + 9.81 / 0.5 * sin(q)) < 1e-14 * 20.0); /* round-off of numbers up to 20 */
    CHECK(counts,
          fabs(energies[2 * row] - 0.5 * 2.0 * 0.25 * u * u) < 1e-15); /* round-off of numbers up to 1 */
    CHECK(counts, fabs(energies[2 * row + 1] + 2.0 * 9.81 * 0.5 * cos(q)) < 1e-14 * 10.0);
    CHECK(counts, fabs(hypot(pose_rows[12 * row], pose_rows[12 * row + 2]) - 0.5) < 1e-15);
  }
}

static void a_pendulum_swings_with_its_period(check_counts *counts) {
  /* period 4 sqrt(L/g) K(sin(q0/2)); K by the arithmetic-geometric mean, which converges quadratically */
  double constants[4], work[WORK], t, y[2];
  PENDULUM.setup(PENDULUM.parameter_defaults, constants);
  const lamc_motion motion = {&PENDULUM, constants, NULL, 0.0, NULL};
  const lamc_ode ode = lamc_motion_ode(&motion);
  const double y0[2] = {2.0, 0.0};
  double a = 1.0, b = cos(1.0);
  for (int i = 0; i < 8; i++) {
    const double mean = 0.5 * (a + b);
    b = sqrt(a * b);
    a = mean;
  }
  const double period = 2.0 * acos(-1.0) * sqrt(0.5 / 9.81) / a;
  const lamc_options options = {1e-11, 1e-13, 0.0, 0.0, 100000};
  lamc_run run;
  lamc_rows rows = make_rows(&t, y, 1);
  CHECK(counts, ode.n == 2);
  CHECK(counts,
        lamc_run_start(&run, &ode, LAMC_RK45, &options, 0.0, y0, period, &period, 1, work) == LAMC_OK);
  CHECK(counts, lamc_run_advance(&run, &rows, 0, NULL) == LAMC_OK);
  CHECK(counts, fabs(y[0] - 2.0) < 1e-9 && fabs(y[1]) < 1e-8); /* 1e-11 a step, some 500 steps */
}

static void missing_rows_are_refused(check_counts *counts) {
  double constants[4] = {0.0, 0.0, 0.0, 0.0}, out[24];
  const double t[1] = {0.0}, y[2] = {0.0, 0.0};
  const lamc_motion motion = {&PENDULUM, constants, NULL, 0.0, NULL},
                    no_constants = {&PENDULUM, NULL, NULL, 0.0, NULL},
                    no_model = {NULL, constants, NULL, 0.0, NULL};
  CHECK(counts, lamc_motion_accelerations(&motion, 1, NULL, y, out) == LAMC_BAD_ARGUMENT);
  CHECK(counts, lamc_motion_accelerations(NULL, 1, t, y, out) == LAMC_BAD_ARGUMENT);
  CHECK(counts, lamc_motion_energies(&no_constants, 1, t, y, out) == LAMC_BAD_ARGUMENT);
  CHECK(counts, lamc_motion_energies(&motion, -1, t, y, out) == LAMC_BAD_ARGUMENT);
  CHECK(counts, lamc_motion_poses(&no_model, 1, t, y, out) == LAMC_BAD_ARGUMENT);
  CHECK(counts, lamc_motion_poses(&motion, 0, t, y, out) == LAMC_OK);
}

int main(void) {
  const check_case cases[] = {
      CASE(rows_are_evaluated_one_by_one),
      CASE(a_pendulum_swings_with_its_period),
      CASE(missing_rows_are_refused),
  };
  return check_run(cases, (int)(sizeof cases / sizeof *cases));
}
