/* two links in space: equations of motion in C.
 *
 * Made by lamc VERSION from template model.c.j2. Do not edit: change the design and build again.
 * Structure c31ee40c84e1381f1254e56064489d413dc4bbc0b56b2a3bc54436d6a985693f
 * Accelerations by mass matrix (operations: elimination 108, mass matrix 99).
 *
 * Operations per call (+ - *, reciprocals, calls of sine and other functions):
 *   setup              44 of which 1 reciprocals; 0 calls
 *   acceleration       99 of which 1 reciprocals; 4 calls
 *   energy             65 of which 0 reciprocals; 4 calls
 *   poses              46 of which 0 reciprocals; 4 calls
 *   inertia            19 of which 0 reciprocals; 2 calls
 *   jacobian          180 of which 0 reciprocals; 4 calls
 */
#include "two_links_in_space.h"

#include "trig.h"

#include <math.h>
#include <stddef.h>

/* everything that depends on parameters only; once per change of parameters */
void two_links_in_space_setup(const two_links_in_space_parameters *p, double *out) {
  /* Inertia about the hinges, base parameters (parallel axes; Gautier & Khalil 1990) */
  const double z0 = 0.5*(p->upper_inertia_yy - (p->upper_inertia_xx + p->upper_inertia_zz));
  const double z1 = p->upper_mass*p->upper_com_x;
  const double z2 = 0.5*(p->upper_inertia_xx - (p->upper_inertia_yy + p->upper_inertia_zz)) - p->upper_com_x*z1;
  const double z3 = z0 + z2;
  const double z4 = 0.5*(p->lower_inertia_xx - (p->lower_inertia_yy + p->lower_inertia_zz));
  const double z5 = p->lower_mass*p->lower_com_y;
  const double z6 = p->lower_mass*p->lower_com_z;
  const double z7 = 0.5*(p->lower_inertia_yy - (p->lower_inertia_xx + p->lower_inertia_zz)) - p->lower_com_y*z5;
  const double z8 = 0.5*(p->lower_inertia_zz - (p->lower_inertia_xx + p->lower_inertia_yy)) - p->lower_com_z*z6;
  const double z9 = p->lower_inertia_yz - p->lower_com_z*z5;
  const double z10 = z4 + z7;
  const double z11 = z6*p->geometry[2];
  const double z12 = z1 + p->lower_mass;
  const double z13 = (z2 - p->lower_mass) + (z0 + z8*(p->geometry[2]*p->geometry[2]));
  /* Elimination of the hinges, tips first (Kane, eq. 19) */
  const double z14 = 1.0/z10;
  const double z15 = 2.0*p->geometry[0];
  /* Mass matrix (Kane, eq. 19) */
  const double z16 = z10*p->geometry[0];
  const double z17 = z4 - z7;
  /* Kinetic energy (1/2  m v^2 + v*(w x h) + 1/2  w*I w) */
  const double z18 = z7 + z8;
  const double z19 = z4 + z8;
  /* Potential energy (-? m a*r) [gravity] */
  const double z20 = p->lower_com_z*p->geometry[0];
  /* Positions and rotations of the links (eq. 1-4) */
  const double z21 = p->geometry[0]*p->geometry[4];
  const double z22 = p->geometry[0]*p->geometry[6];
  out[0] = z4;
  out[1] = z5;
  out[2] = z7;
  out[3] = z9;
  out[4] = p->geometry[0];
  out[5] = p->geometry[1];
  out[6] = p->gravity_z;
  out[7] = p->shoulder_damping;
  out[8] = p->shoulder_stiffness;
  out[9] = p->elbow_stiffness;
  out[10] = z11;
  out[11] = z12;
  out[12] = z13;
  out[13] = z14;
  out[14] = z15;
  out[15] = z16;
  out[16] = z17;
  out[17] = p->upper_mass;
  out[18] = p->upper_com_x;
  out[19] = z3;
  out[20] = p->lower_mass;
  out[21] = p->lower_com_y;
  out[22] = p->lower_com_z;
  out[23] = z6;
  out[24] = z10;
  out[25] = z18;
  out[26] = z19;
  out[27] = z20;
  out[28] = p->geometry[3];
  out[29] = p->geometry[4];
  out[30] = p->geometry[5];
  out[31] = p->geometry[6];
  out[32] = z21;
  out[33] = z22;
}

