/* Adds points until cells are as small as wanted and their angles are large enough.
 *
 * A bad cell gets a point: on the bisector of its shortest edge where a cell of the wanted shape and size ends, or at
 * the centre of its circle where that is nearer (A. Üngör, Off-centers, Computational Geometry 42 (2009) 109-118; in
 * the order of a queue this is Rebay's advancing front, Journal of Computational Physics 106 (1993) 125-138). A point
 * that would be too near to a segment splits the segment instead (J. Ruppert, A Delaunay refinement algorithm, Journal
 * of Algorithms 18 (1995) 548-585; lenses: J. R. Shewchuk, Computational Geometry 22 (2002) 21-74). */
#include "cells.h"

#include <math.h>

#include "predicates.h"

#define TOO_LARGE 1.15 /* circle of a cell over that of the equilateral one wanted */
#define TOO_NEAR                                                                                             \
  0.7             /* distance to the next point over wanted length, below which an off-centre is not taken */
#define SAME 1e-3 /* relative difference of lengths on two sides of an acute corner that count as equal */
#define SHARP 0.5 /* chord over distance from the corner: 29° */
#define NEAR_FLAT 1.0e-10 /* area over square of the longest edge, below which a cell has no circle */

typedef struct lamc_work {
  lamc_mesher *m;
  const lamc_mesher_rules *rules;
  double ratio; /* circle's radius over shortest edge: more is too thin */
  double lens;  /* cos² of the angle at which a segment is seen from the rim of its lens */
  double slope; /* height of the off-centre over half the shortest edge */
  int32_t head, waiting;
} lamc_work;

typedef struct lamc_shape {
  double shortest, longest, radius; /* radius: of the circle */
  int32_t apex;                     /* corner opposite the shortest edge */
  double wanted;                    /* length of edges */
  bool thin, large;
} lamc_shape;

static double distance(const double *a, const double *b) {
  const double x = a[0] - b[0], y = a[1] - b[1];
  return sqrt(x * x + y * y); /* not hypot, whose last digit depends on the library */
}

static double smaller(double a, double b) {
  return a < b ? a : b;
}

static void enqueue(lamc_work *w, int32_t cell) {
  lamc_mesher *m = w->m;
  if ((m->flags[cell] & QUEUED) || m->regions[cell] < 0) return;
  m->flags[cell] |= QUEUED;
  int32_t tail = w->head + w->waiting++;
  if (tail >= m->cell_capacity) tail -= m->cell_capacity;
  m->queue[tail] = cell;
}

static int32_t dequeue(lamc_work *w) {
  const int32_t cell = w->m->queue[w->head];
  w->head = w->head + 1 == w->m->cell_capacity ? 0 : w->head + 1;
  w->waiting--;
  w->m->flags[cell] = (uint8_t)(w->m->flags[cell] & ~QUEUED);
  return cell;
}

static lamc_shape shape_of(const lamc_work *w, int32_t cell) {
  const lamc_mesher *m = w->m;
  const int32_t *v = m->corners + 3 * cell;
  const double *p[3] = {lamc_point(m, v[0]), lamc_point(m, v[1]), lamc_point(m, v[2])};
  lamc_shape s = {0.0, 0.0, 0.0, 0, 0.0, false, false};
  double product = 1.0;
  for (int32_t k = 0; k < 3; k++) {
    const double length = distance(p[lamc_next(k)], p[lamc_last(k)]);
    product *= length;
    if (k == 0 || length < s.shortest) {
      s.shortest = length;
      s.apex = k;
    }
    if (k == 0 || length > s.longest) s.longest = length;
  }
  const double area = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
  s.radius = area > NEAR_FLAT * s.longest * s.longest ? product / (2.0 * area) : HUGE_VAL;
  const double mean = (m->sizes[v[0]] + m->sizes[v[1]] + m->sizes[v[2]]) / 3.0;
  s.wanted = smaller(mean, w->rules->region_sizes[m->regions[cell]]);
  s.thin = s.radius > w->ratio * s.shortest;
  s.large = s.radius > TOO_LARGE * s.wanted / sqrt(3.0);
  return s;
}

/* The given corner that two given segments share, or -1. */
static int32_t common_corner(const lamc_mesher_rules *rules, int32_t one, int32_t two) {
  if (one < 0 || two < 0 || one == two) return -1;
  for (int32_t i = 0; i < 2; i++) {
    for (int32_t j = 0; j < 2; j++) {
      const int32_t corner = rules->segment_ends[2 * one + i];
      if (corner == rules->segment_ends[2 * two + j]) return corner;
    }
  }
  return -1;
}

/* Whether the shortest edge of a cell spans a sharp given corner at equal distances from it: splits of one side would
 * call for splits of the other, and no point can make the angle there larger. */
