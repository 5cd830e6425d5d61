/* cst: a finite element in C.
 *
 * Made by lamc VERSION from template element.h.j2. Do not edit: change the element and build again.
 * Element digest 61ed2f9e5bb1b392e6e46439026e6cbf730a8f152da46fe378309d9ec856d7b9
 * M. J. Turner, R. W. Clough, H. C. Martin, L. J. Topp, J. Aeronaut. Sci. 23, 1956
 *
 * Corners are counter-clockwise, in m. w is up; curvatures are -(w_xx, w_yy, 2 w_xy). Unknowns, node by node:
 *   0  u, v
 *   1  u, v
 *   2  u, v
 */
#ifndef CST_H
#define CST_H

#include "lamc_plate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* lamc: declarations begin */

enum {
  cst_corner_count = 3,
  cst_node_count = 3,
  cst_unknown_count = 6,
  cst_section_count = 6,
  cst_strain_count = 3,
  cst_field_count = 2,
  cst_value_count = 2
};

/* stiffness, lower triangle by rows, N/m for displacements; here in full.
 * corners (m, 6), sections (m, 6) -> out (m, 6, 6) */
void cst_stiffness(int64_t m, const double *corners, const double *sections, double *out);

/* consistent mass, lower triangle by rows, kg for displacements; here in full.
 * corners (m, 6), areal_mass (m, 1) -> out (m, 6, 6) */
void cst_mass(int64_t m, const double *corners, const double *areal_mass, double *out);

/* forces of a load, N for displacements.
 * corners (m, 6), intensity (m, 6) -> out (m, 6) */
void cst_load(int64_t m, const double *corners, const double *intensity, double *out);

/* forces of membrane forces and moments, N for displacements.
 * corners (m, 6), resultants (m, 3) -> out (m, 6) */
void cst_prestress(int64_t m, const double *corners, const double *resultants, double *out);

/* strains at a point, then curvatures, 1/m.
 * corners (m, 6), at (m, 2), unknowns (m, 6) -> out (m, 3) */
void cst_strain(int64_t m, const double *corners, const double *at, const double *unknowns, double *out);

/* displacements at a point, m, then slopes.
 * corners (m, 6), at (m, 2), unknowns (m, 6) -> out (m, 2) */
void cst_displacement(int64_t m, const double *corners, const double *at, const double *unknowns, double *out);

/* forces of the stiffness by way of strains, N for displacements.
 * corners (m, 6), sections (m, 6), unknowns (m, 6) -> out (m, 6) */
void cst_force(int64_t m, const double *corners, const double *sections, const double *unknowns, double *out);

/* The same as cst_force in long double, for iterative refinement. */
void cst_force_extended(int64_t m, const long double *corners, const long double *sections, const long double *unknowns, long double *out);

/* Adds the stiffness of all cells to the entries of a sparse matrix; row[i] is cell i's row of sections. */
void cst_assemble_stiffness(const lamc_assembly *a, const double *sections, const int32_t *row, double *values);

/* Adds the mass of all cells to the entries of a sparse matrix; row[i] is cell i's row of areal_mass. */
void cst_assemble_mass(const lamc_assembly *a, const double *areal_mass, const int32_t *row, double *values);

/* Adds cst_force of all cells, on the unknowns (N) of a mesh, to forces (N). */
void cst_assemble_force(const lamc_assembly *a, const double *sections, const int32_t *row, const double *unknowns, double *forces);
void cst_assemble_force_extended(const lamc_assembly *a, const double *sections, const int32_t *row, const long double *unknowns, long double *forces);

/* All of the above with names. The element is constant and lives as long as the program. */
const lamc_element *cst_element(void);

/* lamc: declarations end */

#ifdef __cplusplus
}
#endif

#endif /* CST_H */
