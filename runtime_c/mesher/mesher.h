/* Triangulation of plane polygons by constrained Delaunay refinement.
 *
 * Call lamc_mesher_triangulate, then say which of the pieces that it numbered belong to which region, then
 * lamc_mesher_refine and lamc_mesher_smooth. All memory is the caller's; nothing else is kept. The same input gives the
 * same mesh, on every machine with IEEE arithmetic. */
#ifndef LAMC_MESHER_H
#define LAMC_MESHER_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* lamc: declarations begin */
enum {
  LAMC_MESHER_DONE = 0,
  LAMC_MESHER_FULL = 1,     /* a capacity is too small: start again with more */
  LAMC_MESHER_CROSSING = 2, /* two segments cross each other */
  LAMC_MESHER_DOUBLE = 3,   /* two points at one place */
  LAMC_MESHER_LOST = 4      /* a point lies outside the first four */
};

/* Points 0 to 3 are the corners of a box, counter-clockwise, far around all others; what they bound is no plate. */
typedef struct lamc_mesher {
  int32_t point_capacity, cell_capacity, stack_capacity;
  int32_t point_count, cell_count;
  double *points;      /* x, y per point */
  double *sizes;       /* per point: wanted length of edges there */
  int32_t *segment_of; /* per point: the given segment that it lies on; -1: a given corner; -2: none */
  int32_t *cell_at;    /* per point: one of its cells */
  int32_t *corners;    /* three per cell, counter-clockwise */
  int32_t *neighbours; /* three per cell: beyond the edge opposite the corner; -1: none */
  int32_t *regions;    /* per cell; after triangulation: number of its piece; negative: not to be refined */
  uint8_t *flags; /* per cell: bit k: the edge opposite corner k is part of a segment; bit 3: in the queue */
  int32_t *marks; /* per cell: last search that came here */
  int32_t *queue; /* cell_capacity */
  int32_t *stack; /* stack_capacity; nine per cell that one point may replace */
  int32_t mark;
  int32_t failed; /* the point or segment that an error is about */
} lamc_mesher;

/* How lamc_mesher_refine chooses. */
typedef struct lamc_mesher_rules {
  int32_t region_count;
  const double *region_sizes;  /* wanted length of edges */
  const double *region_floors; /* no edge is made shorter than this for the sake of angles */
  const int32_t *segment_ends; /* two corners per given segment */
  double grading;              /* how fast sizes may grow, per length */
  double least_angle;          /* rad; angles between given segments may be smaller */
} lamc_mesher_rules;

/* Constrained Delaunay triangulation of the points and of `segments`, two points each; every piece between segments
 * gets a number, from 0. Returns a status. */
int lamc_mesher_triangulate(lamc_mesher *m, const int32_t *segments, int32_t segment_count);

/* Adds points until cells are as small as wanted and their angles large enough. Returns a status. */
int lamc_mesher_refine(lamc_mesher *m, const lamc_mesher_rules *rules);

/* Moves points that are on no segment to where their cells are rounder, `passes` times. Returns a status. */
int lamc_mesher_smooth(lamc_mesher *m, int32_t passes);
/* lamc: declarations end */

#ifdef __cplusplus
}
#endif

#endif
