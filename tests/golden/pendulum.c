/* pendulum: equations of motion in C.
 *
 * Made by lamc VERSION from template model.c.j2. Do not edit: change the design and build again.
 * Structure 79eae4208fc6293a3f50c9cfe0d4b3944a6e0b95524b8fc03f3168eafa3785ab
 * Accelerations by mass matrix (operations: elimination 118, mass matrix 106).
 *
 * Operations per call (+ - *, reciprocals, calls of sine and other functions):
 *   setup              38 of which 1 reciprocals; 0 calls
 *   acceleration      106 of which 2 reciprocals; 6 calls
 *   energy             76 of which 0 reciprocals; 6 calls
 *   poses              16 of which 0 reciprocals; 6 calls
 *   inertia            30 of which 0 reciprocals; 6 calls
 *   jacobian          123 of which 0 reciprocals; 6 calls
 */
#include "pendulum.h"

#include "trig.h"

#include <math.h>
#include <stddef.h>

/* everything that depends on parameters only; once per change of parameters */
void pendulum_setup(const pendulum_parameters *p, double *out) {
  /* Inertia about the hinges, base parameters (parallel axes; Gautier & Khalil 1990) */
  const double z0 = 0.5*(p->link_1_inertia_xx - (p->link_1_inertia_yy + p->link_1_inertia_zz));
  const double z1 = p->link_1_mass*p->link_1_com_y;
  const double z2 = 0.5*(p->link_1_inertia_yy - (p->link_1_inertia_xx + p->link_1_inertia_zz)) - p->link_1_com_y*z1;
  const double z3 = z0 + z2;
  const double z4 = 0.5*(p->link_2_inertia_xx - (p->link_2_inertia_yy + p->link_2_inertia_zz));
  const double z5 = p->link_2_mass*p->link_2_com_y;
  const double z6 = 0.5*(p->link_2_inertia_yy - (p->link_2_inertia_xx + p->link_2_inertia_zz)) - p->link_2_com_y*z5;
  const double z7 = z4 + z6;
  const double z8 = p->link_3_mass*p->link_3_com_y;
  const double z9 = 0.5*(p->link_3_inertia_xx - (p->link_3_inertia_yy + p->link_3_inertia_zz)) + (0.5*(p->link_3_inertia_yy - (p->link_3_inertia_xx + p->link_3_inertia_zz)) - p->link_3_com_y*z8);
  const double z10 = z5 + p->link_3_mass;
  const double z11 = p->link_2_mass + p->link_3_mass;
  const double z12 = z1 + z11;
  const double z13 = z0 + (z2 - z11);
  const double z14 = z4 + (z6 - p->link_3_mass);
  /* Elimination of the hinges, tips first (Kane, eq. 19) */
  const double z15 = 1.0/z9;
  out[0] = z8;
  out[1] = z9;
  out[2] = p->gravity_z;
  out[3] = p->h1_damping;
  out[4] = p->h2_damping;
  out[5] = p->h3_damping;
  out[6] = p->h1_stiffness;
  out[7] = p->h2_stiffness;
  out[8] = p->h3_stiffness;
  out[9] = z10;
  out[10] = z12;
  out[11] = z13;
  out[12] = z14;
  out[13] = z15;
  out[14] = p->link_1_mass;
  out[15] = p->link_1_com_y;
  out[16] = z3;
  out[17] = p->link_2_mass;
  out[18] = p->link_2_com_y;
  out[19] = z5;
  out[20] = z7;
  out[21] = p->link_3_mass;
  out[22] = p->link_3_com_y;
  out[23] = p->geometry[1];
  out[24] = p->geometry[0];
}

