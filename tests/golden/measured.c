/* measured: equations of motion in C.
 *
 * Made by lamc VERSION from template model.c.j2. Do not edit: change the design and build again.
 * Structure 4302442b2cfd103391327b9e1c30ae3a5101379447143d9e52d4f4ffe41e1691
 * Accelerations by elimination (operations: elimination 3, mass matrix 3).
 *
 * Operations per call (+ - *, reciprocals, calls of sine and other functions):
 *   setup               6 of which 1 reciprocals; 0 calls
 *   acceleration        3 of which 0 reciprocals; 1 calls
 *   energy              5 of which 0 reciprocals; 1 calls
 *   poses               2 of which 0 reciprocals; 2 calls
 *   inertia             0 of which 0 reciprocals; 0 calls
 *   jacobian            2 of which 0 reciprocals; 1 calls
 */
#include "measured.h"

#include "trig.h"

#include <math.h>
#include <stddef.h>

/* The derivative of some order, at x, of a piecewise polynomial with `count` breaks. Rows of `pieces` hold `width`
 * coefficients by rising power: one row for x before the first break, then one from each break on. Powers are of the
 * distance from the row's break, in the first row from the first break. */
static double piecewise(const double *breaks, int count, const double *pieces, int width, int order, double x) {
  int row = 0;
  for (int left = count; left > 0;) { /* bisection for the number of breaks at or before x */
    const int half = left / 2;
    if (breaks[row + half] <= x) {
      row += half + 1;
      left -= half + 1;
    } else {
      left = half;
    }
  }
  const double *const c = pieces + row * width;
  const double distance = x - breaks[row > 0 ? row - 1 : 0];
  double sum = 0.0;
  for (int power = width - 1; power >= order; --power) {
    double factor = 1.0;
    for (int k = 0; k < order; ++k) {
      factor *= power - k;
    }
    sum = sum * distance + factor * c[power];
  }
  return sum;
}

static const double table_0_breaks[] = {
    -1.0,
    -0.25,
    0.0,
    0.5,
    1.0,
};

static const double table_0_pieces[][5] = {
    {0.2020348837209302, -0.5, 0.34689922480620156, 0.0, 0.0},
    {0.2020348837209302, -0.5, 0.34689922480620156, 0.0, -0.04909560723514212},
    {0.00663154069767441, -0.0625, 0.18120155038759692, -0.14728682170542637, -0.007751937984496138},
    {0.0, 0.0, 0.06782945736434107, -0.1550387596899225, 0.34689922480620156},
    {0.019258720930232565, 0.125, 0.35562015503875966, 0.5387596899224807, -0.26937984496124034},
    {0.22117248062015504, 0.75, 0.7596899224806202, 0.0, 0.0},
};

static double table_0(double x, int order) {
  return piecewise(table_0_breaks, 5, table_0_pieces[0], 5, order, x);
}

/* everything that depends on parameters only; once per change of parameters */
void measured_setup(const measured_parameters *p, double *out) {
  /* Inertia about the hinges, base parameters (parallel axes; Gautier & Khalil 1990) */
  const double z0 = 0.5*(p->flap_inertia_xx + p->flap_inertia_zz) + p->flap_com_y*(p->flap_mass*p->flap_com_y);
  /* Elimination of the hinges, tips first (Kane, eq. 19) */
  const double z1 = 1.0/z0;
  out[0] = p->hinge_rest_angle;
  out[1] = p->hinge_stiffness_factor;
  out[2] = z1;
  out[3] = z0;
  out[4] = p->flap_com_y;
}

/* accelerations of the joints, rad/s^2 */
void measured_acceleration(const double *c, double t, const double *q, const double *u, double *out) {
  (void)t;
  (void)u;
  /* Nonlinear stiffness of hinges (T = -dW/dq, W the antiderivative of the given law) [nonlinear_stiffness] */
  const double z0 = table_0(q[0] - c[0], 1);
  const double z1 = c[1]*z0;
  /* Elimination of the hinges, tips first (Kane, eq. 19) */
  const double z2 = z1*c[2];
  out[0] = -z2;
}

/* energies by effect, J; kinetic first */
void measured_energy(const double *c, double t, const double *q, const double *u, double *out) {
  (void)t;
  /* Nonlinear stiffness of hinges (T = -dW/dq, W the antiderivative of the given law) [nonlinear_stiffness] */
  const double z0 = table_0(q[0] - c[0], 0);
  const double z1 = c[1]*z0;
  /* Kinetic energy (1/2  m v^2 + v*(w x h) + 1/2  w*I w) */
  const double z2 = 0.5*(u[0]*(u[0]*c[3]));
  out[0] = z2;
  out[1] = z1;
}

