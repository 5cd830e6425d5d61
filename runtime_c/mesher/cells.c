/* Cells, their neighbours, and how a point comes in (Bowyer 1981, Watson 1981; here up to segments only). */
#include "cells.h"

#include "predicates.h"

lamc_side lamc_across(const lamc_mesher *m, lamc_side s) {
  lamc_side other = {m->neighbours[3 * s.cell + s.side], 0};
  if (other.cell < 0) return other;
  while (m->neighbours[3 * other.cell + other.side] != s.cell) other.side++;
  /* Two cells may share two edges only around a point of two cells, which there is not. */
  return other;
}

lamc_side lamc_walk(const lamc_mesher *m, int32_t cell, const double p[2], bool stop) {
  int32_t from = -1;
  for (int32_t steps = 0; steps <= m->cell_count; steps++) {
    int32_t out = -1;
    for (int32_t k = 0; k < 3 && out < 0; k++) {
      const int32_t beyond = m->neighbours[3 * cell + k];
      if (beyond >= 0 && beyond == from) continue;
      const double *a = lamc_point(m, lamc_corner(m, cell, lamc_next(k)));
      const double *b = lamc_point(m, lamc_corner(m, cell, lamc_last(k)));
      if (lamc_orientation(a, b, p) < 0.0) out = k;
    }
    if (out < 0) return lamc_side_of(cell, -1);
    const lamc_side s = {cell, out};
    if (stop && lamc_is_fixed(m, s)) return s;
    from = cell;
    cell = m->neighbours[3 * cell + out];
    if (cell < 0) break;
  }
  return lamc_side_of(-1, -1);
}

static bool circle_holds(const lamc_mesher *m, int32_t cell, const double p[2]) {
  const int32_t *v = m->corners + 3 * cell;
  return lamc_in_circle(lamc_point(m, v[0]), lamc_point(m, v[1]), lamc_point(m, v[2]), p) > 0.0;
}

int lamc_find_hole(lamc_mesher *m, int32_t cell, const double p[2], lamc_side through, lamc_hole *hole) {
  const int32_t most = m->stack_capacity / 9 - 2;
  int32_t *pending = m->stack, depth = 0; /* sides to look beyond, coded 4 cell + side; the next on top */
  hole->cells = pending + 2 * (most + 2);
  hole->edges = hole->cells + most + 2;
  hole->cells[0] = cell;
  hole->cell_count = 1;
  hole->edge_count = 0;
  const int32_t mark = ++m->mark;
  m->marks[cell] = mark;
  pending[depth++] = 4 * cell + 1; /* edges of a cell from corner 0: opposite 2, 0, 1 */
  pending[depth++] = 4 * cell + 0;
  pending[depth++] = 4 * cell + 2;
  while (depth > 0) {
    const int32_t code = pending[--depth];
    const lamc_side s = {code >> 2, code & 3}, beyond = lamc_across(m, s);
    const bool split = s.cell == through.cell && s.side == through.side;
    if (split || (beyond.cell >= 0 && !lamc_is_fixed(m, s) && circle_holds(m, beyond.cell, p))) {
      if (m->marks[beyond.cell] == mark)
        return LAMC_MESHER_LOST; /* a corner of the hole would be inside it */
      if (hole->cell_count >= most) return LAMC_MESHER_FULL;
      m->marks[beyond.cell] = mark;
      hole->cells[hole->cell_count++] = beyond.cell;
      pending[depth++] = 4 * beyond.cell + lamc_last(beyond.side);
      pending[depth++] = 4 * beyond.cell + lamc_next(beyond.side);
      continue;
    }
    int32_t *edge = hole->edges + EDGE_FIELDS * hole->edge_count++;
    edge[EDGE_A] = lamc_corner(m, s.cell, lamc_next(s.side));
    edge[EDGE_B] = lamc_corner(m, s.cell, lamc_last(s.side));
    edge[EDGE_BEYOND] = beyond.cell;
    edge[EDGE_BEYOND_SIDE] = beyond.side;
    edge[EDGE_FIXED] = lamc_is_fixed(m, s);
    edge[EDGE_REGION] = m->regions[s.cell];
    if (!(lamc_orientation(p, lamc_point(m, edge[EDGE_A]), lamc_point(m, edge[EDGE_B])) > 0.0)) {
      return LAMC_MESHER_LOST;
    }
  }
  return LAMC_MESHER_DONE;
}

