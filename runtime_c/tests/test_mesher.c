/* test_mesher.c: the triangulation and its refinement, on points of all kinds, in little memory. */
#include "../mesher/mesher.h"

#include <math.h>
#include <stdlib.h>

#include "../mesher/predicates.h"
#include "check.h"

enum { CELLS = 60000, POINTS = CELLS / 2, STACK = 9 * 4096 };

typedef struct fixture {
  lamc_mesher m;
  double points[2 * POINTS], sizes[POINTS];
  int32_t segment_of[POINTS], cell_at[POINTS];
  int32_t corners[3 * CELLS], neighbours[3 * CELLS], regions[CELLS], marks[CELLS], queue[CELLS], stack[STACK];
  uint8_t flags[CELLS];
} fixture;

static fixture f; /* too large for the stack */

static void add(double x, double y, double size) {
  const int32_t point = f.m.point_count++;
  f.points[2 * point] = x;
  f.points[2 * point + 1] = y;
  f.sizes[point] = size;
  f.segment_of[point] = -1;
}

static void start(int32_t capacity) {
  const lamc_mesher fresh = {capacity / 2,
                             capacity,
                             STACK,
                             0,
                             0,
                             f.points,
                             f.sizes,
                             f.segment_of,
                             f.cell_at,
                             f.corners,
                             f.neighbours,
                             f.regions,
                             f.flags,
                             f.marks,
                             f.queue,
                             f.stack,
                             0,
                             0};
  f.m = fresh;
  add(-8.0, -8.0, 16.0);
  add(8.0, -8.0, 16.0);
  add(8.0, 8.0, 16.0);
  add(-8.0, 8.0, 16.0);
}

/* The same on every machine: a linear congruence (Numerical Recipes). */
static double random_unit(void) {
  static uint32_t state = 1;
  state = 1664525u * state + 1013904223u;
  return (state >> 8) / 16777216.0;
}

static const double *corner(int32_t cell, int32_t k) {
  return f.points + 2 * f.corners[3 * cell + k];
}

/* Whether cells are counter-clockwise, neighbours agree, and no circle holds the far corner of a neighbour that is not
 * beyond a segment; that makes the triangulation a constrained Delaunay one. */
static int is_delaunay(void) {
  for (int32_t cell = 0; cell < f.m.cell_count; cell++) {
    if (!(lamc_orientation(corner(cell, 0), corner(cell, 1), corner(cell, 2)) > 0.0)) return 0;
    for (int32_t k = 0; k < 3; k++) {
      const int32_t beyond = f.neighbours[3 * cell + k];
      if (beyond < 0) continue;
      int32_t back = 0;
      while (back < 3 && f.neighbours[3 * beyond + back] != cell) back++;
      if (back == 3) return 0;
      if (f.corners[3 * cell + (k + 1) % 3] != f.corners[3 * beyond + (back + 2) % 3]) return 0;
      if ((f.flags[cell] >> k & 1) != (f.flags[beyond] >> back & 1)) return 0;
      if (f.flags[cell] >> k & 1) continue;
      if (lamc_in_circle(corner(cell, 0), corner(cell, 1), corner(cell, 2), corner(beyond, back)) > 0.0)
        return 0;
    }
  }
  return 1;
}

static double area_of(int32_t region) {
  double area = 0.0;
  for (int32_t cell = 0; cell < f.m.cell_count; cell++) {
    const double *a = corner(cell, 0), *b = corner(cell, 1), *c = corner(cell, 2);
    if (f.regions[cell] != region) continue;
    area += 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
  }
  return area;
}

static double least_angle(int32_t region) {
  double least = 180.0;
  for (int32_t cell = 0; cell < f.m.cell_count; cell++) {
    for (int32_t k = 0; k < 3 && f.regions[cell] == region; k++) {
      const double *a = corner(cell, k), *b = corner(cell, (k + 1) % 3), *c = corner(cell, (k + 2) % 3);
      const double ux = b[0] - a[0], uy = b[1] - a[1], vx = c[0] - a[0], vy = c[1] - a[1];
      const double angle = atan2(ux * vy - uy * vx, ux * vx + uy * vy) * 57.29577951308232;
      least = angle < least ? angle : least;
    }
  }
  return least;
}

static void signs_are_exact(check_counts *counts) {
  /* Kettner et al., Classroom examples of robustness problems, 2008: near a line, a rounded determinant has any sign. */
  const double q[2] = {12.0, 12.0}, r[2] = {24.0, 24.0};
  for (int i = 0; i < 64; i++) {
    for (int j = 0; j < 64; j++) {
      const double p[2] = {0.5 + i * 0x1p-53, 0.5 + j * 0x1p-53};
      const double sign = lamc_orientation(p, q, r);
      CHECK(counts, i < j ? sign > 0.0 : i > j ? sign < 0.0 : sign == 0.0);
    }
  }
  /* A unit in the last place in or out of the circle through (±1, 0) and (0, -1); four on it have sign zero. */
  const double a[2] = {-1.0, 0.0}, b[2] = {0.0, -1.0}, c[2] = {1.0, 0.0};
  const double in[2] = {0.0, 1.0 - 0x1p-53}, on[2] = {0.0, 1.0}, out[2] = {0.0, 1.0 + 0x1p-52};
  CHECK(counts, lamc_in_circle(a, b, c, in) > 0.0);
  CHECK(counts, lamc_in_circle(a, b, c, on) == 0.0);
  CHECK(counts, lamc_in_circle(a, b, c, out) < 0.0);
}