/* accelerations of the joints, rad/s^2 */
void two_links_in_space_acceleration(const double *c, double t, const double *q, const double *u, double *out) {
  (void)t;
  /* Rotation about the hinges (eq. 1-4) */
  double s1[2], c0[2];
  lamc_turn_two(q[0], q[1], s1, c0);
  const double z1 = s1[0], z0 = c0[0];
  const double z3 = s1[1], z2 = c0[1];
  /* Hinge damping (T = -c u, eq. 16) [hinge_damping] */
  const double z4 = u[0]*c[7];
  /* Hinge stiffness (T = -k q, eq. 15) [hinge_stiffness] */
  const double z5 = z4 + q[0]*c[8];
  const double z6 = q[1]*c[9];
  /* Velocities and bias accelerations (eq. 13-14) */
  const double z7 = z1*c[6];
  const double z8 = z0*c[6];
  const double z9 = u[0]*c[5];
  const double z10 = z3*z9;
  const double z11 = z2*z9;
  const double z12 = u[1]*z10;
  const double z13 = u[1] + u[0]*c[4];
  const double z14 = z2*(z7 - u[0]*u[0]) + z3*(c[4]*z8);
  const double z15 = z10*z10;
  const double z16 = z10*z11;
  const double z17 = z10*z13;
  const double z18 = z15 + z13*z13;
  const double z19 = u[1]*z11 + z11*z13;
  /* Inertia forces and applied loads (eq. 18) */
  const double z20 = (c[2]*z19 - c[3]*(z15 + z11*z11)) + c[3]*z18;
  const double z21 = c[0]*z16 - (c[2]*z16 - c[3]*(z12 - z17));
  const double z22 = z21 + c[1]*z14;
  /* Elimination of the hinges, tips first (Kane, eq. 19) */
  const double z23 = z6 - z22;
  const double z24 = c[1]*z3;
  /* Generalised forces (eq. 18) */
  const double z25 = c[4]*(z2*(c[1]*z18) - z3*(c[1]*z16));
  const double z26 = z3*(z20 + c[1]*(c[5]*z8)) + z2*(c[3]*z16 - c[0]*(z12 + z17));
  const double z27 = (c[5]*(c[1]*z19) + z25) + (c[5]*z26 + c[4]*z22);
  /* Mass matrix (Kane, eq. 19) */
  const double z28 = c[3]*z2;
  const double z29 = c[4]*z24 - (c[5]*z28 - c[15]);
  const double z30 = z3*(z3*c[16]);
  const double z31 = c[2] + z30;
  const double z32 = (z31 - c[5]*(c[5]*z31 + c[14]*z28)) + ((c[0] - z30) + 2.0*z24);
  /* Solution of M u? = f by L?DL (Kane, eq. 19) */
  const double z33 = c[13]*z29;
  const double z34 = 1.0/((c[12] + z32) - z29*z33);
  const double z35 = (z5 + ((c[11]*z8 - c[10]*z7) - z27)) - z23*z33;
  const double z36 = z34*z35;
  const double z37 = c[13]*z23 - z33*z36;
  out[0] = z36;
  out[1] = z37;
}

