/* driven: equations of motion in C.
 *
 * Made by lamc VERSION from template model.c.j2. Do not edit: change the design and build again.
 * Structure 2b58f5c82a523c1f15fdf74364494c8baa1ff19ec91692f438f0136efa533d3c
 * Accelerations by elimination (operations: elimination 9, mass matrix 9).
 *
 * Operations per call (+ - *, reciprocals, calls of sine and other functions):
 *   setup               6 of which 1 reciprocals; 0 calls
 *   acceleration        9 of which 0 reciprocals; 3 calls
 *   energy              3 of which 0 reciprocals; 0 calls
 *   poses               2 of which 0 reciprocals; 2 calls
 *   inertia             0 of which 0 reciprocals; 0 calls
 *   jacobian           14 of which 0 reciprocals; 5 calls
 */
#include "driven.h"

#include "trig.h"

#include <math.h>
#include <stddef.h>

/* everything that depends on parameters only; once per change of parameters */
void driven_setup(const driven_parameters *p, double *out) {
  /* Inertia about the hinges, base parameters (parallel axes; Gautier & Khalil 1990) */
  const double z0 = 0.5*(p->flap_inertia_xx + p->flap_inertia_zz) + p->flap_com_y*(p->flap_mass*p->flap_com_y);
  /* Elimination of the hinges, tips first (Kane, eq. 19) */
  const double z1 = 1.0/z0;
  out[0] = z1;
  out[1] = z0;
  out[2] = p->flap_com_y;
}

/* accelerations of the joints, rad/s^2 */
void driven_acceleration(const double *c, double t, const double *q, const double *u, double *out) {
  /* Applied hinge torques (eq. 17) [torque] */
  const double z0 = lamc_sin(314.1592653589793*t);
  const double z1 = fabs(u[0]);
  const double z2 = fmax(q[0], 0.0);
  const double z3 = (0.01*z0 - (0.0001*u[0])*z1) + z2*(z2*z2);
  /* Elimination of the hinges, tips first (Kane, eq. 19) */
  const double z4 = z3*c[0];
  out[0] = z4;
}

/* energies by effect, J; kinetic first */
void driven_energy(const double *c, double t, const double *q, const double *u, double *out) {
  (void)t;
  (void)q;
  /* Kinetic energy (1/2  m v^2 + v*(w x h) + 1/2  w*I w) */
  const double z0 = 0.5*(u[0]*(u[0]*c[1]));
  out[0] = z0;
}

/* per moving body: centre of mass (3), m, and rotation (9, by rows), world axes */
void driven_poses(const double *c, double t, const double *q, double *out) {
  (void)t;
  /* Rotation about the hinges (eq. 1-4) */
  double z1, z0;
  lamc_turn(q[0], &z1, &z0);
  /* Positions and rotations of the links (eq. 1-4) */
  const double z2 = c[2]*z0;
  const double z3 = c[2]*z1;
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
void driven_inertia(const double *c, const double *q, double *out) {
  (void)q;
  out[0] = c[1];
}

/* derivatives by q, u and t of M udot - f - J^T lambda, then of J udot + gamma */
void driven_jacobian(const double *c, double t, const double *q, const double *u, const double *a, const double *l, double *out) {
  (void)c;
  (void)a;
  (void)l;
  /* Applied hinge torques (eq. 17) [torque] */
  const double z0 = 314.1592653589793*t;
  const double z1 = 0.0001*u[0];
  const double z2 = fabs(u[0]);
  const double z3 = fmax(q[0], 0.0);
  const double z4 = z3*z3;
  /* Derivatives of the residuals (for implicit integrators) */
  const double z5 = (((q[0]) > 0) - ((q[0]) < 0));
  const double z6 = 0.5*z5 + 0.5;
  const double z7 = z4*z6 + z3*(2.0*(z3*z6));
  const double z8 = (((u[0]) > 0) - ((u[0]) < 0));
  const double z9 = 0.0001*z2 + z1*z8;
  const double z10 = lamc_cos(z0);
  const double z11 = 3.141592653589793*z10;
  out[0] = -z7;
  out[1] = z9;
  out[2] = -z11;
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
};

static const char *const parameter_units[] = {
    "kg",
    "m",
    "kg\302\267m\302\262",
    "kg\302\267m\302\262",
};

static const char *const energy_names[] = {
    "kinetic",
};

/* Numbers of the design: another one of this structure has others, and all else is the same. */
static const double parameter_defaults[] = {
    0.25, /* flap.mass, kg */
    (-0.5), /* flap.com_y, m */
    0.02, /* flap.inertia_xx, kg*m^2 */
    0.02, /* flap.inertia_zz, kg*m^2 */
};

void driven_default_parameters(driven_parameters *parameters) {
  double *all = (double *)(void *)parameters; /* the struct as the array that it also is */
  for (int i = 0; i < 4; ++i) all[i] = parameter_defaults[i];
}

/* The struct as the array that it also is. */
static void setup_from_array(const double *parameters, double *constants) {
  driven_setup((const driven_parameters *)(const void *)parameters, constants);
}

const lamc_model *driven_model(void) {
  static const lamc_model model = {
      "driven",
      "2b58f5c82a523c1f15fdf74364494c8baa1ff19ec91692f438f0136efa533d3c",
      1,
      1,
      1,
      0,
      0,
      0,
      NULL,
      1,
      4,
      0,
      3,
      1,
      0,
      0,
      0,
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
      1.64,
      setup_from_array,
      NULL,
      driven_acceleration,
      NULL,
      NULL,
      NULL,
      NULL,
      NULL,
      NULL,
      driven_energy,
      driven_poses,
      driven_inertia,
      driven_jacobian,
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
