/* lane_loops.h, of lamc: motion under the closure of small loops, for several runs side by side.
 *
 * In:    the model's M, f, J, gamma and phi in lanes. Out: accelerations, and states brought back to closure, with the bits
 *        of loops.c; which lanes are no regular case.
 * Never: decides on a lane where an equation fades or is let go: that one is left to loops.c.
 *
 * Pivots are each lane's own. Rows and columns of all lanes are exchanged by masks, so that what follows is the same for
 * all; goals are columns behind J, which rows take along. Operations are in the order of loop_dense.h and
 * loop_equations.h, whose names are here in brackets. */
#ifndef LAMC_LANE_LOOPS_H
#define LAMC_LANE_LOOPS_H

#include "lane_numbers.h"
#include "loops.h"
#include "tolerances.h"

enum {
  FREE = NU - RANK, /* rates that are left over */
  MASS = NU * (NU + 1) / 2,
  GOALS = 2, /* phi or gamma; rates that open the loops */
  WIDTH = NU + GOALS,
  COLUMNS = 1 << 4, /* a place in J is COLUMNS * row + column */
  ROUNDS = 8        /* MAX_ITERATIONS */
};

typedef struct lane_loops {
  lanes raw[MASS + NU + ENTRIES + NM]; /* M, f; J and gamma behind them */
  lanes closure[NM + ENTRIES];         /* phi and J */
  lanes norms[NM];
  lanes a[NM][WIDTH], inverse[RANK];
  lane_mask is_rate[NU][NU]; /* whether column k of `a` is the rate */
  lanes last;                /* the last pivot, of the first */
  lanes free[FREE + 1][NU], l[FREE + 1][FREE + 1];
  lanes y[NQ + NU]; /* a state that is being closed */
  lane_mask odd;    /* no regular case */
} lane_loops;

LAMC_LANE_FUNCTION void lane_exchange(lane_mask is, lanes *a, lanes *b) {
  const lanes keep = *a;
  *a = lane_pick(is, *b, *a);
  *b = lane_pick(is, keep, *b);
}

/* (larger of loops.c): NaN where one is */
LAMC_LANE_FUNCTION lanes lane_most(lanes most, lanes next) {
  return lane_pick(lane_less(most, next) | lane_not(lane_same(next, next)), next, most);
}

LAMC_LANE_FUNCTION lanes lane_largest(const lanes *v, int count) {
  lanes most = {0};
  LAMC_UNROLLED for (int i = 0; i < count; i++) most = lane_most(most, lane_fabs(v[i]));
  return most;
}

LAMC_LANE_FUNCTION lanes lane_dot(int count, const lanes *a, const lanes *b) {
  lanes sum = {0};
  LAMC_UNROLLED for (int i = 0; i < count; i++) sum += a[i] * b[i];
  return sum;
}

/* ---- The equations that hold ------------------------------------------------------------------------------- */

/* Rows of J, and `extra` with them, whose largest entry is about one [lamc_loop_normalise, lamc_loop_divide] */
LAMC_LANE_FUNCTION void lane_normalise(lane_loops *p, const lanes *c, lanes *j, lanes *extra) {
  const lanes least = lane_larger(OF_MISFIT * (c[NC - 1] / c[NC - 2]), EACH(NO_EQUATION));
  LAMC_UNROLLED for (int i = 0; i < NM; i++) {
    lanes norm = {0};
    LAMC_UNROLLED for (int e = LANE_ROW_START[i]; e < LANE_ROW_START[i + 1]; e++) norm =
        lane_larger(lane_fabs(j[e]), norm);
    const lane_mask is_plain = lane_less(EACH(0.25), norm) & lane_less(norm, EACH(4.0));
    p->norms[i] = EACH(1.0);
    if (!lane_some(lane_not(is_plain))) continue;
    const lane_mask holds = lane_less(least, norm);
    const lanes faint = lane_pick(lane_less(EACH(NO_EQUATION), least), 1.0 / least, EACH(0.0));
    const lanes scale = lane_pick(is_plain, EACH(1.0), lane_pick(holds, 1.0 / norm, faint));
    p->odd |= holds & lane_less(norm, EACH(FADING));
    p->norms[i] = lane_pick(is_plain, EACH(1.0), lane_pick(holds, norm, EACH(0.0)));
    LAMC_UNROLLED for (int e = LANE_ROW_START[i]; e < LANE_ROW_START[i + 1]; e++) j[e] *= scale;
    extra[i] *= scale;
  }
}

