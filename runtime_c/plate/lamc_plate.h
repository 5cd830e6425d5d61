/* lamc_plate.h: what finite elements that lamc has compiled have in common, and sparse matrices made of them.
 *
 * Nothing here allocates, prints or keeps state. Arrays are by rows; SI units. A section is the unique entries of a
 * symmetric 3 by 3 matrix in the order 11, 12, 16, 22, 26, 66; of A or D, or of A, B and D.
 */
#ifndef LAMC_PLATE_H
#define LAMC_PLATE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* lamc: declarations begin */

/* Cells of a mesh, in the order in which they are assembled, and where what they give belongs in a sparse matrix of
 * columns. An element has n nodes; the unknowns of a node follow one another, and their columns have the same rows. */
typedef struct lamc_assembly {
  int64_t cell_count;
  int32_t node_count;       /* n, nodes of a cell */
  int32_t unknown_count;    /* N, rows and columns of the matrix */
  const int32_t *node_size; /* (n), unknowns of each node */
  const double *points;     /* (points, 2), m */
  const int32_t *cells;     /* (cell_count, corners), rows of points */
  const int32_t *nodes;     /* (cell_count, n), first unknown of each node */
  int32_t *begins;          /* (N + 1), where each column begins */
  int32_t
      *offsets; /* (cell_count, n, n): where in the columns of the first node the rows of the second begin */
} lamc_assembly;

/* A finite element with m cells at once. What makes no sense for it is NULL; _extended: in long double. */
typedef struct lamc_element {
  const char *name;
  const char *digest;
  int32_t corner_count; /* c */
  int32_t node_count;
  int32_t unknown_count; /* d */
  int32_t section_count; /* S, 6 or 18; 9 more with shear through the thickness */
  int32_t strain_count;  /* E, 3 or 6 */
  int32_t field_count;   /* F, of u, v, w */
  int32_t value_count;   /* V, what displacement gives: u, v, then w, w_x, w_y */

  /* corners (m, c, 2), sections (m, S) -> matrices (m, d, d) */
  void (*stiffness)(int64_t m, const double *corners, const double *sections, double *matrices);
  /* corners, areal mass (m), kg/m^2 -> matrices (m, d, d) */
  void (*mass)(int64_t m, const double *corners, const double *areal_mass, double *matrices);
  /* corners, forces (m, 3): N_x, N_y, N_xy, N/m, tension positive -> matrices (m, d, d) */
  void (*geometric)(int64_t m, const double *corners, const double *forces, double *matrices);
  /* corners, intensity (m, F, c), N/m^2, at the corners -> (m, d) */
  void (*load)(int64_t m, const double *corners, const double *intensity, double *vectors);
  /* corners, resultants (m, E) -> (m, d) */
  void (*prestress)(int64_t m, const double *corners, const double *resultants, double *vectors);
  /* corners, at (m, 2): xi and eta, unknowns (m, d) -> (m, E) */
  void (*strain)(int64_t m, const double *corners, const double *at, const double *unknowns, double *strains);
  /* corners, at (m, 2): xi and eta, unknowns (m, d) -> (m, V) */
  void (*displacement)(int64_t m, const double *corners, const double *at, const double *unknowns,
                       double *values);
  /* corners, sections (m, S), unknowns (m, d) -> (m, d) */
  void (*force)(int64_t m, const double *corners, const double *sections, const double *unknowns,
                double *vectors);
  void (*force_extended)(int64_t m, const long double *corners, const long double *sections,
                         const long double *unknowns, long double *vectors);

  /* Adds the matrices of all cells to `values`; cell i takes row[i] of a table of sections, masses or forces. */
  void (*assemble_stiffness)(const lamc_assembly *a, const double *sections, const int32_t *row,
                             double *values);
  void (*assemble_mass)(const lamc_assembly *a, const double *areal_mass, const int32_t *row, double *values);
  void (*assemble_geometric)(const lamc_assembly *a, const double *forces, const int32_t *row,
                             double *values);
  /* Adds the forces on the unknowns (N) of all cells to `forces` (N). */
  void (*assemble_force)(const lamc_assembly *a, const double *sections, const int32_t *row,
                         const double *unknowns, double *forces);
  void (*assemble_force_extended)(const lamc_assembly *a, const double *sections, const int32_t *row,
                                  const long double *unknowns, long double *forces);

  /* Of elements with shear through the thickness, in place of strain and prestress: their strains depend on the section.
   * corners, sections (m, S), at (m, 2), unknowns (m, d) -> (m, E) */
  void (*strain_in_section)(int64_t m, const double *corners, const double *sections, const double *at,
                            const double *unknowns, double *strains);
  /* corners, sections (m, S), resultants (m, E) -> (m, d) */
  void (*prestress_in_section)(int64_t m, const double *corners, const double *sections,
                               const double *resultants, double *vectors);
  /* corners, sections (m, S), at (m, 2), unknowns (m, d) -> (m, 2): gamma_x and gamma_y through the thickness */
  void (*shear_in_section)(int64_t m, const double *corners, const double *sections, const double *at,
                           const double *unknowns, double *strains);
} lamc_element;

/* How many ints of scratch lamc_assembly_begin needs. */
int64_t lamc_assembly_scratch(const lamc_assembly *a);

/* Finds which nodes meet: fills begins and offsets. Returns the number of entries of the matrix; more than INT32_MAX of
 * them are counted, but then neither begins nor offsets are to be used. */
int64_t lamc_assembly_begin(const lamc_assembly *a, int32_t *scratch);

/* Rows of all entries, ascending in each column; after lamc_assembly_begin. */
void lamc_assembly_rows(const lamc_assembly *a, int32_t *rows);

/* lamc: declarations end */

#ifdef __cplusplus
}
#endif

#endif /* LAMC_PLATE_H */