/* accelerations of the joints, rad/s^2 */
void pendulum_acceleration(const double *c, double t, const double *q, const double *u, double *out) {
  (void)t;
  /* Rotation about the hinges (eq. 1-4) */
  const double z2 = q[0] + q[1];
  const double z5 = q[2] - z2;
  double s1[2], c0[2];
  lamc_turn_two(q[0], z2, s1, c0);
  const double z1 = s1[0], z0 = c0[0];
  const double z4 = s1[1], z3 = c0[1];
  double z7, z6;
  lamc_turn(z5, &z7, &z6);
  /* Hinge damping (T = -c u, eq. 16) [hinge_damping] */
  const double z8 = u[0]*c[3];
  const double z9 = u[1]*c[4];
  const double z10 = u[2]*c[5];
  /* Hinge stiffness (T = -k q, eq. 15) [hinge_stiffness] */
  const double z11 = z8 + q[0]*c[6];
  const double z12 = z9 + q[1]*c[7];
  const double z13 = z10 + q[2]*c[8];
  /* Inertia in carrier frames (eq. 7-11) */
  const double z14 = z4*c[9];
  const double z15 = z3*c[9];
  const double z16 = c[0]*z7;
  const double z17 = c[0]*z6;
  /* Velocities and bias accelerations (eq. 13-14) */
  const double z18 = u[0]*u[0];
  const double z19 = z0*z18;
  const double z20 = c[2] - z1*z18;
  const double z21 = u[0] + u[1];
  const double z22 = z21*z21;
  const double z23 = u[2] - z21;
  const double z24 = z23*z23;
  /* Inertia forces and applied loads (eq. 18) */
  const double z25 = z16*z24;
  const double z26 = z17*z24;
  const double z27 = z16*(z19 + z3*z22) - z17*(z20 - z4*z22);
  /* Elimination of the hinges, tips first (Kane, eq. 19) */
  const double z28 = z13 + z27;
  const double z29 = z3*z17;
  const double z30 = z4*z16;
  const double z31 = z0*(z15 + z17);
  const double z32 = z1*(z14 - z16);
  /* Generalised forces (eq. 18) */
  const double z33 = (z14*z19 + z15*z20) - (z27 - (z4*z26 + z3*z25));
  const double z34 = z1*(z15*z22 + z26) - z0*(z14*z22 - z25);
  /* Mass matrix (Kane, eq. 19) */
  const double z35 = c[1] - (z29 - z30);
  const double z36 = z35 + (z1*z16 - z0*z17);
  const double z37 = c[12] - (2.0*z29 - (c[1] + 2.0*z30));
  /* Solution of M u? = f by L?DL (Kane, eq. 19) */
  const double z38 = c[13]*z35;
  const double z39 = (z37 - (z31 + z32)) - z36*z38;
  const double z40 = c[13]*z36;
  const double z41 = (c[11] - (2.0*z31 + (2.0*z32 - z37))) - z36*z40;
  const double z42 = 1.0/(z37 - z35*z38);
  const double z43 = z39*z42;
  const double z44 = 1.0/(z41 - z39*z43);
  const double z45 = (z12 + z33) + z28*z38;
  const double z46 = (z11 + (c[2]*(z0*c[10]) + (z33 + z34))) + z28*z40;
  const double z47 = z44*(z46 - z43*z45);
  const double z48 = z42*z45 - z43*z47;
  const double z49 = (c[13]*z28 + z38*z48) + z40*z47;
  out[0] = z47;
  out[1] = z48;
  out[2] = z49;
}

/* energies by effect, J; kinetic first */
void pendulum_energy(const double *c, double t, const double *q, const double *u, double *out) {
  (void)t;
  /* Rotation about the hinges (eq. 1-4) */
  const double z2 = q[0] + q[1];
  const double z5 = q[2] - z2;
  double s1[2], c0[2];
  lamc_turn_two(q[0], z2, s1, c0);
  const double z1 = s1[0], z0 = c0[0];
  const double z4 = s1[1], z3 = c0[1];
  double z7, z6;
  lamc_turn(z5, &z7, &z6);
  /* Hinge stiffness (T = -k q, eq. 15) [hinge_stiffness] */
  const double z8 = 0.5*(c[6]*(q[0]*q[0])) + 0.5*(c[7]*(q[1]*q[1]));
  const double z9 = z8 + 0.5*(c[8]*(q[2]*q[2]));
  /* Velocities and bias accelerations (eq. 13-14) */
  const double z10 = u[0] + u[1];
  const double z11 = u[2] - z10;
  /* Velocities (eq. 13-14) */
  const double z12 = u[0]*z0;
  const double z13 = u[0]*z1;
  const double z14 = z12 + z3*z10;
  const double z15 = z13 + z4*z10;
  /* Kinetic energy (1/2  m v^2 + v*(w x h) + 1/2  w*I w) */
  const double z16 = z12*(z10*(c[19]*z3)) + z13*(z10*(c[19]*z4));
  const double z17 = 0.5*(c[17]*(z12*z12 + z13*z13)) + z16;
  const double z18 = 0.5*(u[0]*(u[0]*c[16])) - (z17 - 0.5*(z10*(c[20]*z10)));
  const double z19 = z14*((c[0]*z6)*z11) - z15*((c[0]*z7)*z11);
  const double z20 = 0.5*(c[21]*(z14*z14 + z15*z15)) - z19;
  const double z21 = z18 - (z20 - 0.5*(z11*(c[1]*z11)));
  /* Potential energy (-? m a*r) [gravity] */
  const double z22 = z1 - c[23];
  const double z23 = c[14]*(c[2]*(c[23] - c[15]*z1)) - c[17]*(c[2]*(z22 + c[18]*z4));
  const double z24 = z23 - c[21]*(c[2]*((z4 + z22) - c[22]*z7));
  out[0] = -z21;
  out[1] = z9;
  out[2] = -z24;
}