/* Where the largest so far is */
typedef struct lane_place {
  lanes size;
  lane_bits at;
} lane_place;

LAMC_LANE_FUNCTION void lane_look(lanes value, int at, lane_place *largest) {
  const lanes size = lane_fabs(value);
  const lane_mask is = lane_less(largest->size, size);
  largest->size = lane_pick(is, size, largest->size);
  largest->at = (lane_bits)lane_pick(is, (lanes)(largest->at * 0 + at), (lanes)largest->at);
}

/* Likewise, of a row that comes after it: rows are looked through by themselves, so that none waits for another. */
LAMC_LANE_FUNCTION void lane_look_on(const lane_place *row, lane_place *largest) {
  const lane_mask is = lane_less(largest->size, row->size);
  largest->size = lane_pick(is, row->size, largest->size);
  largest->at = (lane_bits)lane_pick(is, (lanes)row->at, (lanes)largest->at);
}

/* What pivot k has, from the rows below; where the largest that is left is [lamc_dense_eliminate] */
LAMC_LANE_FUNCTION lane_bits lane_eliminate(lanes (*a)[WIDTH], lanes inverse, int k) {
  lane_place largest = {EACH(-1.0), {0}};
  LAMC_UNROLLED for (int i = k + 1; i < NM; i++) {
    lane_place of_row = {EACH(-1.0), {0}};
    const lanes part = a[i][k] *= inverse;
    LAMC_UNROLLED for (int c = k + 1; c < NU; c++) {
      a[i][c] -= part * a[k][c];
      lane_look(a[i][c], COLUMNS * i + c, &of_row);
    }
    lane_look_on(&of_row, &largest);
  }
  return largest.at;
}

/* The largest that is left comes to place k, k [lamc_dense_swap] */
LAMC_LANE_FUNCTION void lane_bring(lanes (*a)[WIDTH], int k, lane_bits best, lanes *rate) {
  const lane_bits row = best >> 4, column = best & (COLUMNS - 1);
  LAMC_UNROLLED for (int i = k + 1; i < NM; i++) {
    const lane_mask is = lane_is(row, i);
    LAMC_UNROLLED for (int c = 0; c < WIDTH; c++) lane_exchange(is, &a[k][c], &a[i][c]);
  }
  LAMC_UNROLLED for (int c = k + 1; c < NU; c++) {
    const lane_mask is = lane_is(column, c);
    LAMC_UNROLLED for (int i = 0; i < NM; i++) lane_exchange(is, &a[i][k], &a[i][c]);
    lane_exchange(is, rate + k, rate + c);
  }
}

/* J eliminated, with goals beside it [lamc_dense_order] */
static LAMC_ONCE void lane_order(lane_loops *p, const lanes *j, const lanes *goal, const lanes *other) {
  lanes a[NM][WIDTH], rate[NU], first = {0}, size = {0};
  lane_place largest = {EACH(-1.0), {0}};
  LAMC_UNROLLED for (int i = 0; i < NM; i++) {
    lane_place of_row = {EACH(-1.0), {0}};
    LAMC_UNROLLED for (int c = 0; c < NU; c++) a[i][c] = EACH(0.0);
    LAMC_UNROLLED for (int e = LANE_ROW_START[i]; e < LANE_ROW_START[i + 1]; e++) {
      a[i][LANE_COLUMN[e]] = j[e];
      lane_look(j[e], COLUMNS * i + LANE_COLUMN[e], &of_row);
    }
    lane_look_on(&of_row, &largest);
    a[i][NU] = goal[i];
    a[i][NU + 1] = other[i];
  }
  LAMC_UNROLLED for (int c = 0; c < NU; c++) rate[c] = EACH((double)c);
  LAMC_UNROLLED for (int k = 0; k < RANK; k++) {
    lane_bring(a, k, largest.at, rate);
    size = lane_fabs(a[k][k]);
    if (k == 0) first = size;
    p->odd |= lane_not(lane_less(PASSING * first, size));
    p->inverse[k] = 1.0 / a[k][k];
    if (k + 1 < RANK) largest.at = lane_eliminate(a, p->inverse[k], k);
  }
  memcpy(p->a, a, sizeof a);
  p->odd |= lane_less(size, TOGETHER * first);
  p->last = size / first;
  LAMC_UNROLLED for (int k = 0; k < NU; k++) {
    LAMC_UNROLLED for (int i = 0; i < NU; i++) p->is_rate[k][i] = lane_same(rate[k], EACH((double)i));
  }
}

