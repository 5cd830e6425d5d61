/* driven: equations of motion in C.
 *
 * Made by lamc VERSION from template model.h.j2. Do not edit: change the design and build again.
 * Structure 2b58f5c82a523c1f15fdf74364494c8baa1ff19ec91692f438f0136efa533d3c
 *
 * Coordinates. q[i] is the angle of joint i in rad, child relative to parent, zero in the drawn configuration and
 * positive by the right-hand rule about the joint's axis; u[i] is its rate in rad/s. SI units throughout.
 *
 *   joint  name
 *       0  hinge
 *
 *   body   name (moving bodies, in the order of poses)
 *       0  flap
 */
#ifndef DRIVEN_H
#define DRIVEN_H

#include "lamc.h"

#ifdef __cplusplus
extern "C" {
#endif

/* lamc: declarations begin */

/* Sizes of the arrays below. */
enum {
  driven_joint_count = 1,
  driven_coordinate_count = 1,
  driven_rate_count = 1,
  driven_cut_count = 0,
  driven_closure_count = 0,
  driven_body_count = 1,
  driven_parameter_count = 4,
  driven_geometry_count = 0,
  driven_constant_count = 3,
  driven_energy_count = 1,
  driven_guard_count = 0
};

/* What can change without compiling again. The members are doubles and nothing else, so that the struct is also an
 * array of driven_parameter_count + driven_geometry_count doubles in this order. */
typedef struct driven_parameters {
  double flap_mass; /* flap.mass: mass, kg */
  double flap_com_y; /* flap.com_y: centre of mass from the hinge, along y of the link's frame, m */
  double flap_inertia_xx; /* flap.inertia_xx: moment of inertia about x through the centre of mass, link's frame, kg*m^2 */
  double flap_inertia_zz; /* flap.inertia_zz: moment of inertia about z through the centre of mass, link's frame, kg*m^2 */
} driven_parameters;

/* Fills in the values of the design. */
void driven_default_parameters(driven_parameters *parameters);

/* -> constants (3,): everything that depends on parameters only. Call it once per change. */
void driven_setup(const driven_parameters *parameters, double *constants);

/* t s, q (1,) rad, u (1,) rad/s -> udot (1,) rad/s^2 */
void driven_acceleration(const double *constants, double t, const double *q, const double *u, double *udot);

/* -> energies (1,) J: kinetic */
void driven_energy(const double *constants, double t, const double *q, const double *u, double *energies);

/* t, q -> poses (1, 12): centre of mass (3) m, rotation (3, 3) by rows, world from drawn axes */
void driven_poses(const double *constants, double t, const double *q, double *poses);

/* q -> M, lower triangle by rows */
void driven_inertia(const double *constants, const double *q, double *inertia);

/* t, q, u, accelerations a, forces l of the loops -> derivatives by q, u and t (3 columns) of
 * M a - f, for implicit integrators */
void driven_jacobian(const double *constants, double t, const double *q, const double *u, const double *a,
                           const double *l, double *jacobian);

/* All of the above with names, for lamc's runtime. The model is constant and lives as long as the program. */
const lamc_model *driven_model(void);

/* lamc: declarations end */

#ifdef __cplusplus
}
#endif

#endif /* DRIVEN_H */