static bool spans_corner(const lamc_work *w, int32_t cell, const lamc_shape *s) {
  const lamc_mesher *m = w->m;
  const int32_t a = lamc_corner(m, cell, lamc_next(s->apex)), b = lamc_corner(m, cell, lamc_last(s->apex));
  const int32_t corner = common_corner(w->rules, m->segment_of[a], m->segment_of[b]);
  if (corner < 0) return false;
  const double to_a = distance(lamc_point(m, corner), lamc_point(m, a));
  const double to_b = distance(lamc_point(m, corner), lamc_point(m, b));
  return s->shortest < SHARP * to_a && fabs(to_a - to_b) <= SAME * (to_a + to_b);
}

/* Where to put a point for a bad cell: at the centre of its circle, or nearer to its shortest edge. */
static void place_point(const lamc_work *w, int32_t cell, const lamc_shape *s, bool centre, double p[2]) {
  const lamc_mesher *m = w->m;
  const double *a = lamc_point(m, lamc_corner(m, cell, lamc_next(s->apex)));
  const double *b = lamc_point(m, lamc_corner(m, cell, lamc_last(s->apex)));
  const double *c = lamc_point(m, lamc_corner(m, cell, s->apex));
  const double ux = b[0] - a[0], uy = b[1] - a[1], vx = c[0] - a[0], vy = c[1] - a[1];
  const double half = 0.5 * s->shortest;
  /* Height of the circle's centre over the edge: half the edge over the tangent of the angle at the apex. */
  const double to_centre = half * ((vx * (vx - ux) + vy * (vy - uy)) / (ux * vy - uy * vx));
  double height = smaller(to_centre, w->slope * half);
  if (!centre && s->large && s->shortest <= 1.5 * s->wanted) {
    const double leg = s->wanted * s->wanted - half * half;
    height = smaller(height, leg > half * half ? sqrt(leg) : half);
  }
  if (centre && !s->thin) height = to_centre;
  const double over = height / s->shortest;
  p[0] = a[0] + 0.5 * ux - over * uy;
  p[1] = a[1] + 0.5 * uy + over * ux;
}

static bool in_lens(const lamc_work *w, const double *a, const double *b, const double *p) {
  const double ax = a[0] - p[0], ay = a[1] - p[1], bx = b[0] - p[0], by = b[1] - p[1];
  const double dot = ax * bx + ay * by;
  return dot < 0.0 && dot * dot >= w->lens * (ax * ax + ay * ay) * (bx * bx + by * by);
}

static double size_at(const lamc_work *w, const lamc_hole *hole, const double *p) {
  const lamc_mesher *m = w->m;
  double size = HUGE_VAL;
  for (int32_t i = 0; i < hole->edge_count; i++) {
    const int32_t *edge = hole->edges + EDGE_FIELDS * i;
    if (edge[EDGE_REGION] < 0) continue;
    const double there =
        m->sizes[edge[EDGE_A]] + w->rules->grading * distance(p, lamc_point(m, edge[EDGE_A]));
    size = smaller(smaller(size, there), w->rules->region_sizes[edge[EDGE_REGION]]);
  }
  return size;
}

/* Puts p into its hole, and the new cells into the queue. */
static int insert(lamc_work *w, lamc_hole *hole, const double p[2], int32_t segment, int32_t a, int32_t b) {
  lamc_mesher *m = w->m;
  if (m->point_count >= m->point_capacity) return LAMC_MESHER_FULL;
  const int32_t point = m->point_count;
  m->points[2 * point] = p[0];
  m->points[2 * point + 1] = p[1];
  m->segment_of[point] = segment;
  m->sizes[point] = size_at(w, hole, p);
  const int status = lamc_fill_hole(m, point, hole, a, b);
  if (status != LAMC_MESHER_DONE) return status;
  m->point_count++;
  for (int32_t i = 0; i < hole->edge_count; i++) enqueue(w, hole->cells[i]);
  return LAMC_MESHER_DONE;
}

/* Splits a part of a segment in its middle, unless its halves would be too short. */
static int split_segment(lamc_work *w, lamc_side s, bool *done) {
  lamc_mesher *m = w->m;
  const int32_t a = lamc_corner(m, s.cell, lamc_next(s.side)), b = lamc_corner(m, s.cell, lamc_last(s.side));
  const double *pa = lamc_point(m, a), *pb = lamc_point(m, b);
  const int32_t region = m->regions[s.cell];
  *done = false;
  if (region >= 0 && 0.5 * distance(pa, pb) < w->rules->region_floors[region]) return LAMC_MESHER_DONE;
  const double p[2] = {0.5 * (pa[0] + pb[0]), 0.5 * (pa[1] + pb[1])};
  lamc_hole hole;
  const int status = lamc_find_hole(m, s.cell, p, s, &hole);
  if (status == LAMC_MESHER_LOST) return LAMC_MESHER_DONE;
  if (status != LAMC_MESHER_DONE) return status;
  int32_t segment = m->segment_of[a] >= 0 ? m->segment_of[a] : m->segment_of[b];
  if (segment < 0) {
    /* Both ends are given corners: the whole segment; it is the one that has both. */
    segment = 0;
    while (!((w->rules->segment_ends[2 * segment] == a && w->rules->segment_ends[2 * segment + 1] == b) ||
             (w->rules->segment_ends[2 * segment] == b && w->rules->segment_ends[2 * segment + 1] == a))) {
      segment++;
    }
  }
  *done = true;
  return insert(w, &hole, p, segment, a, b);
}