/* per moving body: centre of mass (3), m, and rotation (9, by rows), world axes */
void pendulum_poses(const double *c, double t, const double *q, double *out) {
  (void)t;
  /* Rotation about the hinges (eq. 1-4) */
  const double z2 = q[0] + q[1];
  const double z5 = q[2] - z2;
  double s1[2], c0[2];
  lamc_turn_two(q[0], z2, s1, c0);
  const double z1 = s1[0], z0 = c0[0];
  const double z4 = s1[1], z3 = c0[1];
  double z7, z6;
  lamc_turn(z5, &z7, &z6);
  /* Potential energy (-? m a*r) [gravity] */
  const double z8 = c[15]*z0;
  const double z9 = c[23] - c[15]*z1;
  const double z10 = z1 - c[23];
  const double z11 = z0 + c[18]*z3;
  const double z12 = z10 + c[18]*z4;
  const double z13 = (z0 + z3) + c[22]*z6;
  const double z14 = (z4 + z10) - c[22]*z7;
  out[0] = z8;
  out[1] = c[24];
  out[2] = z9;
  out[3] = z0;
  out[4] = 0.0;
  out[5] = z1;
  out[6] = 0.0;
  out[7] = 1.0;
  out[8] = 0.0;
  out[9] = -z1;
  out[10] = 0.0;
  out[11] = z0;
  out[12] = z11;
  out[13] = c[24];
  out[14] = -z12;
  out[15] = z3;
  out[16] = 0.0;
  out[17] = z4;
  out[18] = 0.0;
  out[19] = 1.0;
  out[20] = 0.0;
  out[21] = -z4;
  out[22] = 0.0;
  out[23] = z3;
  out[24] = z13;
  out[25] = c[24];
  out[26] = -z14;
  out[27] = z6;
  out[28] = 0.0;
  out[29] = -z7;
  out[30] = 0.0;
  out[31] = 1.0;
  out[32] = 0.0;
  out[33] = z7;
  out[34] = 0.0;
  out[35] = z6;
}

/* mass matrix, lower triangle by rows */
void pendulum_inertia(const double *c, const double *q, double *out) {
  /* Rotation about the hinges (eq. 1-4) */
  const double z2 = q[0] + q[1];
  const double z5 = q[2] - z2;
  double s1[2], c0[2];
  lamc_turn_two(q[0], z2, s1, c0);
  const double z1 = s1[0], z0 = c0[0];
  const double z4 = s1[1], z3 = c0[1];
  double z7, z6;
  lamc_turn(z5, &z7, &z6);
  /* Inertia in carrier frames (eq. 7-11) */
  const double z8 = c[0]*z7;
  const double z9 = c[0]*z6;
  /* Elimination of the hinges, tips first (Kane, eq. 19) */
  const double z10 = z3*z9;
  const double z11 = z4*z8;
  const double z12 = z0*(z3*c[9] + z9);
  const double z13 = z1*(z4*c[9] - z8);
  /* Mass matrix (Kane, eq. 19) */
  const double z14 = c[1] - (z10 - z11);
  const double z15 = z14 + (z1*z8 - z0*z9);
  const double z16 = c[12] - (2.0*z10 - (c[1] + 2.0*z11));
  const double z17 = z16 - (z12 + z13);
  const double z18 = c[11] - (2.0*z12 + (2.0*z13 - z16));
  out[0] = -z18;
  out[1] = -z17;
  out[2] = -z16;
  out[3] = z15;
  out[4] = z14;
  out[5] = -c[1];
}

