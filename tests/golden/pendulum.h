/* pendulum: equations of motion in C.
 *
 * Made by lamc VERSION from template model.h.j2. Do not edit: change the design and build again.
 * Structure 79eae4208fc6293a3f50c9cfe0d4b3944a6e0b95524b8fc03f3168eafa3785ab
 *
 * Coordinates. q[i] is the angle of joint i in rad, child relative to parent, zero in the drawn configuration and
 * positive by the right-hand rule about the joint's axis; u[i] is its rate in rad/s. SI units throughout.
 *
 *   joint  name
 *       0  h1
 *       1  h2
 *       2  h3
 *
 *   body   name (moving bodies, in the order of poses)
 *       0  link_1
 *       1  link_2
 *       2  link_3
 */
#ifndef PENDULUM_H
#define PENDULUM_H

#include "lamc.h"

#ifdef __cplusplus
extern "C" {
#endif

/* lamc: declarations begin */

/* Sizes of the arrays below. */
enum {
  pendulum_joint_count = 3,
  pendulum_coordinate_count = 3,
  pendulum_rate_count = 3,
  pendulum_cut_count = 0,
  pendulum_closure_count = 0,
  pendulum_body_count = 3,
  pendulum_parameter_count = 22,
  pendulum_geometry_count = 2,
  pendulum_constant_count = 25,
  pendulum_energy_count = 3,
  pendulum_guard_count = 0
};

/* What can change without compiling again. The members are doubles and nothing else, so that the struct is also an
 * array of pendulum_parameter_count + pendulum_geometry_count doubles in this order. */
typedef struct pendulum_parameters {
  double link_1_mass; /* link_1.mass: mass, kg */
  double link_1_com_y; /* link_1.com_y: centre of mass from the hinge, along y of the link's frame, m */
  double link_1_inertia_xx; /* link_1.inertia_xx: moment of inertia about x through the centre of mass, link's frame, kg*m^2 */
  double link_1_inertia_yy; /* link_1.inertia_yy: moment of inertia about y through the centre of mass, link's frame, kg*m^2 */
  double link_1_inertia_zz; /* link_1.inertia_zz: moment of inertia about z through the centre of mass, link's frame, kg*m^2 */
  double link_2_mass; /* link_2.mass: mass, kg */
  double link_2_com_y; /* link_2.com_y: centre of mass from the hinge, along y of the link's frame, m */
  double link_2_inertia_xx; /* link_2.inertia_xx: moment of inertia about x through the centre of mass, link's frame, kg*m^2 */
  double link_2_inertia_yy; /* link_2.inertia_yy: moment of inertia about y through the centre of mass, link's frame, kg*m^2 */
  double link_2_inertia_zz; /* link_2.inertia_zz: moment of inertia about z through the centre of mass, link's frame, kg*m^2 */
  double link_3_mass; /* link_3.mass: mass, kg */
  double link_3_com_y; /* link_3.com_y: centre of mass from the hinge, along y of the link's frame, m */
  double link_3_inertia_xx; /* link_3.inertia_xx: moment of inertia about x through the centre of mass, link's frame, kg*m^2 */
  double link_3_inertia_yy; /* link_3.inertia_yy: moment of inertia about y through the centre of mass, link's frame, kg*m^2 */
  double link_3_inertia_zz; /* link_3.inertia_zz: moment of inertia about z through the centre of mass, link's frame, kg*m^2 */
  double gravity_z; /* gravity.z: gravitational acceleration along world z, m/s^2 */
  double h1_damping; /* h1.damping: viscous damping of the hinge, N*m*s/rad */
  double h2_damping; /* h2.damping: viscous damping of the hinge, N*m*s/rad */
  double h3_damping; /* h3.damping: viscous damping of the hinge, N*m*s/rad */
  double h1_stiffness; /* h1.stiffness: torsional stiffness of the hinge, N*m/rad */
  double h2_stiffness; /* h2.stiffness: torsional stiffness of the hinge, N*m/rad */
  double h3_stiffness; /* h3.stiffness: torsional stiffness of the hinge, N*m/rad */
  double geometry[2]; /* numbers of the drawing, SI: another design of this topology has others */
} pendulum_parameters;

/* Fills in the values of the design. */
void pendulum_default_parameters(pendulum_parameters *parameters);

/* -> constants (25,): everything that depends on parameters only. Call it once per change. */
void pendulum_setup(const pendulum_parameters *parameters, double *constants);

/* t s, q (3,) rad, u (3,) rad/s -> udot (3,) rad/s^2 */
void pendulum_acceleration(const double *constants, double t, const double *q, const double *u, double *udot);

/* -> energies (3,) J: kinetic, hinge_stiffness, gravity */
void pendulum_energy(const double *constants, double t, const double *q, const double *u, double *energies);

/* t, q -> poses (3, 12): centre of mass (3) m, rotation (3, 3) by rows, world from drawn axes */
void pendulum_poses(const double *constants, double t, const double *q, double *poses);

/* q -> M, lower triangle by rows */
void pendulum_inertia(const double *constants, const double *q, double *inertia);

/* t, q, u, accelerations a, forces l of the loops -> derivatives by q, u and t (7 columns) of
 * M a - f, for implicit integrators */
void pendulum_jacobian(const double *constants, double t, const double *q, const double *u, const double *a,
                           const double *l, double *jacobian);

/* All of the above with names, for lamc's runtime. The model is constant and lives as long as the program. */
const lamc_model *pendulum_model(void);

/* lamc: declarations end */

#ifdef __cplusplus
}
#endif

#endif /* PENDULUM_H */
