/* two links in space: equations of motion in C.
 *
 * Made by lamc VERSION from template model.h.j2. Do not edit: change the design and build again.
 * Structure c31ee40c84e1381f1254e56064489d413dc4bbc0b56b2a3bc54436d6a985693f
 *
 * Coordinates. q[i] is the angle of joint i in rad, child relative to parent, zero in the drawn configuration and
 * positive by the right-hand rule about the joint's axis; u[i] is its rate in rad/s. SI units throughout.
 *
 *   joint  name
 *       0  shoulder
 *       1  elbow
 *
 *   body   name (moving bodies, in the order of poses)
 *       0  upper
 *       1  lower
 */
#ifndef TWO_LINKS_IN_SPACE_H
#define TWO_LINKS_IN_SPACE_H

#include "lamc.h"

#ifdef __cplusplus
extern "C" {
#endif

/* lamc: declarations begin */

/* Sizes of the arrays below. */
enum {
  two_links_in_space_joint_count = 2,
  two_links_in_space_coordinate_count = 2,
  two_links_in_space_rate_count = 2,
  two_links_in_space_cut_count = 0,
  two_links_in_space_closure_count = 0,
  two_links_in_space_body_count = 2,
  two_links_in_space_parameter_count = 17,
  two_links_in_space_geometry_count = 7,
  two_links_in_space_constant_count = 34,
  two_links_in_space_energy_count = 3,
  two_links_in_space_guard_count = 0
};

/* What can change without compiling again. The members are doubles and nothing else, so that the struct is also an
 * array of two_links_in_space_parameter_count + two_links_in_space_geometry_count doubles in this order. */
typedef struct two_links_in_space_parameters {
  double upper_mass; /* upper.mass: mass, kg */
  double upper_com_x; /* upper.com_x: centre of mass from the hinge, along x of the link's frame, m */
  double upper_inertia_xx; /* upper.inertia_xx: moment of inertia about x through the centre of mass, link's frame, kg*m^2 */
  double upper_inertia_yy; /* upper.inertia_yy: moment of inertia about y through the centre of mass, link's frame, kg*m^2 */
  double upper_inertia_zz; /* upper.inertia_zz: moment of inertia about z through the centre of mass, link's frame, kg*m^2 */
  double upper_inertia_xz; /* upper.inertia_xz: product of inertia (off-diagonal entry) xz about the centre of mass, link's frame, kg*m^2 */
  double lower_mass; /* lower.mass: mass, kg */
  double lower_com_y; /* lower.com_y: centre of mass from the hinge, along y of the link's frame, m */
  double lower_com_z; /* lower.com_z: centre of mass from the hinge, along z of the link's frame, m */
  double lower_inertia_xx; /* lower.inertia_xx: moment of inertia about x through the centre of mass, link's frame, kg*m^2 */
  double lower_inertia_yy; /* lower.inertia_yy: moment of inertia about y through the centre of mass, link's frame, kg*m^2 */
  double lower_inertia_zz; /* lower.inertia_zz: moment of inertia about z through the centre of mass, link's frame, kg*m^2 */
  double lower_inertia_yz; /* lower.inertia_yz: product of inertia (off-diagonal entry) yz about the centre of mass, link's frame, kg*m^2 */
  double gravity_z; /* gravity.z: gravitational acceleration along world z, m/s^2 */
  double shoulder_damping; /* shoulder.damping: viscous damping of the hinge, N*m*s/rad */
  double shoulder_stiffness; /* shoulder.stiffness: torsional stiffness of the hinge, N*m/rad */
  double elbow_stiffness; /* elbow.stiffness: torsional stiffness of the hinge, N*m/rad */
  double geometry[7]; /* numbers of the drawing, SI: another design of this topology has others */
} two_links_in_space_parameters;

/* Fills in the values of the design. */
void two_links_in_space_default_parameters(two_links_in_space_parameters *parameters);

/* -> constants (34,): everything that depends on parameters only. Call it once per change. */
void two_links_in_space_setup(const two_links_in_space_parameters *parameters, double *constants);

/* t s, q (2,) rad, u (2,) rad/s -> udot (2,) rad/s^2 */
void two_links_in_space_acceleration(const double *constants, double t, const double *q, const double *u, double *udot);

/* -> energies (3,) J: kinetic, hinge_stiffness, gravity */
void two_links_in_space_energy(const double *constants, double t, const double *q, const double *u, double *energies);

/* t, q -> poses (2, 12): centre of mass (3) m, rotation (3, 3) by rows, world from drawn axes */
void two_links_in_space_poses(const double *constants, double t, const double *q, double *poses);

/* q -> M, lower triangle by rows */
void two_links_in_space_inertia(const double *constants, const double *q, double *inertia);

/* t, q, u, accelerations a, forces l of the loops -> derivatives by q, u and t (5 columns) of
 * M a - f, for implicit integrators */
void two_links_in_space_jacobian(const double *constants, double t, const double *q, const double *u, const double *a,
                           const double *l, double *jacobian);

/* All of the above with names, for lamc's runtime. The model is constant and lives as long as the program. */
const lamc_model *two_links_in_space_model(void);

/* lamc: declarations end */

#ifdef __cplusplus
}
#endif

#endif /* TWO_LINKS_IN_SPACE_H */