/* derivatives by q, u and t of M udot - f - J^T lambda, then of J udot + gamma */
void pendulum_jacobian(const double *c, double t, const double *q, const double *u, const double *a, const double *l, double *out) {
  (void)t;
  (void)l;
  /* Rotation about the hinges (eq. 1-4) */
  const double z2 = q[0] + q[1];
  const double z5 = q[2] - z2;
  double s1[2], c0[2];
  lamc_turn_two(q[0], z2, s1, c0);
  const double z1 = s1[0], z0 = c0[0];
  const double z4 = s1[1], z3 = c0[1];
  double z7, z6;
  lamc_turn(z5, &z7, &z6);
  /* Inertia in carrier frames (eq. 7-11) */
  const double z8 = z4*c[9];
  const double z9 = z3*c[9];
  const double z10 = c[0]*z7;
  const double z11 = c[0]*z6;
  /* Velocities and bias accelerations (eq. 13-14) */
  const double z12 = u[0]*u[0];
  const double z13 = u[0] + u[1];
  const double z14 = z13*z13;
  const double z15 = u[2] - z13;
  const double z16 = z15*z15;
  const double z17 = z1*z12 - z0*a[0];
  const double z18 = z0*z12 + z1*a[0];
  const double z19 = c[2] - z17;
  const double z20 = a[0] + a[1];
  const double z21 = z4*z14 - z3*z20;
  const double z22 = z3*z14 + z4*z20;
  const double z23 = a[2] - z20;
  /* Inertia forces and applied loads (eq. 18) */
  const double z24 = z10*z16 - z11*z23;
  const double z25 = z11*z16 + z10*z23;
  /* Derivatives of the residuals (for implicit integrators) */
  const double z26 = z9*z18;
  const double z27 = z8*z19;
  const double z28 = z11*(z18 + z22);
  const double z29 = z10*(z19 - z21);
  const double z30 = (z28 + z10*(z17 + z21)) - (z28 - z29);
  const double z31 = ((z26 - z8*z17) - (z26 + z27)) + z30;
  const double z32 = c[6] - (c[2]*(z1*c[10]) - z31);
  const double z33 = (z28 + z10*z21) + (z29 - z11*z22);
  const double z34 = (z26 - z27) + z33;
  const double z35 = c[7] + z34;
  const double z36 = z0*((z9*z14 + z8*z20) + z25) + z1*((z8*z14 - z9*z20) - z24);
  const double z37 = z34 - z36;
  const double z38 = z28 + z29;
  const double z39 = c[8] + z38;
  const double z40 = z38 - (z3*z25 - z4*z24);
  const double z41 = z40 + (z1*z24 - z0*z25);
  const double z42 = 2.0*u[0];
  const double z43 = z1*z42;
  const double z44 = z0*z42;
  const double z45 = 2.0*z13;
  const double z46 = z4*z45;
  const double z47 = z3*z45;
  const double z48 = 2.0*z15;
  const double z49 = z10*z48;
  const double z50 = z11*z48;
  const double z51 = z10*(z44 + z47) + z11*(z43 + z46);
  const double z52 = z4*z50 + z3*z49;
  const double z53 = (z8*z44 - z9*z43) - (z51 + z52);
  const double z54 = z1*(z9*z45 - z50) - z0*(z8*z45 + z49);
  const double z55 = c[3] + (z53 + z54);
  const double z56 = z10*z47 + z11*z46;
  const double z57 = z52 + z56;
  const double z58 = c[4] - z57;
  const double z59 = z54 - z57;
  const double z60 = z52 + (z1*z50 + z0*z49);
  out[0] = z32;
  out[1] = z37;
  out[2] = -z41;
  out[3] = z55;
  out[4] = z59;
  out[5] = z60;
  out[6] = 0.0;
  out[7] = z31;
  out[8] = z35;
  out[9] = -z40;
  out[10] = z53;
  out[11] = z58;
  out[12] = z52;
  out[13] = 0.0;
  out[14] = -z30;
  out[15] = -z33;
  out[16] = z39;
  out[17] = z51;
  out[18] = z56;
  out[19] = c[5];
  out[20] = 0.0;
}