/* x (NU,) of which number k in the order of `a` is y[k], for `count` of them */
LAMC_LANE_FUNCTION void lane_spread(const lane_loops *p, const lanes *y, int count, lanes *x) {
  LAMC_UNROLLED for (int i = 0; i < NU; i++) {
    x[i] = EACH(0.0);
    LAMC_UNROLLED for (int k = 0; k < count; k++) x[i] = lane_pick(p->is_rate[k][i], y[k], x[i]);
  }
}

/* [lamc_dense_impose] */
static LAMC_ONCE void lane_impose(const lane_loops *p, int goal, lanes *x) {
  lanes y[RANK];
  LAMC_UNROLLED for (int k = 0; k < RANK; k++) y[k] = -p->a[k][NU + goal] - lane_dot(k, p->a[k], y);
  LAMC_UNROLLED for (int k = RANK - 1; k >= 0; k--) {
    LAMC_UNROLLED for (int i = k + 1; i < RANK; i++) y[k] -= p->a[k][i] * y[i];
    y[k] *= p->inverse[k];
  }
  lane_spread(p, y, RANK, x);
}

/* [lamc_dense_find_free] */
LAMC_LANE_FUNCTION void lane_find_free(lane_loops *p) {
  LAMC_UNROLLED for (int c = RANK; c < NU; c++) {
    lanes y[NU];
    LAMC_UNROLLED for (int k = RANK; k < NU; k++) y[k] = EACH(k == c ? 1.0 : 0.0);
    LAMC_UNROLLED for (int k = RANK - 1; k >= 0; k--) {
      lanes rest = -p->a[k][c];
      LAMC_UNROLLED for (int i = k + 1; i < RANK; i++) rest -= p->a[k][i] * y[i];
      y[k] = rest * p->inverse[k];
    }
    lane_spread(p, y, NU, p->free[c - RANK]);
  }
}

/* ---- Masses ------------------------------------------------------------------------------------------------ */

/* M v [lamc_loop_momenta] */
LAMC_LANE_FUNCTION void lane_momenta(const lanes *m, const lanes *v, lanes *momenta) {
  LAMC_UNROLLED for (int i = 0; i < NU; m += ++i) {
    momenta[i] = EACH(0.0);
    if (i >= CUT && i < BEYOND) continue;
    lanes sum = m[i] * v[i];
    LAMC_UNROLLED for (int k = 0; k < i; k++) {
      sum += m[k] * v[k];
      momenta[k] += m[k] * v[i];
    }
    momenta[i] = sum;
  }
}

/* N, and L of N^T M N [lamc_loop_reduce, lamc_loop_pair, lamc_cholesky] */
static LAMC_ONCE void lane_reduce(lane_loops *p) {
  lane_find_free(p);
  LAMC_UNROLLED for (int i = 0; i < FREE; i++) {
    lanes z[NU];
    lane_momenta(p->raw, p->free[i], z);
    LAMC_UNROLLED for (int k = 0; k <= i; k++) {
      p->l[i][k] = lane_dot(CUT, p->free[k], z);
      if (BEYOND < NU) p->l[i][k] += lane_dot(NU - BEYOND, p->free[k] + BEYOND, z + BEYOND);
    }
  }
  LAMC_UNROLLED for (int i = 0; i < FREE; i++) {
    LAMC_UNROLLED for (int k = 0; k <= i; k++) {
      const lanes rest = p->l[i][k] - lane_dot(k, p->l[i], p->l[k]);
      p->l[i][k] = k == i ? 1.0 / lane_sqrt(rest) : rest * p->l[k][k];
    }
  }
}