/* energies by effect, J; kinetic first */
void two_links_in_space_energy(const double *c, double t, const double *q, const double *u, double *out) {
  (void)t;
  /* Rotation about the hinges (eq. 1-4) */
  double s1[2], c0[2];
  lamc_turn_two(q[0], q[1], s1, c0);
  const double z1 = s1[0], z0 = c0[0];
  const double z3 = s1[1], z2 = c0[1];
  /* Hinge stiffness (T = -k q, eq. 15) [hinge_stiffness] */
  const double z4 = 0.5*(c[8]*(q[0]*q[0])) + 0.5*(c[9]*(q[1]*q[1]));
  /* Velocities and bias accelerations (eq. 13-14) */
  const double z5 = u[0]*c[5];
  const double z6 = u[0]*c[4];
  const double z7 = z3*z5;
  const double z8 = z2*z5;
  const double z9 = u[1] + z6;
  /* Velocities (eq. 13-14) */
  const double z10 = z3*z6;
  const double z11 = z2*z6;
  /* Kinetic energy (1/2  m v^2 + v*(w x h) + 1/2  w*I w) */
  const double z12 = z7*(z7*c[25]) + z8*(z8*c[26] - c[3]*z9);
  const double z13 = c[20]*(z5*z5 + (z10*z10 + z11*z11));
  const double z14 = z10*(c[23]*z8 - c[1]*z9) - z11*(c[23]*z7);
  const double z15 = 0.5*(z9*(c[3]*z8 - c[24]*z9) - z12);
  const double z16 = (0.5*z13 - (z5*(c[1]*z7) - z14)) + z15;
  const double z17 = 0.5*(u[0]*(u[0]*c[19])) - z16;
  /* Potential energy (-? m a*r) [gravity] */
  const double z18 = c[21]*(z2*(z0*c[4]) - z1*z3) - c[22]*(z0*c[5]);
  const double z19 = c[17]*(c[6]*(c[18]*z1)) + c[20]*(c[6]*(z1 + z18));
  out[0] = -z17;
  out[1] = z4;
  out[2] = z19;
}

/* per moving body: centre of mass (3), m, and rotation (9, by rows), world axes */
void two_links_in_space_poses(const double *c, double t, const double *q, double *out) {
  (void)t;
  /* Rotation about the hinges (eq. 1-4) */
  double s1[2], c0[2];
  lamc_turn_two(q[0], q[1], s1, c0);
  const double z1 = s1[0], z0 = c0[0];
  const double z3 = s1[1], z2 = c0[1];
  /* Potential energy (-? m a*r) [gravity] */
  const double z4 = c[18]*z0;
  const double z5 = c[18]*z1;
  const double z6 = z1*c[4];
  const double z7 = z1*c[5];
  const double z8 = z0*c[4];
  const double z9 = z0*c[5];
  const double z10 = z0*z2 - z3*z6;
  const double z11 = z2*z6 + z0*z3;
  const double z12 = z3*c[5];
  const double z13 = z2*c[5];
  const double z14 = z1*z2 + z3*z8;
  const double z15 = z2*z8 - z1*z3;
  const double z16 = c[21]*z13 + c[27];
  const double z17 = z0 - (c[21]*z11 - c[22]*z7);
  const double z18 = z1 + (c[21]*z15 - c[22]*z9);
  /* Positions and rotations of the links (eq. 1-4) */
  const double z19 = z11*c[28] - z7*c[29];
  const double z20 = z11*c[30] - z7*c[31];
  const double z21 = z13*c[28] + c[32];
  const double z22 = z13*c[30] + c[33];
  const double z23 = z15*c[28] - z9*c[29];
  const double z24 = z15*c[30] - z9*c[31];
  out[0] = z4;
  out[1] = 0.0;
  out[2] = -z5;
  out[3] = z0;
  out[4] = 0.0;
  out[5] = z1;
  out[6] = 0.0;
  out[7] = 1.0;
  out[8] = 0.0;
  out[9] = -z1;
  out[10] = 0.0;
  out[11] = z0;
  out[12] = z17;
  out[13] = z16;
  out[14] = -z18;
  out[15] = z10;
  out[16] = -z19;
  out[17] = -z20;
  out[18] = z12;
  out[19] = z21;
  out[20] = z22;
  out[21] = -z14;
  out[22] = -z23;
  out[23] = -z24;
}

/* mass matrix, lower triangle by rows */
void two_links_in_space_inertia(const double *c, const double *q, double *out) {
  /* Rotation about the hinges (eq. 1-4) */
  double z1, z0;
  lamc_turn(q[1], &z1, &z0);
  /* Elimination of the hinges, tips first (Kane, eq. 19) */
  const double z2 = c[1]*z1;
  /* Mass matrix (Kane, eq. 19) */
  const double z3 = c[3]*z0;
  const double z4 = c[4]*z2 - (c[5]*z3 - c[15]);
  const double z5 = z1*(z1*c[16]);
  const double z6 = c[2] + z5;
  const double z7 = (z6 - c[5]*(c[5]*z6 + c[14]*z3)) + ((c[0] - z5) + 2.0*z2);
  const double z8 = c[12] + z7;
  out[0] = -z8;
  out[1] = -z4;
  out[2] = -c[24];
}

