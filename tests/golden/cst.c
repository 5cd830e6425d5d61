/* cst: a finite element in C, for many cells at once.
 *
 * Made by lamc VERSION from template element.c.j2. Do not edit: change the element and build again.
 * Element digest 61ed2f9e5bb1b392e6e46439026e6cbf730a8f152da46fe378309d9ec856d7b9
 *
 * Operations per cell (+ - *, reciprocals, library calls):
 *   stiffness          84 of which 1 reciprocals; 0 library calls
 *   mass               10 of which 0 reciprocals; 0 library calls
 *   load               37 of which 0 reciprocals; 0 library calls
 *   prestress          22 of which 0 reciprocals; 0 library calls
 *   strain             28 of which 1 reciprocals; 0 library calls
 *   displacement       12 of which 0 reciprocals; 0 library calls
 *   force              60 of which 1 reciprocals; 0 library calls
 */
#include "cst.h"

#include <stddef.h>

/* A value is one number for each of LANES cells; lane k of value i is at [LANES * i + k]. */
#if defined(__GNUC__)
enum { LANES = 2 };
typedef double lanes __attribute__((vector_size(16), may_alias));
#define EACH(x) ((x) + (lanes){0})
#else
enum { LANES = 1 };
typedef double lanes;
#define EACH(x) (x)
#endif
#define ALIGNED _Alignas(lanes) double
#define RATIO(p, q) ((scalar)(p) / (q))

#define scalar double
#define real lanes
#define OF(name) cst_##name##_lanes
#include "cst_equations.h"
#undef scalar
#undef real
#undef EACH
#undef OF

#define scalar long double
#define real long double
#define EACH(x) (x)
#define OF(name) cst_##name##_long
#include "cst_equations.h"
#undef scalar
#undef real
#undef EACH
#undef OF

/* How many of LANES cells there are when `left` remain. */
static inline int used_of(int64_t left) { return left < LANES ? (int)left : LANES; }

/* Values of one input, `size` per cell. Lanes beyond `used` repeat the last cell. */
static inline void gather(const double *rows, int size, int used, double *values) {
  for (int lane = 0; lane < LANES; ++lane) {
    const double *row = rows + (lane < used ? lane : used - 1) * size;
    for (int i = 0; i < size; ++i) values[LANES * i + lane] = row[i];
  }
}

/* The same from a table, row[i] for cell i. */
static inline void gather_rows(const double *table, int size, const int32_t *row, int used, double *values) {
  for (int lane = 0; lane < LANES; ++lane) {
    const double *found = table + (int64_t)size * row[lane < used ? lane : used - 1];
    for (int i = 0; i < size; ++i) values[LANES * i + lane] = found[i];
  }
}

/* Corners of cells from the points of the mesh. */
static inline void gather_corners(const lamc_assembly *a, int64_t first, int used, double *xy) {
  for (int lane = 0; lane < LANES; ++lane) {
    const int32_t *corner = a->cells + 3 * (first + (lane < used ? lane : used - 1));
    for (int i = 0; i < 3; ++i) {
      const double *point = a->points + 2 * (int64_t)corner[i];
      xy[LANES * 2 * i + lane] = point[0];
      xy[LANES * (2 * i + 1) + lane] = point[1];
    }
  }
}

/* One lane's lower triangle as a full matrix. */
static inline void unfold(const double *triangle, double *matrix) {
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j, triangle += LANES) {
      matrix[6 * i + j] = *triangle;
      matrix[6 * j + i] = *triangle;
    }
  }
}