/* x += N L^-T L^-1 N^T z [lamc_loop_along, lamc_loop_add] */
static LAMC_ONCE void lane_go_along(const lane_loops *p, const lanes *z, lanes *x) {
  lanes amounts[FREE + 1];
  LAMC_UNROLLED for (int i = 0; i < FREE; i++) amounts[i] = lane_dot(NU, p->free[i], z);
  LAMC_UNROLLED for (int i = 0; i < FREE; i++) amounts[i] =
      (amounts[i] - lane_dot(i, p->l[i], amounts)) * p->l[i][i];
  LAMC_UNROLLED for (int i = FREE - 1; i >= 0; i--) {
    lanes sum = amounts[i];
    LAMC_UNROLLED for (int k = i + 1; k < FREE; k++) sum -= p->l[k][i] * amounts[k];
    amounts[i] = sum * p->l[i][i];
  }
  LAMC_UNROLLED for (int k = 0; k < FREE; k++) {
    LAMC_UNROLLED for (int i = 0; i < NU; i++) x[i] += amounts[k] * p->free[k][i];
  }
}

/* ---- Closure ----------------------------------------------------------------------------------------------- */

/* How far the state is from closure, in what is close enough [openness, close_enough] */
LAMC_LANE_FUNCTION lanes lane_openness(const lane_loops *p) {
  lanes most = {0};
  for (int i = 0; i < NM; i++) {
    const lanes gap = lane_fabs(p->closure[i]) * p->norms[i];
    const lanes fading = lane_pick(lane_less(p->norms[i], EACH(1.0)), p->norms[i] * p->last, p->last);
    const lanes enough = OUT_OF_NOTHING * fading * fading;
    const lanes least = lane_larger(enough, EACH(EXACT));
    const lanes off = gap / lane_pick(lane_less(EACH(CLOSED), enough), EACH(CLOSED), least);
    most = lane_most(most, lane_pick(lane_same(gap, EACH(0.0)), gap, off));
  }
  return most;
}

/* phi and J where the state is, and what they leave free; the largest of phi [evaluate_closure, lamc_loop_take] */
static LAMC_ONCE lanes lane_close(lane_loops *p, const lanes *c) {
  lanes *phi = p->closure, *j = p->closure + NM, rates[NM];
  lane_closure(c, p->y, p->closure);
  const lanes open = lane_largest(phi, NM);
  lane_normalise(p, c, j, phi);
  for (int i = 0; i < NM; i++) {
    rates[i] = EACH(0.0);
    for (int e = LANE_ROW_START[i]; e < LANE_ROW_START[i + 1]; e++)
      rates[i] += j[e] * p->y[NQ + LANE_COLUMN[e]];
  }
  lane_order(p, j, phi, rates);
  lane_reduce(p);
  return open;
}

/* The step that makes up for a goal [lamc_loop_solve] */
LAMC_LANE_FUNCTION void lane_make_up(const lane_loops *p, int goal, lanes *step) {
  lanes z[NU];
  lane_impose(p, goal, step);
  lane_momenta(p->raw, step, z);
  for (int i = 0; i < NU; i++) z[i] = EACH(0.0) - z[i];
  lane_go_along(p, z, step);
}

/* y brought back to closure in the lanes `wanted` [settle of loops.c]; those where that was done. The others keep theirs. A
 * lane that is closed before others is worked out again with them, at the same place. */