/* Where a point for a bad cell would come to lie. */
typedef struct lamc_proposal {
  double p[2];
  double nearest;       /* distance to the next point */
  lamc_side encroached; /* part of a segment that it is too near to, or that is in its way; cell -1: none */
  lamc_hole hole;       /* where there is none */
  bool possible;
} lamc_proposal;

static int propose(lamc_work *w, int32_t cell, const lamc_shape *s, bool centre, lamc_proposal *at) {
  lamc_mesher *m = w->m;
  place_point(w, cell, s, centre, at->p);
  at->nearest = HUGE_VAL;
  at->encroached = lamc_side_of(-1, 0);
  const lamc_side end = lamc_walk(m, cell, at->p, true);
  at->possible = end.cell >= 0;
  if (end.cell < 0) return LAMC_MESHER_DONE;
  if (end.side >= 0) {
    at->encroached = end;
    return LAMC_MESHER_DONE;
  }
  const int status = lamc_find_hole(m, end.cell, at->p, lamc_side_of(-1, 0), &at->hole);
  for (int32_t i = 0; i < at->hole.edge_count; i++) {
    const int32_t *edge = at->hole.edges + EDGE_FIELDS * i;
    const double *a = lamc_point(m, edge[EDGE_A]), *b = lamc_point(m, edge[EDGE_B]);
    at->nearest = smaller(at->nearest, distance(at->p, a));
    if (at->encroached.cell < 0 && edge[EDGE_FIXED] && in_lens(w, a, b, at->p)) {
      at->encroached = lamc_across(m, lamc_side_of(edge[EDGE_BEYOND], edge[EDGE_BEYOND_SIDE]));
    }
  }
  /* A point on a segment sees no hole, and is in the segment's lens. */
  at->possible = status == LAMC_MESHER_DONE || at->encroached.cell >= 0;
  return status == LAMC_MESHER_FULL ? status : LAMC_MESHER_DONE;
}

/* Splits the segment that a point would be too near to, and comes back to the cell; a segment that is short enough
 * already is split for the sake of angles only. */
static int give_way(lamc_work *w, int32_t cell, const lamc_shape *s, lamc_side part) {
  lamc_mesher *m = w->m;
  const int32_t a = lamc_corner(m, part.cell, lamc_next(part.side));
  const int32_t b = lamc_corner(m, part.cell, lamc_last(part.side));
  const double length = distance(lamc_point(m, a), lamc_point(m, b));
  if (!s->thin && length <= TOO_LARGE * 0.5 * (m->sizes[a] + m->sizes[b])) return LAMC_MESHER_DONE;
  bool done;
  const int status = split_segment(w, part, &done);
  if (status == LAMC_MESHER_DONE && done) enqueue(w, cell);
  return status;
}

/* Makes a bad cell better, or leaves it where that would take edges below the floor. */
static int improve(lamc_work *w, int32_t cell) {
  if (w->m->regions[cell] < 0)
    return LAMC_MESHER_DONE; /* its place was given to a cell outside since it was queued */
  const lamc_shape s = shape_of(w, cell);
  const double floor = w->rules->region_floors[w->m->regions[cell]];
  if (!s.large && (!s.thin || s.shortest < floor || spans_corner(w, cell, &s))) return LAMC_MESHER_DONE;
  if (s.radius == HUGE_VAL) return LAMC_MESHER_DONE;
  lamc_proposal at;
  int status = propose(w, cell, &s, false, &at);
  const bool crowded = at.encroached.cell >= 0 || at.nearest < TOO_NEAR * s.wanted;
  if (status == LAMC_MESHER_DONE && at.possible && !s.thin && crowded)
    status = propose(w, cell, &s, true, &at);
  if (status != LAMC_MESHER_DONE || !at.possible) return status;
  if (at.encroached.cell >= 0) return give_way(w, cell, &s, at.encroached);
  if (!s.large && at.nearest < floor) return LAMC_MESHER_DONE;
  return insert(w, &at.hole, at.p, -2, -1, -1);
}

int lamc_mesher_refine(lamc_mesher *m, const lamc_mesher_rules *rules) {
  const double sine = sin(rules->least_angle), cosine = 1.0 - 2.0 * sine * sine;
  lamc_work w = {m, rules, 0.5 / sine, 0.0, 0.0, 0, 0};
  w.lens = cosine * cosine; /* the lens's rim sees the segment at 180° - 2 least angles */
  w.slope =
      (1.0 + cos(rules->least_angle)) / sine; /* 1 / tan(angle / 2): the apex of the off-centre's cell */
  for (int32_t cell = 0; cell < m->cell_count; cell++) enqueue(&w, cell);
  while (w.waiting > 0) {
    const int status = improve(&w, dequeue(&w));
    if (status != LAMC_MESHER_DONE) return status;
  }
  return LAMC_MESHER_DONE;
}