/* One lane's lower triangle added to the columns of a sparse matrix, node by node. */
static inline void add(const lamc_assembly *a, int64_t cell, const double *triangle, double *values) {
  const int32_t *node = a->nodes + 3 * cell, *to = a->offsets + 9 * cell;
  double *column;
  int32_t begin, length;
  begin = a->begins[node[0]];
  length = a->begins[node[0] + 1] - begin;
  column = values + begin;
  column[to[0] + 0] += triangle[LANES * 0];
  column[to[0] + 1] += triangle[LANES * 1];
  column[to[1] + 0] += triangle[LANES * 3];
  column[to[1] + 1] += triangle[LANES * 6];
  column[to[2] + 0] += triangle[LANES * 10];
  column[to[2] + 1] += triangle[LANES * 15];
  column = values + begin + 1 * length;
  column[to[0] + 0] += triangle[LANES * 1];
  column[to[0] + 1] += triangle[LANES * 2];
  column[to[1] + 0] += triangle[LANES * 4];
  column[to[1] + 1] += triangle[LANES * 7];
  column[to[2] + 0] += triangle[LANES * 11];
  column[to[2] + 1] += triangle[LANES * 16];
  begin = a->begins[node[1]];
  length = a->begins[node[1] + 1] - begin;
  column = values + begin;
  column[to[3] + 0] += triangle[LANES * 3];
  column[to[3] + 1] += triangle[LANES * 4];
  column[to[4] + 0] += triangle[LANES * 5];
  column[to[4] + 1] += triangle[LANES * 8];
  column[to[5] + 0] += triangle[LANES * 12];
  column[to[5] + 1] += triangle[LANES * 17];
  column = values + begin + 1 * length;
  column[to[3] + 0] += triangle[LANES * 6];
  column[to[3] + 1] += triangle[LANES * 7];
  column[to[4] + 0] += triangle[LANES * 8];
  column[to[4] + 1] += triangle[LANES * 9];
  column[to[5] + 0] += triangle[LANES * 13];
  column[to[5] + 1] += triangle[LANES * 18];
  begin = a->begins[node[2]];
  length = a->begins[node[2] + 1] - begin;
  column = values + begin;
  column[to[6] + 0] += triangle[LANES * 10];
  column[to[6] + 1] += triangle[LANES * 11];
  column[to[7] + 0] += triangle[LANES * 12];
  column[to[7] + 1] += triangle[LANES * 13];
  column[to[8] + 0] += triangle[LANES * 14];
  column[to[8] + 1] += triangle[LANES * 19];
  column = values + begin + 1 * length;
  column[to[6] + 0] += triangle[LANES * 15];
  column[to[6] + 1] += triangle[LANES * 16];
  column[to[7] + 0] += triangle[LANES * 17];
  column[to[7] + 1] += triangle[LANES * 18];
  column[to[8] + 0] += triangle[LANES * 19];
  column[to[8] + 1] += triangle[LANES * 20];
}

void cst_stiffness(int64_t m, const double *corners, const double *sections, double *out) {
  for (int64_t first = 0; first < m; first += LANES) {
    const int used = used_of(m - first);
    ALIGNED xy[6 * LANES], s[6 * LANES], values[21 * LANES];
    gather(corners + 6 * first, 6, used, xy);
    gather(sections + 6 * first, 6, used, s);
    cst_stiffness_lanes((const lanes *)xy, (const lanes *)s, (lanes *)values);
    for (int lane = 0; lane < used; ++lane) {
      unfold(values + lane, out + 36 * (first + lane));
    }
  }
}

void cst_mass(int64_t m, const double *corners, const double *areal_mass, double *out) {
  for (int64_t first = 0; first < m; first += LANES) {
    const int used = used_of(m - first);
    ALIGNED xy[6 * LANES], rho[1 * LANES], values[21 * LANES];
    gather(corners + 6 * first, 6, used, xy);
    gather(areal_mass + 1 * first, 1, used, rho);
    cst_mass_lanes((const lanes *)xy, (const lanes *)rho, (lanes *)values);
    for (int lane = 0; lane < used; ++lane) {
      unfold(values + lane, out + 36 * (first + lane));
    }
  }
}