static const char *const joint_names[] = {
    "h1",
    "h2",
    "h3",
};

static const char *const body_names[] = {
    "link_1",
    "link_2",
    "link_3",
};

static const char *const parameter_names[] = {
    "link_1.mass",
    "link_1.com_y",
    "link_1.inertia_xx",
    "link_1.inertia_yy",
    "link_1.inertia_zz",
    "link_2.mass",
    "link_2.com_y",
    "link_2.inertia_xx",
    "link_2.inertia_yy",
    "link_2.inertia_zz",
    "link_3.mass",
    "link_3.com_y",
    "link_3.inertia_xx",
    "link_3.inertia_yy",
    "link_3.inertia_zz",
    "gravity.z",
    "h1.damping",
    "h2.damping",
    "h3.damping",
    "h1.stiffness",
    "h2.stiffness",
    "h3.stiffness",
};

static const char *const parameter_units[] = {
    "kg",
    "m",
    "kg\302\267m\302\262",
    "kg\302\267m\302\262",
    "kg\302\267m\302\262",
    "kg",
    "m",
    "kg\302\267m\302\262",
    "kg\302\267m\302\262",
    "kg\302\267m\302\262",
    "kg",
    "m",
    "kg\302\267m\302\262",
    "kg\302\267m\302\262",
    "kg\302\267m\302\262",
    "m/s\302\262",
    "N\302\267m\302\267s/rad",
    "N\302\267m\302\267s/rad",
    "N\302\267m\302\267s/rad",
    "N\302\267m/rad",
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
    0.9999836000000001, /* link_1.mass, kg */
    0.5, /* link_1.com_y, m */
    0.16666120008019952, /* link_1.inertia_xx, kg*m^2 */
    0.16666364533333336, /* link_1.inertia_yy, kg*m^2 */
    0.16666091208019948, /* link_1.inertia_zz, kg*m^2 */
    0.9999836, /* link_2.mass, kg */
    0.5, /* link_2.com_y, m */
    0.16666120008019944, /* link_2.inertia_xx, kg*m^2 */
    0.1666636453333333, /* link_2.inertia_yy, kg*m^2 */
    0.16666091208019945, /* link_2.inertia_zz, kg*m^2 */
    0.9999918, /* link_3.mass, kg */
    0.5000040999935202, /* link_3.com_y, m */
    0.16666393335662322, /* link_3.inertia_xx, kg*m^2 */
    0.16666515599999998, /* link_3.inertia_yy, kg*m^2 */
    0.16666378935662324, /* link_3.inertia_zz, kg*m^2 */
    (-9.81), /* gravity.z, m/s^2 */
    10.0, /* h1.damping, N*m*s/rad */
    10.0, /* h2.damping, N*m*s/rad */
    10.0, /* h3.damping, N*m*s/rad */
    100.0, /* h1.stiffness, N*m/rad */
    100.0, /* h2.stiffness, N*m/rad */
    100.0, /* h3.stiffness, N*m/rad */
    0.5,
    0.5,
};

void pendulum_default_parameters(pendulum_parameters *parameters) {
  double *all = (double *)(void *)parameters; /* the struct as the array that it also is */
  for (int i = 0; i < 24; ++i) all[i] = parameter_defaults[i];
}

/* The struct as the array that it also is. */
static void setup_from_array(const double *parameters, double *constants) {
  pendulum_setup((const pendulum_parameters *)(const void *)parameters, constants);
}

const lamc_model *pendulum_model(void) {
  static const lamc_model model = {
      "pendulum",
      "79eae4208fc6293a3f50c9cfe0d4b3944a6e0b95524b8fc03f3168eafa3785ab",
      3,
      3,
      3,
      0,
      0,
      0,
      NULL,
      3,
      22,
      2,
      25,
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
      1.64,
      setup_from_array,
      NULL,
      pendulum_acceleration,
      NULL,
      NULL,
      NULL,
      NULL,
      NULL,
      NULL,
      pendulum_energy,
      pendulum_poses,
      pendulum_inertia,
      pendulum_jacobian,
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