/* per moving body: centre of mass (3), m, and rotation (9, by rows), world axes */
void measured_poses(const double *c, double t, const double *q, double *out) {
  (void)t;
  /* Rotation about the hinges (eq. 1-4) */
  double z1, z0;
  lamc_turn(q[0], &z1, &z0);
  /* Positions and rotations of the links (eq. 1-4) */
  const double z2 = c[4]*z0;
  const double z3 = c[4]*z1;
  out[0] = -z2;
  out[1] = -z3;
  out[2] = 0.0;
  out[3] = z0;
  out[4] = -z1;
  out[5] = 0.0;
  out[6] = z1;
  out[7] = z0;
  out[8] = 0.0;
  out[9] = 0.0;
  out[10] = 0.0;
  out[11] = 1.0;
}

/* mass matrix, lower triangle by rows */
void measured_inertia(const double *c, const double *q, double *out) {
  (void)q;
  out[0] = c[3];
}

/* derivatives by q, u and t of M udot - f - J^T lambda, then of J udot + gamma */
void measured_jacobian(const double *c, double t, const double *q, const double *u, const double *a, const double *l, double *out) {
  (void)t;
  (void)u;
  (void)a;
  (void)l;
  /* Nonlinear stiffness of hinges (T = -dW/dq, W the antiderivative of the given law) [nonlinear_stiffness] */
  const double z0 = q[0] - c[0];
  /* Derivatives of the residuals (for implicit integrators) */
  const double z1 = table_0(z0, 2);
  const double z2 = c[1]*z1;
  out[0] = z2;
  out[1] = 0.0;
  out[2] = 0.0;
}

static const char *const joint_names[] = {
    "hinge",
};

static const char *const body_names[] = {
    "flap",
};

static const char *const parameter_names[] = {
    "flap.mass",
    "flap.com_y",
    "flap.inertia_xx",
    "flap.inertia_zz",
    "hinge.rest_angle",
    "hinge.stiffness_factor",
};

static const char *const parameter_units[] = {
    "kg",
    "m",
    "kg\302\267m\302\262",
    "kg\302\267m\302\262",
    "rad",
    "1",
};

static const char *const energy_names[] = {
    "kinetic",
    "nonlinear_stiffness",
};

/* Numbers of the design: another one of this structure has others, and all else is the same. */
static const double parameter_defaults[] = {
    0.25, /* flap.mass, kg */
    (-0.5), /* flap.com_y, m */
    0.02, /* flap.inertia_xx, kg*m^2 */
    0.02, /* flap.inertia_zz, kg*m^2 */
    0.25, /* hinge.rest_angle, rad */
    1.0, /* hinge.stiffness_factor, 1 */
};

void measured_default_parameters(measured_parameters *parameters) {
  double *all = (double *)(void *)parameters; /* the struct as the array that it also is */
  for (int i = 0; i < 6; ++i) all[i] = parameter_defaults[i];
}

/* The struct as the array that it also is. */
static void setup_from_array(const double *parameters, double *constants) {
  measured_setup((const measured_parameters *)(const void *)parameters, constants);
}

const lamc_model *measured_model(void) {
  static const lamc_model model = {
      "measured",
      "4302442b2cfd103391327b9e1c30ae3a5101379447143d9e52d4f4ffe41e1691",
      1,
      1,
      1,
      0,
      0,
      0,
      NULL,
      1,
      6,
      0,
      5,
      2,
      0,
      0,
      1,
      0,
      joint_names,
      joint_names,
      NULL,
      joint_names,
      NULL,
      body_names,
      parameter_names,
      parameter_units,
      energy_names,
      NULL,
      NULL,
      NULL,
      NULL,
      NULL,
      parameter_defaults,
      NULL,
      0.92,
      setup_from_array,
      NULL,
      measured_acceleration,
      NULL,
      NULL,
      NULL,
      NULL,
      NULL,
      NULL,
      measured_energy,
      measured_poses,
      measured_inertia,
      measured_jacobian,
      NULL,
      NULL,
      NULL,
      NULL,
      NULL,
      0,
      0,
      NULL,
      NULL,
      NULL,
      NULL,
  };
  return &model;
}