void cst_load(int64_t m, const double *corners, const double *intensity, double *out) {
  for (int64_t first = 0; first < m; first += LANES) {
    const int used = used_of(m - first);
    ALIGNED xy[6 * LANES], f[6 * LANES], values[6 * LANES];
    gather(corners + 6 * first, 6, used, xy);
    gather(intensity + 6 * first, 6, used, f);
    cst_load_lanes((const lanes *)xy, (const lanes *)f, (lanes *)values);
    for (int lane = 0; lane < used; ++lane) {
      for (int i = 0; i < 6; ++i) out[6 * (first + lane) + i] = values[LANES * i + lane];
    }
  }
}

void cst_prestress(int64_t m, const double *corners, const double *resultants, double *out) {
  for (int64_t first = 0; first < m; first += LANES) {
    const int used = used_of(m - first);
    ALIGNED xy[6 * LANES], r[3 * LANES], values[6 * LANES];
    gather(corners + 6 * first, 6, used, xy);
    gather(resultants + 3 * first, 3, used, r);
    cst_prestress_lanes((const lanes *)xy, (const lanes *)r, (lanes *)values);
    for (int lane = 0; lane < used; ++lane) {
      for (int i = 0; i < 6; ++i) out[6 * (first + lane) + i] = values[LANES * i + lane];
    }
  }
}

void cst_strain(int64_t m, const double *corners, const double *at, const double *unknowns, double *out) {
  for (int64_t first = 0; first < m; first += LANES) {
    const int used = used_of(m - first);
    ALIGNED xy[6 * LANES], xi[2 * LANES], d[6 * LANES], values[3 * LANES];
    gather(corners + 6 * first, 6, used, xy);
    gather(at + 2 * first, 2, used, xi);
    gather(unknowns + 6 * first, 6, used, d);
    cst_strain_lanes((const lanes *)xy, (const lanes *)xi, (const lanes *)d, (lanes *)values);
    for (int lane = 0; lane < used; ++lane) {
      for (int i = 0; i < 3; ++i) out[3 * (first + lane) + i] = values[LANES * i + lane];
    }
  }
}

void cst_displacement(int64_t m, const double *corners, const double *at, const double *unknowns, double *out) {
  for (int64_t first = 0; first < m; first += LANES) {
    const int used = used_of(m - first);
    ALIGNED xy[6 * LANES], xi[2 * LANES], d[6 * LANES], values[2 * LANES];
    gather(corners + 6 * first, 6, used, xy);
    gather(at + 2 * first, 2, used, xi);
    gather(unknowns + 6 * first, 6, used, d);
    cst_displacement_lanes((const lanes *)xy, (const lanes *)xi, (const lanes *)d, (lanes *)values);
    for (int lane = 0; lane < used; ++lane) {
      for (int i = 0; i < 2; ++i) out[2 * (first + lane) + i] = values[LANES * i + lane];
    }
  }
}

void cst_force(int64_t m, const double *corners, const double *sections, const double *unknowns, double *out) {
  for (int64_t first = 0; first < m; first += LANES) {
    const int used = used_of(m - first);
    ALIGNED xy[6 * LANES], s[6 * LANES], d[6 * LANES], values[6 * LANES];
    gather(corners + 6 * first, 6, used, xy);
    gather(sections + 6 * first, 6, used, s);
    gather(unknowns + 6 * first, 6, used, d);
    cst_force_lanes((const lanes *)xy, (const lanes *)s, (const lanes *)d, (lanes *)values);
    for (int lane = 0; lane < used; ++lane) {
      for (int i = 0; i < 6; ++i) out[6 * (first + lane) + i] = values[LANES * i + lane];
    }
  }
}

void cst_force_extended(int64_t m, const long double *corners, const long double *sections, const long double *unknowns, long double *out) {
  for (int64_t i = 0; i < m; ++i) {
    cst_force_long(corners + 6 * i, sections + 6 * i, unknowns + 6 * i, out + 6 * i);
  }
}

