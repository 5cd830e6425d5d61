/* The constrained Delaunay triangulation that refinement starts from.
 *
 * Points come in one by one; then every segment is made an edge by flipping what crosses it (S. W. Sloan, A fast
 * algorithm for generating constrained Delaunay triangulations, Computers & Structures 47 (1993) 441-450). */
#include "cells.h"
#include "predicates.h"

/* The edge from corner u to corner w, or cell -1: by going round u. All points lie inside the box, so u has cells all
 * around, or is a corner of the box. */
static lamc_side find_edge(const lamc_mesher *m, int32_t u, int32_t w) {
  const int32_t start = m->cell_at[u];
  for (int32_t way = 0; way < 2; way++) {
    int32_t cell = start;
    do {
      int32_t k = 0;
      while (lamc_corner(m, cell, k) != u) k++;
      if (lamc_corner(m, cell, lamc_next(k)) == w) return lamc_side_of(cell, lamc_last(k));
      if (lamc_corner(m, cell, lamc_last(k)) == w) return lamc_side_of(cell, lamc_next(k));
      cell = m->neighbours[3 * cell + (way == 0 ? lamc_next(k) : lamc_last(k))];
    } while (cell >= 0 && cell != start);
    if (cell == start) break;
  }
  return lamc_side_of(-1, 0);
}

static void fix(lamc_mesher *m, lamc_side s) {
  const lamc_side o = lamc_across(m, s);
  m->flags[s.cell] = (uint8_t)(m->flags[s.cell] | 1 << s.side);
  if (o.cell >= 0) m->flags[o.cell] = (uint8_t)(m->flags[o.cell] | 1 << o.side);
}

static double ahead(const lamc_mesher *m, int32_t a, int32_t b, int32_t c) {
  const double *pa = lamc_point(m, a), *pb = lamc_point(m, b), *pc = lamc_point(m, c);
  return (pb[0] - pa[0]) * (pc[0] - pa[0]) + (pb[1] - pa[1]) * (pc[1] - pa[1]);
}

static double turn(const lamc_mesher *m, int32_t a, int32_t b, int32_t c) {
  return lamc_orientation(lamc_point(m, a), lamc_point(m, b), lamc_point(m, c));
}

/* The edge opposite corner a through which the line from a to b leaves; or a corner on the line, in *on. */
static lamc_side first_crossed(const lamc_mesher *m, int32_t a, int32_t b, int32_t *on) {
  const int32_t start = m->cell_at[a];
  int32_t cell = start;
  do {
    int32_t k = 0;
    while (lamc_corner(m, cell, k) != a) k++;
    const int32_t right = lamc_corner(m, cell, lamc_next(k)), left = lamc_corner(m, cell, lamc_last(k));
    const double at_right = turn(m, a, b, right), at_left = turn(m, a, b, left);
    if (at_right == 0.0 && ahead(m, a, b, right) > 0.0) {
      *on = right;
      return lamc_side_of(cell, lamc_last(k));
    }
    if (at_right < 0.0 && at_left > 0.0) return lamc_side_of(cell, k);
    cell = m->neighbours[3 * cell + lamc_next(k)];
  } while (cell >= 0 && cell != start);
  return lamc_side_of(-1, 0);
}

/* Lists the edges that the line from a to b crosses, from the first one on, two ends each, in the mesher's stack; gives
 * the first point on the line in *end. */
static int list_crossed(lamc_mesher *m, int32_t a, int32_t b, lamc_side s, int32_t *count, int32_t *end) {
  const int32_t most = m->stack_capacity / 2 - 1;
  *count = 0;
  while (*end < 0) {
    if (lamc_is_fixed(m, s)) return LAMC_MESHER_CROSSING;
    if (*count >= most) return LAMC_MESHER_FULL;
    m->stack[2 * *count] = lamc_corner(m, s.cell, lamc_next(s.side));
    m->stack[2 * *count + 1] = lamc_corner(m, s.cell, lamc_last(s.side));
    ++*count;
    s = lamc_across(m, s);
    const int32_t apex = lamc_corner(m, s.cell, s.side);
    const double side = turn(m, a, b, apex);
    if (side == 0.0) *end = apex;
    /* In s.cell the crossed edge runs from the left of the line to its right. */
    s.side = side > 0.0 ? lamc_next(s.side) : lamc_last(s.side);
  }
  return LAMC_MESHER_DONE;
}