/* derivatives by q, u and t of M udot - f - J^T lambda, then of J udot + gamma */
void two_links_in_space_jacobian(const double *c, double t, const double *q, const double *u, const double *a, const double *l, double *out) {
  (void)t;
  (void)l;
  /* Rotation about the hinges (eq. 1-4) */
  double s1[2], c0[2];
  lamc_turn_two(q[0], q[1], s1, c0);
  const double z1 = s1[0], z0 = c0[0];
  const double z3 = s1[1], z2 = c0[1];
  /* Velocities and bias accelerations (eq. 13-14) */
  const double z4 = z1*c[6];
  const double z5 = z0*c[6];
  const double z6 = u[0]*c[5];
  const double z7 = z3*z6;
  const double z8 = z2*z6;
  const double z9 = u[1] + u[0]*c[4];
  const double z10 = z7*z7;
  const double z11 = z8*z8;
  const double z12 = z7*z8;
  const double z13 = z8*z9;
  const double z14 = z10 + z9*z9;
  /* Potential energy (-? m a*r) [gravity] */
  const double z15 = z3*c[5];
  const double z16 = z2*c[5];
  /* Velocities and bias accelerations (eq. 13-14) */
  const double z17 = z5 + a[0];
  const double z18 = c[5]*a[0];
  const double z19 = u[1]*z8 + z3*z18;
  const double z20 = z3*(z4 - u[0]*u[0]) - z2*(c[4]*z17);
  const double z21 = z12 - (a[1] + c[4]*a[0]);
  const double z22 = z7*z9 + (u[1]*z7 - z2*z18);
  const double z23 = z13 + z19;
  /* Inertia forces and applied loads (eq. 18) */
  const double z24 = c[3]*z14 - (c[3]*(z10 + z11) - c[2]*z23);
  /* Derivatives of the residuals (for implicit integrators) */
  const double z25 = c[1]*(z2*z5 - z3*(c[4]*z4));
  const double z26 = c[5]*(z3*(c[1]*(c[5]*z4))) - c[4]*z25;
  const double z27 = c[8] - ((c[11]*z4 + c[10]*z5) - z26);
  const double z28 = 2.0*z12;
  const double z29 = z10 - z11;
  const double z30 = c[0]*z29 - (c[2]*z29 - c[3]*(z13 - z19));
  const double z31 = z30 + c[1]*z20;
  const double z32 = c[9] + z31;
  const double z33 = (z3*(c[1]*z14) - z2*(c[1]*z28)) + (z2*(c[1]*z21) - z3*(c[1]*z29));
  const double z34 = z2*(z24 + c[1]*(c[5]*z17)) + z3*(c[3]*z28 - c[2]*z22);
  const double z35 = z3*(c[3]*z21 - c[0]*z22) + z2*(c[3]*z29 + c[0]*z23);
  const double z36 = (c[4]*z33 + c[5]*(c[1]*z22)) - (c[5]*(z34 - z35) - c[4]*z31);
  const double z37 = u[1]*z15;
  const double z38 = 2.0*(z7*z15);
  const double z39 = z8*z15 + z7*z16;
  const double z40 = z9*z15 + c[4]*z7;
  const double z41 = z38 + 2.0*(c[4]*z9);
  const double z42 = u[1]*z16 + (z9*z16 + c[4]*z8);
  const double z43 = c[3]*(z38 + 2.0*(z8*z16)) - c[2]*z42;
  const double z44 = c[0]*z39 - (c[2]*z39 - c[3]*(z37 - z40));
  const double z45 = z44 - c[1]*(z2*(2.0*u[0]));
  const double z46 = c[4]*(z2*(c[1]*z41) - z3*(c[1]*z39));
  const double z47 = z3*(c[3]*z41 - z43) + z2*(c[3]*z39 - c[0]*(z37 + z40));
  const double z48 = (z46 + c[5]*(c[1]*z42)) + (c[5]*z47 + c[4]*z45);
  const double z49 = c[7] - z48;
  const double z50 = 2.0*z9;
  const double z51 = 2.0*z8;
  const double z52 = c[4]*(z2*(c[1]*z50)) + c[5]*(c[1]*z51);
  const double z53 = z3*(c[3]*z50 + c[2]*z51) - z2*(c[0]*(2.0*z7));
  const double z54 = z52 + c[5]*z53;
  out[0] = z27;
  out[1] = z36;
  out[2] = z49;
  out[3] = -z54;
  out[4] = 0.0;
  out[5] = -z25;
  out[6] = z32;
  out[7] = -z45;
  out[8] = 0.0;
  out[9] = 0.0;
}