void cst_assemble_stiffness(const lamc_assembly *a, const double *sections, const int32_t *row, double *values) {
  for (int64_t first = 0; first < a->cell_count; first += LANES) {
    const int used = used_of(a->cell_count - first);
    ALIGNED xy[6 * LANES], s[6 * LANES], triangle[21 * LANES];
    gather_corners(a, first, used, xy);
    gather_rows(sections, 6, row + first, used, s);
    cst_stiffness_lanes((const lanes *)xy, (const lanes *)s, (lanes *)triangle);
    for (int lane = 0; lane < used; ++lane) add(a, first + lane, triangle + lane, values);
  }
}

void cst_assemble_mass(const lamc_assembly *a, const double *areal_mass, const int32_t *row, double *values) {
  for (int64_t first = 0; first < a->cell_count; first += LANES) {
    const int used = used_of(a->cell_count - first);
    ALIGNED xy[6 * LANES], rho[1 * LANES], triangle[21 * LANES];
    gather_corners(a, first, used, xy);
    gather_rows(areal_mass, 1, row + first, used, rho);
    cst_mass_lanes((const lanes *)xy, (const lanes *)rho, (lanes *)triangle);
    for (int lane = 0; lane < used; ++lane) add(a, first + lane, triangle + lane, values);
  }
}

/* For each unknown of the element, its number in the mesh: node by node. */
static inline void number_unknowns(const lamc_assembly *a, int64_t cell, int32_t *number) {
  static const int node[] = {0, 0, 1, 1, 2, 2}, place[] = {0, 1, 0, 1, 0, 1};
  for (int i = 0; i < 6; ++i) number[i] = a->nodes[3 * cell + node[i]] + place[i];
}

void cst_assemble_force(const lamc_assembly *a, const double *sections, const int32_t *row, const double *unknowns, double *forces) {
  for (int64_t first = 0; first < a->cell_count; first += LANES) {
    const int used = used_of(a->cell_count - first);
    ALIGNED xy[6 * LANES], s[6 * LANES], d[6 * LANES], force[6 * LANES];
    int32_t number[LANES][6];
    gather_corners(a, first, used, xy);
    gather_rows(sections, 6, row + first, used, s);
    for (int lane = 0; lane < LANES; ++lane) {
      number_unknowns(a, first + (lane < used ? lane : used - 1), number[lane]);
      for (int i = 0; i < 6; ++i) d[LANES * i + lane] = unknowns[number[lane][i]];
    }
    cst_force_lanes((const lanes *)xy, (const lanes *)s, (const lanes *)d, (lanes *)force);
    for (int lane = 0; lane < used; ++lane) {
      for (int i = 0; i < 6; ++i) forces[number[lane][i]] += force[LANES * i + lane];
    }
  }
}

void cst_assemble_force_extended(const lamc_assembly *a, const double *sections, const int32_t *row, const long double *unknowns, long double *forces) {
  for (int64_t cell = 0; cell < a->cell_count; ++cell) {
    const double *section = sections + 6 * (int64_t)row[cell];
    long double xy[6], s[6], d[6], force[6];
    int32_t number[6];
    for (int i = 0; i < 6; ++i) {
      xy[i] = (long double)a->points[2 * (int64_t)a->cells[3 * cell + i / 2] + i % 2];
    }
    for (int i = 0; i < 6; ++i) s[i] = (long double)section[i];
    number_unknowns(a, cell, number);
    for (int i = 0; i < 6; ++i) d[i] = unknowns[number[i]];
    cst_force_long(xy, s, d, force);
    for (int i = 0; i < 6; ++i) forces[number[i]] += force[i];
  }
}

const lamc_element *cst_element(void) {
  static const lamc_element element = {
      "cst",
      "61ed2f9e5bb1b392e6e46439026e6cbf730a8f152da46fe378309d9ec856d7b9",
      3,
      3,
      6,
      6,
      3,
      2,
      2,
      cst_stiffness,
      cst_mass,
      NULL,
      cst_load,
      cst_prestress,
      cst_strain,
      cst_displacement,
      cst_force,
      cst_force_extended,
      cst_assemble_stiffness,
      cst_assemble_mass,
      NULL,
      cst_assemble_force,
      cst_assemble_force_extended,
      NULL,
      NULL,
      NULL,
  };
  return &element;
}
