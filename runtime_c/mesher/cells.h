/* What triangulation, refinement and smoothing share: cells, their neighbours, and how a point comes in. */
#ifndef LAMC_MESHER_CELLS_H
#define LAMC_MESHER_CELLS_H

#include <stdbool.h>

#include "mesher.h"

enum { QUEUED = 8 };

/* An edge, seen from one of its cells: opposite corner `side`. */
typedef struct lamc_side {
  int32_t cell, side;
} lamc_side;

/* The hole that a new point makes: `count` edges counter-clockwise around it, in the mesher's stack. */
typedef struct lamc_hole {
  int32_t cell_count, edge_count;
  int32_t *cells; /* cells that go */
  int32_t *edges; /* EDGE_FIELDS per edge */
} lamc_hole;

enum { EDGE_A, EDGE_B, EDGE_BEYOND, EDGE_BEYOND_SIDE, EDGE_FIXED, EDGE_REGION, EDGE_FIELDS };

static inline lamc_side lamc_side_of(int32_t cell, int32_t side) {
  const lamc_side s = {cell, side};
  return s;
}

static inline int32_t lamc_next(int32_t k) {
  return k == 2 ? 0 : k + 1;
}
static inline int32_t lamc_last(int32_t k) {
  return k == 0 ? 2 : k - 1;
}
static inline const double *lamc_point(const lamc_mesher *m, int32_t point) {
  return m->points + 2 * point;
}
static inline int32_t lamc_corner(const lamc_mesher *m, int32_t cell, int32_t k) {
  return m->corners[3 * cell + k];
}
static inline bool lamc_is_fixed(const lamc_mesher *m, lamc_side s) {
  return (m->flags[s.cell] >> s.side & 1) != 0;
}

/* The same edge from the other cell; its cell is -1 where there is none. */
lamc_side lamc_across(const lamc_mesher *m, lamc_side s);

/* Walks from `cell` towards p. Gives the cell that holds p, and side -1; or, where `stop` and a segment is in the way,
 * the edge that it came to; or cell -1 where there is no way. */
lamc_side lamc_walk(const lamc_mesher *m, int32_t cell, const double p[2], bool stop);

/* Finds what a point p in `cell` would replace: the cells whose circle it is in, up to segments. `through` is a
 * segment's edge that p splits, or has cell -1. LAMC_MESHER_LOST where p does not see all edges of the hole. */
int lamc_find_hole(lamc_mesher *m, int32_t cell, const double p[2], lamc_side through, lamc_hole *hole);

/* Puts point `point` into its hole. `a` and `b` are the ends of the segment that it splits, or -1. The new cells are
 * hole->cells[0 .. edge_count - 1], with the point as corner 0. Returns a status. */
int lamc_fill_hole(lamc_mesher *m, int32_t point, lamc_hole *hole, int32_t a, int32_t b);

/* Replaces the edge by the other diagonal of its two cells. */
void lamc_flip(lamc_mesher *m, lamc_side s);

/* Flips edges of all cells until the circle of no cell holds a point that it sees. */
void lamc_restore(lamc_mesher *m);

#endif