int lamc_fill_hole(lamc_mesher *m, int32_t point, lamc_hole *hole, int32_t a, int32_t b) {
  const int32_t count = hole->edge_count;
  if (m->cell_count + count - hole->cell_count > m->cell_capacity) return LAMC_MESHER_FULL;
  while (hole->cell_count < count) {
    m->flags[m->cell_count] = 0;
    m->marks[m->cell_count] = 0;
    hole->cells[hole->cell_count++] = m->cell_count++;
  }
  for (int32_t i = 0; i < count; i++) {
    const int32_t *edge = hole->edges + EDGE_FIELDS * i;
    const int32_t cell = hole->cells[i], v[3] = {point, edge[EDGE_A], edge[EDGE_B]};
    const bool first = v[1] == a || v[1] == b, second = v[2] == a || v[2] == b;
    for (int32_t k = 0; k < 3; k++) {
      m->corners[3 * cell + k] = v[k];
      m->cell_at[v[k]] = cell;
    }
    m->neighbours[3 * cell] = edge[EDGE_BEYOND];
    m->neighbours[3 * cell + 1] = hole->cells[i + 1 == count ? 0 : i + 1];
    m->neighbours[3 * cell + 2] = hole->cells[i == 0 ? count - 1 : i - 1];
    if (edge[EDGE_BEYOND] >= 0) m->neighbours[3 * edge[EDGE_BEYOND] + edge[EDGE_BEYOND_SIDE]] = cell;
    m->regions[cell] = edge[EDGE_REGION];
    m->flags[cell] =
        (uint8_t)((m->flags[cell] & QUEUED) | edge[EDGE_FIXED] | (second ? 2 : 0) | (first ? 4 : 0));
  }
  return LAMC_MESHER_DONE;
}

/* Cell `cell` gets corners v, neighbours n beyond the edges opposite to them, and whether these are fixed. */
static void set_cell(lamc_mesher *m, int32_t cell, const int32_t v[3], const lamc_side n[3],
                     const bool fixed[3]) {
  uint8_t flags = m->flags[cell] & QUEUED;
  for (int32_t k = 0; k < 3; k++) {
    m->corners[3 * cell + k] = v[k];
    m->cell_at[v[k]] = cell;
    m->neighbours[3 * cell + k] = n[k].cell;
    if (n[k].cell >= 0) m->neighbours[3 * n[k].cell + n[k].side] = cell;
    flags = (uint8_t)(flags | (fixed[k] ? 1 << k : 0));
  }
  m->flags[cell] = flags;
}

void lamc_flip(lamc_mesher *m, lamc_side s) {
  const lamc_side o = lamc_across(m, s);
  const lamc_side right = {s.cell, lamc_next(s.side)}, left = {s.cell, lamc_last(s.side)};
  const lamc_side o_right = {o.cell, lamc_next(o.side)}, o_left = {o.cell, lamc_last(o.side)};
  const int32_t c = lamc_corner(m, s.cell, s.side), d = lamc_corner(m, o.cell, o.side);
  const int32_t a = lamc_corner(m, s.cell, right.side), b = lamc_corner(m, s.cell, left.side);
  /* Beyond the four outer edges; in cell o the corners are d, b, a. */
  const lamc_side ca = lamc_across(m, left), bc = lamc_across(m, right);
  const lamc_side ad = lamc_across(m, o_right), db = lamc_across(m, o_left);
  const bool fixed_ca = lamc_is_fixed(m, left), fixed_bc = lamc_is_fixed(m, right);
  const bool fixed_ad = lamc_is_fixed(m, o_right), fixed_db = lamc_is_fixed(m, o_left);
  const int32_t one[3] = {c, a, d}, two[3] = {c, d, b};
  const lamc_side beyond_one[3] = {ad, lamc_side_of(o.cell, 2), ca},
                  beyond_two[3] = {db, bc, lamc_side_of(s.cell, 1)};
  const bool fixed_one[3] = {fixed_ad, false, fixed_ca}, fixed_two[3] = {fixed_db, fixed_bc, false};
  set_cell(m, s.cell, one, beyond_one, fixed_one);
  set_cell(m, o.cell, two, beyond_two, fixed_two);
}

void lamc_restore(lamc_mesher *m) {
  /* Ends, since every flip raises the smallest angles and signs are exact. */
  bool changed = true;
  while (changed) {
    changed = false;
    for (int32_t cell = 0; cell < m->cell_count; cell++) {
      for (int32_t k = 0; k < 3; k++) {
        const lamc_side s = {cell, k}, o = lamc_across(m, s);
        if (o.cell < 0 || lamc_is_fixed(m, s)) continue;
        if (circle_holds(m, cell, lamc_point(m, lamc_corner(m, o.cell, o.side)))) {
          lamc_flip(m, s);
          changed = true;
        }
      }
    }
  }
}