static const char *const joint_names[] = {
    "shoulder",
    "elbow",
};

static const char *const body_names[] = {
    "upper",
    "lower",
};

static const char *const parameter_names[] = {
    "upper.mass",
    "upper.com_x",
    "upper.inertia_xx",
    "upper.inertia_yy",
    "upper.inertia_zz",
    "upper.inertia_xz",
    "lower.mass",
    "lower.com_y",
    "lower.com_z",
    "lower.inertia_xx",
    "lower.inertia_yy",
    "lower.inertia_zz",
    "lower.inertia_yz",
    "gravity.z",
    "shoulder.damping",
    "shoulder.stiffness",
    "elbow.stiffness",
};

static const char *const parameter_units[] = {
    "kg",
    "m",
    "kg\302\267m\302\262",
    "kg\302\267m\302\262",
    "kg\302\267m\302\262",
    "kg\302\267m\302\262",
    "kg",
    "m",
    "m",
    "kg\302\267m\302\262",
    "kg\302\267m\302\262",
    "kg\302\267m\302\262",
    "kg\302\267m\302\262",
    "m/s\302\262",
    "N\302\267m\302\267s/rad",
    "N\302\267m/rad",
    "N\302\267m/rad",
};

static const char *const energy_names[] = {
    "kinetic",
    "hinge_stiffness",
    "gravity",
};

/* Numbers of the design: another one of this structure has others, and all else is the same. */
static const double parameter_defaults[] = {
    1.0, /* upper.mass, kg */
    0.5, /* upper.com_x, m */
    0.02, /* upper.inertia_xx, kg*m^2 */
    0.1, /* upper.inertia_yy, kg*m^2 */
    0.1, /* upper.inertia_zz, kg*m^2 */
    0.001, /* upper.inertia_xz, kg*m^2 */
    0.5, /* lower.mass, kg */
    0.2, /* lower.com_y, m */
    0.15, /* lower.com_z, m */
    0.05, /* lower.inertia_xx, kg*m^2 */
    0.024399999999999998, /* lower.inertia_yy, kg*m^2 */
    0.03560000000000001, /* lower.inertia_zz, kg*m^2 */
    (-0.019200000000000002), /* lower.inertia_yz, kg*m^2 */
    (-9.81), /* gravity.z, m/s^2 */
    0.125, /* shoulder.damping, N*m*s/rad */
    2.0, /* shoulder.stiffness, N*m/rad */
    1.5, /* elbow.stiffness, N*m/rad */
    0.6,
    0.8,
    (-0.8),
    0.8,
    0.6,
    (-0.6),
    0.8,
};

void two_links_in_space_default_parameters(two_links_in_space_parameters *parameters) {
  double *all = (double *)(void *)parameters; /* the struct as the array that it also is */
  for (int i = 0; i < 24; ++i) all[i] = parameter_defaults[i];
}

/* The struct as the array that it also is. */
static void setup_from_array(const double *parameters, double *constants) {
  two_links_in_space_setup((const two_links_in_space_parameters *)(const void *)parameters, constants);
}

const lamc_model *two_links_in_space_model(void) {
  static const lamc_model model = {
      "two links in space",
      "c31ee40c84e1381f1254e56064489d413dc4bbc0b56b2a3bc54436d6a985693f",
      2,
      2,
      2,
      0,
      0,
      0,
      NULL,
      2,
      17,
      7,
      34,
      3,
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
      1.86,
      setup_from_array,
      NULL,
      two_links_in_space_acceleration,
      NULL,
      NULL,
      NULL,
      NULL,
      NULL,
      NULL,
      two_links_in_space_energy,
      two_links_in_space_poses,
      two_links_in_space_inertia,
      two_links_in_space_jacobian,
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