static void any_points_are_triangulated(check_counts *counts) {
  for (int kind = 0; kind < 3; kind++) {
    start(CELLS);
    for (int i = 0; i < 400; i++) {
      const double x =
          kind == 0 ? random_unit() : (i % 20) / 32.0; /* a lattice: four to a circle, many in line */
      const double y = kind == 0 ? random_unit() : kind == 1 ? (i / 20) / 32.0 : (i / 20) * 0x1p-40;
      add(x, y, 1.0);
    }
    CHECK(counts, lamc_mesher_triangulate(&f.m, NULL, 0) == LAMC_MESHER_DONE);
    CHECK(counts, is_delaunay());
    CHECK(counts, f.m.cell_count == 2 * 404 - 2 - 4); /* Euler, with four points on the border */
    CHECK(counts, fabs(area_of(0) - 256.0) < 1e-10);
  }
}

static void doubles_and_crossings_are_told(check_counts *counts) {
  const int32_t crossing[4] = {4, 6, 5, 7};
  start(CELLS);
  add(0.0, 0.0, 1.0);
  add(1.0, 0.0, 1.0);
  add(1.0, 1.0, 1.0);
  add(0.0, 1.0, 1.0);
  CHECK(counts, lamc_mesher_triangulate(&f.m, crossing, 2) == LAMC_MESHER_CROSSING);
  CHECK(counts, f.m.failed == 1);
  add(1.0, 0.0, 1.0);
  CHECK(counts, lamc_mesher_triangulate(&f.m, NULL, 0) == LAMC_MESHER_DOUBLE);
  CHECK(counts, f.m.failed == 8);
  f.points[16] = 9.0;
  CHECK(counts, lamc_mesher_triangulate(&f.m, NULL, 0) == LAMC_MESHER_LOST);
}

static void long_segments_through_many_points_become_edges(check_counts *counts) {
  const int32_t segment[2] = {4, 5};
  start(CELLS);
  add(0.0, 0.5, 1.0);
  add(1.0, 0.5, 1.0);
  for (int i = 0; i < 2000; i++) add(0.01 + 0.98 * random_unit(), random_unit(), 1.0);
  for (int i = 1; i < 8; i++) add(i / 8.0, 0.5, 1.0); /* on it */
  CHECK(counts, lamc_mesher_triangulate(&f.m, segment, 1) == LAMC_MESHER_DONE);
  CHECK(counts, is_delaunay());
  int fixed = 0;
  for (int32_t cell = 0; cell < f.m.cell_count; cell++) {
    for (int32_t k = 0; k < 3; k++) fixed += f.flags[cell] >> k & 1;
  }
  CHECK(counts, fixed == 2 * 8); /* eight parts, seen from two sides */
}

static const int32_t square[8] = {4, 5, 5, 6, 6, 7, 7, 4};

/* A unit square, all but its inside marked as outside. Returns the status of refinement. */
static int refined_square(int32_t capacity, double size) {
  const double sizes[1] = {size}, floors[1] = {1e-3 * size};
  const lamc_mesher_rules rules = {1, sizes, floors, square, 0.3, 0.5};
  start(capacity);
  add(0.0, 0.0, size);
  add(1.0, 0.0, size);
  add(1.0, 1.0, size);
  add(0.0, 1.0, size);
  const int status = lamc_mesher_triangulate(&f.m, square, 4);
  if (status != LAMC_MESHER_DONE) return status;
  for (int32_t cell = 0; cell < f.m.cell_count; cell++) {
    const double x = (corner(cell, 0)[0] + corner(cell, 1)[0] + corner(cell, 2)[0]) / 3.0;
    const double y = (corner(cell, 0)[1] + corner(cell, 1)[1] + corner(cell, 2)[1]) / 3.0;
    f.regions[cell] = x > 0.0 && x < 1.0 && y > 0.0 && y < 1.0 ? 0 : -1;
  }
  return lamc_mesher_refine(&f.m, &rules);
}

static void a_square_is_refined_and_smoothed(check_counts *counts) {
  CHECK(counts, refined_square(CELLS, 0.02) == LAMC_MESHER_DONE);
  CHECK(counts, is_delaunay());
  CHECK(counts, fabs(area_of(0) - 1.0) < 1e-12);
  CHECK(counts, least_angle(0) > 0.5 * 57.29); /* what was asked for */
  CHECK(counts, lamc_mesher_smooth(&f.m, 3) == LAMC_MESHER_DONE);
  CHECK(counts, is_delaunay());
  CHECK(counts, fabs(area_of(0) - 1.0) < 1e-12);
  CHECK(counts, least_angle(0) > 25.0);
}

static void too_little_room_is_told(check_counts *counts) {
  for (int32_t capacity = 0; capacity < 4000; capacity += 37) {
    CHECK(counts, refined_square(capacity, 0.02) == LAMC_MESHER_FULL);
  }
}

int main(void) {
  static const check_case cases[] = {
      CASE(signs_are_exact),
      CASE(any_points_are_triangulated),
      CASE(doubles_and_crossings_are_told),
      CASE(long_segments_through_many_points_become_edges),
      CASE(a_square_is_refined_and_smoothed),
      CASE(too_little_room_is_told),
  };
  return check_run(cases, (int)(sizeof cases / sizeof *cases));
}
