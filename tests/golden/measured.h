/* measured: equations of motion in C.
 *
 * Made by lamc VERSION from template model.h.j2. Do not edit: change the design and build again.
 * Structure 4302442b2cfd103391327b9e1c30ae3a5101379447143d9e52d4f4ffe41e1691
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
#ifndef MEASURED_H
#define MEASURED_H

#include "lamc.h"

#ifdef __cplusplus
extern "C" {
#endif

/* lamc: declarations begin */

/* Sizes of the arrays below. */
enum {
  measured_joint_count = 1,
  measured_coordinate_count = 1,
  measured_rate_count = 1,
  measured_cut_count = 0,
  measured_closure_count = 0,
  measured_body_count = 1,
  measured_parameter_count = 6,
  measured_geometry_count = 0,
  measured_constant_count = 5,
  measured_energy_count = 2,
  measured_guard_count = 0
};

/* What can change without compiling again. The members are doubles and nothing else, so that the struct is also an
 * array of measured_parameter_count + measured_geometry_count doubles in this order. */
typedef struct measured_parameters {
  double flap_mass; /* flap.mass: mass, kg */
  double flap_com_y; /* flap.com_y: centre of mass from the hinge, along y of the link's frame, m */
  double flap_inertia_xx; /* flap.inertia_xx: moment of inertia about x through the centre of mass, link's frame, kg*m^2 */
  double flap_inertia_zz; /* flap.inertia_zz: moment of inertia about z through the centre of mass, link's frame, kg*m^2 */
  double hinge_rest_angle; /* hinge.rest_angle: angle at which the hinge rests, rad */
  double hinge_stiffness_factor; /* hinge.stiffness_factor: what the hinge's torque is multiplied by, 1 */
} measured_parameters;

/* Fills in the values of the design. */
void measured_default_parameters(measured_parameters *parameters);

/* -> constants (5,): everything that depends on parameters only. Call it once per change. */
void measured_setup(const measured_parameters *parameters, double *constants);

/* t s, q (1,) rad, u (1,) rad/s -> udot (1,) rad/s^2 */
void measured_acceleration(const double *constants, double t, const double *q, const double *u, double *udot);

/* -> energies (2,) J: kinetic, nonlinear_stiffness */
void measured_energy(const double *constants, double t, const double *q, const double *u, double *energies);

/* t, q -> poses (1, 12): centre of mass (3) m, rotation (3, 3) by rows, world from drawn axes */
void measured_poses(const double *constants, double t, const double *q, double *poses);

/* q -> M, lower triangle by rows */
void measured_inertia(const double *constants, const double *q, double *inertia);

/* t, q, u, accelerations a, forces l of the loops -> derivatives by q, u and t (3 columns) of
 * M a - f, for implicit integrators */
void measured_jacobian(const double *constants, double t, const double *q, const double *u, const double *a,
                           const double *l, double *jacobian);

/* All of the above with names, for lamc's runtime. The model is constant and lives as long as the program. */
const lamc_model *measured_model(void);

/* lamc: declarations end */

#ifdef __cplusplus
}
#endif

#endif /* MEASURED_H */