/* Flips the listed edges until none crosses the line from a to end; those that cannot be flipped yet wait. */
static void flip_crossed(lamc_mesher *m, int32_t a, int32_t end, int32_t waiting) {
  const int32_t most = m->stack_capacity / 2 - 1;
  int32_t head = 0;
  while (waiting > 0) {
    int32_t ends[2] = {m->stack[2 * head], m->stack[2 * head + 1]};
    const lamc_side s = find_edge(m, ends[0], ends[1]), o = lamc_across(m, s);
    const int32_t c = lamc_corner(m, s.cell, s.side), d = lamc_corner(m, o.cell, o.side);
    const int32_t p = lamc_corner(m, s.cell, lamc_next(s.side)),
                  q = lamc_corner(m, s.cell, lamc_last(s.side));
    const int32_t tail = (int32_t)(((int64_t)head + waiting) % most);
    head = head + 1 == most ? 0 : head + 1;
    waiting--;
    if (turn(m, c, p, d) > 0.0 && turn(m, d, q, c) > 0.0) {
      lamc_flip(m, s);
      const double at_c = turn(m, a, end, c), at_d = turn(m, a, end, d);
      if (!((at_c > 0.0 && at_d < 0.0) || (at_c < 0.0 && at_d > 0.0))) continue;
      ends[0] = c;
      ends[1] = d;
    }
    m->stack[2 * tail] = ends[0];
    m->stack[2 * tail + 1] = ends[1];
    waiting++;
  }
}

/* Makes the part of segment a to b an edge that ends in b or in the first point on it; gives that point in *end. */
static int insert_part(lamc_mesher *m, int32_t a, int32_t b, int32_t *end) {
  const lamc_side there = find_edge(m, a, b);
  *end = -1;
  if (there.cell >= 0) {
    *end = b;
    fix(m, there);
    return LAMC_MESHER_DONE;
  }
  const lamc_side first = first_crossed(m, a, b, end);
  if (first.cell < 0) return LAMC_MESHER_LOST;
  if (*end >= 0) {
    fix(m, first);
    return LAMC_MESHER_DONE;
  }
  int32_t count;
  const int status = list_crossed(m, a, b, first, &count, end);
  if (status != LAMC_MESHER_DONE) return status;
  flip_crossed(m, a, *end, count);
  fix(m, find_edge(m, a, *end));
  return LAMC_MESHER_DONE;
}

static int insert_points(lamc_mesher *m) {
  int32_t cell = 0;
  for (int32_t point = 4; point < m->point_count; point++) {
    const double *p = lamc_point(m, point);
    lamc_hole hole;
    m->failed = point;
    cell = lamc_walk(m, cell, p, false).cell;
    if (cell < 0) return LAMC_MESHER_LOST;
    for (int32_t k = 0; k < 3; k++) {
      const double *q = lamc_point(m, lamc_corner(m, cell, k));
      if (q[0] == p[0] && q[1] == p[1]) return LAMC_MESHER_DOUBLE;
    }
    int status = lamc_find_hole(m, cell, p, lamc_side_of(-1, 0), &hole);
    if (status == LAMC_MESHER_DONE) status = lamc_fill_hole(m, point, &hole, -1, -1);
    if (status != LAMC_MESHER_DONE) return status;
    cell = hole.cells[0];
  }
  return LAMC_MESHER_DONE;
}

static void number_pieces(lamc_mesher *m) {
  int32_t piece = 0;
  for (int32_t cell = 0; cell < m->cell_count; cell++) m->regions[cell] = -1;
  for (int32_t first = 0; first < m->cell_count; first++) {
    if (m->regions[first] >= 0) continue;
    int32_t waiting = 0;
    m->queue[waiting++] = first;
    m->regions[first] = piece;
    while (waiting > 0) {
      const int32_t cell = m->queue[--waiting];
      for (int32_t k = 0; k < 3; k++) {
        const int32_t beyond = m->neighbours[3 * cell + k];
        if (beyond < 0 || m->regions[beyond] >= 0 || lamc_is_fixed(m, lamc_side_of(cell, k))) continue;
        m->regions[beyond] = piece;
        m->queue[waiting++] = beyond;
      }
    }
    piece++;
  }
}

int lamc_mesher_triangulate(lamc_mesher *m, const int32_t *segments, int32_t segment_count) {
  static const int32_t corners[6] = {0, 1, 2, 0, 2, 3}, neighbours[6] = {-1, 1, -1, -1, -1, 0};
  if (m->cell_capacity < 2) return LAMC_MESHER_FULL;
  for (int32_t i = 0; i < 6; i++) {
    m->corners[i] = corners[i];
    m->neighbours[i] = neighbours[i];
    m->cell_at[corners[i]] = i / 3;
  }
  for (int32_t i = 0; i < 2; i++) {
    m->regions[i] = m->marks[i] = 0;
    m->flags[i] = 0;
  }
  m->cell_count = 2;
  m->mark = 0;
  int status = insert_points(m);
  for (int32_t i = 0; i < segment_count && status == LAMC_MESHER_DONE; i++) {
    int32_t a = segments[2 * i];
    const int32_t b = segments[2 * i + 1];
    m->failed = i;
    while (a != b && status == LAMC_MESHER_DONE) {
      int32_t end = a;
      status = insert_part(m, a, b, &end);
      a = end;
    }
  }
  if (status != LAMC_MESHER_DONE) return status;
  lamc_restore(m);
  number_pieces(m);
  return LAMC_MESHER_DONE;
}