static lane_mask lane_settle_loops(lane_loops *p, const lanes *c, lanes t, lane_mask wanted, lanes *y,
                                   lanes *moved) {
  lanes step[NU], qdot[NQ], gap, open;
  memcpy(p->y, y, sizeof p->y);
  p->odd = (lane_mask){0};
  lane_system(c, t, p->y, p->y + NQ, p->raw);
  open = lane_close(p, c);
  gap = lane_openness(p);
  *moved = EACH(0.0);
  lane_mask goes_on = wanted;
  for (int round = 0; round < ROUNDS; round++) {
    goes_on &= lane_not(lane_at_most(gap, EACH(1.0)));
    if (!lane_some(goes_on)) break;
    lane_make_up(p, 0, step);
#if HAS_RATES
    lane_rates(c, p->y, step, qdot);
#else
    memcpy(qdot, step, sizeof qdot);
#endif
    for (int i = 0; i < NQ; i++) p->y[i] = lane_pick(goes_on, p->y[i] + qdot[i], p->y[i]);
    *moved = lane_pick(goes_on, *moved + lane_largest(step, NU), *moved);
    open = lane_close(p, c);
    const lanes before = gap;
    gap = lane_openness(p);
    goes_on &= lane_less(gap, 0.5 * before);
  }
  const lanes lost = lane_larger(EACH(LOST), c[NC - 1] / c[NC - 2]);
  const lane_mask done = wanted & lane_not(p->odd) & lane_at_most(open, lost);
  lane_make_up(p, 1, step);
  *moved = lane_larger(lane_largest(step, NU), *moved);
  for (int i = 0; i < NU; i++) p->y[NQ + i] += step[i];
  for (int i = 0; i < NQ + NU; i++) y[i] = lane_pick(done, p->y[i], y[i]);
  return done;
}

/* ---- Accelerations ----------------------------------------------------------------------------------------- */

/* J eliminated at a state; the lanes that are near a singular position [prepare, is_near_singular] */
static LAMC_ONCE lane_mask lane_prepare(lane_loops *p, const lanes *c, lanes t, const lanes *y) {
  lanes *j = p->raw + MASS + NU, *gamma = j + ENTRIES;
  lane_dynamics(c, t, y, y + NQ, p->raw);
  p->odd = (lane_mask){0};
  lane_normalise(p, c, j, gamma);
  lane_order(p, j, gamma, gamma);
  lane_mask near = lane_less(p->last, EACH(NEAR_SINGULAR));
  for (int i = 0; i < NM; i++)
    near |= lane_less(EACH(0.0), p->norms[i]) & lane_less(p->norms[i], EACH(NEAR_SINGULAR));
  return near;
}

/* udot in the lanes that are `busy` [lamc_loops_acceleration]; those where loops.c is to be asked instead. `settled`: those
 * whose state was brought to closure first, as beside singular positions. */
static lane_mask lane_accelerate(lane_loops *p, const lanes *c, lanes t, const lanes *y, lane_mask busy,
                                 lanes *udot, lane_mask *settled) {
  lanes z[NU], own[NQ + NU], moved;
  const lanes *f = p->raw + MASS;
  const lane_mask near = lane_prepare(p, c, t, y) & busy;
  lane_mask odd = p->odd | (near & lane_less(p->last, EACH(FADING)));
  *settled = near & lane_not(odd);
  if (lane_some(*settled)) {
    const lane_mask wanted = *settled;
    memcpy(own, y, sizeof own);
    *settled = lane_settle_loops(p, c, t, wanted, own, &moved);
    (void)lane_prepare(p, c, t, own);
    odd |= p->odd | (wanted & lane_not(*settled));
  }
  lane_reduce(p);
  lane_impose(p, 0, udot);
  lane_momenta(p->raw, udot, z);
  for (int i = 0; i < NU; i++) z[i] = -(z[i] - f[i]);
  lane_go_along(p, z, udot);
  return odd & busy;
}

/* What loops.c remembers of a state that it settled with every equation */
static void lane_remember(const lamc_motion *motion) {
  lamc_real kept[LAMC_LOOPS_KEPT];
  lamc_loops_keep(motion, kept);
  kept[0] = RANK;
  lamc_loops_put_back(motion, kept);
}

#endif /* LAMC_LANE_LOOPS_H */
