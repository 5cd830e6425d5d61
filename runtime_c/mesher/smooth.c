/* Moves points to where their cells are rounder.
 *
 * A point goes to the mean of its neighbours, or part of the way; only if the worst of its cells becomes better by that,
 * or the mean of all does and the worst stays good. Then edges are flipped until no circle holds a point again. */
#include "cells.h"

#include <math.h>

#include "predicates.h"

#define GOOD 0.8 /* quality above which a cell may become worse */

/* 1 for an equilateral cell, 0 for a flat one: twelve over root of twelve times area over squares of edges. */
static double quality(const double *a, const double *b, const double *c) {
  const double ux = b[0] - a[0], uy = b[1] - a[1], vx = c[0] - a[0], vy = c[1] - a[1];
  const double wx = vx - ux, wy = vy - uy;
  const double squares = ux * ux + uy * uy + vx * vx + vy * vy + wx * wx + wy * wy;
  return 3.4641016151377544 * (ux * vy - uy * vx) / squares;
}

typedef struct lamc_star {
  double worst, mean, x, y; /* of qualities; mean of the neighbours */
} lamc_star;

/* Goes round the cells of `point`, as if it were at p. */
static lamc_star star_at(const lamc_mesher *m, int32_t point, const double p[2]) {
  lamc_star star = {2.0, 0.0, 0.0, 0.0};
  const int32_t start = m->cell_at[point];
  int32_t cell = start, count = 0;
  do {
    int32_t k = 0;
    while (lamc_corner(m, cell, k) != point) k++;
    const double *a = lamc_point(m, lamc_corner(m, cell, lamc_next(k)));
    const double *b = lamc_point(m, lamc_corner(m, cell, lamc_last(k)));
    const double value = quality(p, a, b);
    star.worst = value < star.worst ? value : star.worst;
    star.mean += value;
    star.x += a[0];
    star.y += a[1];
    count++;
    cell = m->neighbours[3 * cell + lamc_next(k)];
  } while (cell != start);
  star.mean /= count;
  star.x /= count;
  star.y /= count;
  return star;
}

static void move(lamc_mesher *m, int32_t point) {
  double *at = m->points + 2 * point;
  const lamc_star before = star_at(m, point, at);
  for (double part = 1.0; part > 0.2; part *= 0.5) {
    const double p[2] = {at[0] + part * (before.x - at[0]), at[1] + part * (before.y - at[1])};
    const lamc_star after = star_at(m, point, p);
    if (after.worst > before.worst || (after.worst > GOOD && after.mean > before.mean)) {
      at[0] = p[0];
      at[1] = p[1];
      return;
    }
  }
}

int lamc_mesher_smooth(lamc_mesher *m, int32_t passes) {
  for (int32_t pass = 0; pass < passes; pass++) {
    for (int32_t point = 4; point < m->point_count; point++) {
      if (m->segment_of[point] == -2 && m->regions[m->cell_at[point]] >= 0) move(m, point);
    }
    lamc_restore(m);
  }
  return LAMC_MESHER_DONE;
}
