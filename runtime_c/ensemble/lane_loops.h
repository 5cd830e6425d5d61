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
  lane_bits is_rate[NU][NU]; /* whether column k of `a` is the rate */
  lanes last;                /* the last pivot, of the first */
  lanes free[FREE + 1][NU], l[FREE + 1][FREE + 1];
  lanes y[NQ + NU]; /* a state that is being closed */
  lane_bits odd;    /* no regular case */
} lane_loops;

LAMC_LANE_FUNCTION lanes lane_pick(lane_bits is, lanes a, lanes b) {
  return (lanes)((is & (lane_bits)a) | (~is & (lane_bits)b));
}

LAMC_LANE_FUNCTION void lane_exchange(lane_bits is, lanes *a, lanes *b) {
  const lanes keep = *a;
  *a = lane_pick(is, *b, *a);
  *b = lane_pick(is, keep, *b);
}

/* (larger of loops.c): NaN where one is */
LAMC_LANE_FUNCTION lanes lane_most(lanes most, lanes next) {
  return lane_pick((lane_bits)(next > most) | (lane_bits)(next != next), next, most);
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
  for (int i = 0; i < NM; i++) {
    lanes norm = {0};
    for (int e = LANE_ROW_START[i]; e < LANE_ROW_START[i + 1]; e++) norm = lane_larger(lane_fabs(j[e]), norm);
    const lane_bits is_plain = (lane_bits)(norm > 0.25) & (lane_bits)(norm < 4.0);
    p->norms[i] = EACH(1.0);
    if (!lane_any(~is_plain)) continue;
    const lane_bits holds = (lane_bits)(norm > least);
    const lanes faint = lane_pick((lane_bits)(least > NO_EQUATION), 1.0 / least, EACH(0.0));
    const lanes scale = lane_pick(is_plain, EACH(1.0), lane_pick(holds, 1.0 / norm, faint));
    p->odd |= holds & (lane_bits)(norm < FADING);
    p->norms[i] = lane_pick(is_plain, EACH(1.0), (lanes)(holds & (lane_bits)norm));
    for (int e = LANE_ROW_START[i]; e < LANE_ROW_START[i + 1]; e++) j[e] *= scale;
    extra[i] *= scale;
  }
}

/* Where the largest so far is */
LAMC_LANE_FUNCTION void lane_look(lanes value, int at, lanes *most, lane_bits *best) {
  const lanes size = lane_fabs(value);
  const lane_bits is = (lane_bits)(size > *most);
  *most = lane_pick(is, size, *most);
  *best = (is & at) | (~is & *best);
}

/* What pivot k has, from the rows below; where the largest that is left is [lamc_dense_eliminate] */
LAMC_LANE_FUNCTION lane_bits lane_eliminate(lane_loops *p, int k) {
  lanes most = EACH(-1.0);
  lane_bits best = {0};
  for (int i = k + 1; i < NM; i++) {
    const lanes part = p->a[i][k] *= p->inverse[k];
    LAMC_UNROLLED for (int c = k + 1; c < NU; c++) {
      p->a[i][c] -= part * p->a[k][c];
      lane_look(p->a[i][c], COLUMNS * i + c, &most, &best);
    }
  }
  return best;
}

/* The largest that is left comes to place k, k [lamc_dense_swap] */
LAMC_LANE_FUNCTION void lane_bring(lane_loops *p, int k, lane_bits best, int width, lanes *rate) {
  const lane_bits row = best >> 4, column = best & (COLUMNS - 1);
  for (int i = k + 1; i < NM; i++) {
    const lane_bits is = (lane_bits)(row == i);
    LAMC_UNROLLED for (int c = 0; c < width; c++) lane_exchange(is, &p->a[k][c], &p->a[i][c]);
  }
  for (int c = k + 1; c < NU; c++) {
    const lane_bits is = (lane_bits)(column == c);
    LAMC_UNROLLED for (int i = 0; i < NM; i++) lane_exchange(is, &p->a[i][k], &p->a[i][c]);
    lane_exchange(is, rate + k, rate + c);
  }
}

/* J eliminated, the first `goals` of its goals beside it [lamc_dense_order] */
LAMC_LANE_FUNCTION void lane_order(lane_loops *p, const lanes *j, const lanes *const *goal, int goals) {
  lanes most = EACH(-1.0), rate[NU], first = {0}, size = {0};
  lane_bits best = {0};
  for (int i = 0; i < NM; i++) {
    for (int c = 0; c < NU; c++) p->a[i][c] = EACH(0.0);
    for (int e = LANE_ROW_START[i]; e < LANE_ROW_START[i + 1]; e++) {
      p->a[i][LANE_COLUMN[e]] = j[e];
      lane_look(j[e], COLUMNS * i + LANE_COLUMN[e], &most, &best);
    }
    for (int g = 0; g < goals; g++) p->a[i][NU + g] = goal[g][i];
  }
  for (int c = 0; c < NU; c++) rate[c] = EACH((double)c);
  for (int k = 0; k < RANK; k++) {
    lane_bring(p, k, best, NU + goals, rate);
    size = lane_fabs(p->a[k][k]);
    if (k == 0) first = size;
    p->odd |= ~(lane_bits)(size > PASSING * first);
    p->inverse[k] = 1.0 / p->a[k][k];
    if (k + 1 < RANK) best = lane_eliminate(p, k);
  }
  p->odd |= (lane_bits)(size < TOGETHER * first);
  p->last = size / first;
  for (int k = 0; k < NU; k++) {
    for (int i = 0; i < NU; i++) p->is_rate[k][i] = (lane_bits)(rate[k] == (double)i);
  }
}

/* x (NU,) of which number k in the order of `a` is y[k], for `count` of them */
LAMC_LANE_FUNCTION void lane_spread(const lane_loops *p, const lanes *y, int count, lanes *x) {
  for (int i = 0; i < NU; i++) {
    lane_bits all = {0};
    LAMC_UNROLLED for (int k = 0; k < count; k++) all |= p->is_rate[k][i] & (lane_bits)y[k];
    x[i] = (lanes)all;
  }
}

/* [lamc_dense_impose] */
LAMC_LANE_FUNCTION void lane_impose(const lane_loops *p, int goal, lanes *x) {
  lanes y[RANK];
  for (int k = 0; k < RANK; k++) y[k] = -p->a[k][NU + goal] - lane_dot(k, p->a[k], y);
  for (int k = RANK - 1; k >= 0; k--) {
    for (int i = k + 1; i < RANK; i++) y[k] -= p->a[k][i] * y[i];
    y[k] *= p->inverse[k];
  }
  lane_spread(p, y, RANK, x);
}

/* [lamc_dense_find_free] */
LAMC_LANE_FUNCTION void lane_find_free(lane_loops *p) {
  for (int c = RANK; c < NU; c++) {
    lanes y[NU];
    for (int k = RANK; k < NU; k++) y[k] = EACH(k == c ? 1.0 : 0.0);
    for (int k = RANK - 1; k >= 0; k--) {
      lanes rest = -p->a[k][c];
      for (int i = k + 1; i < RANK; i++) rest -= p->a[k][i] * y[i];
      y[k] = rest * p->inverse[k];
    }
    lane_spread(p, y, NU, p->free[c - RANK]);
  }
}

/* ---- Masses ------------------------------------------------------------------------------------------------ */

/* M v [lamc_loop_momenta] */
LAMC_LANE_FUNCTION void lane_momenta(const lanes *m, const lanes *v, lanes *momenta) {
  for (int i = 0; i < NU; m += ++i) {
    momenta[i] = EACH(0.0);
    if (i >= CUT && i < BEYOND) continue;
    lanes sum = m[i] * v[i];
    for (int k = 0; k < i; k++) {
      sum += m[k] * v[k];
      momenta[k] += m[k] * v[i];
    }
    momenta[i] = sum;
  }
}

/* N, and L of N^T M N [lamc_loop_reduce, lamc_loop_pair, lamc_cholesky] */
LAMC_LANE_FUNCTION void lane_reduce(lane_loops *p) {
  lane_find_free(p);
  for (int i = 0; i < FREE; i++) {
    lanes z[NU];
    lane_momenta(p->raw, p->free[i], z);
    for (int k = 0; k <= i; k++) {
      p->l[i][k] = lane_dot(CUT, p->free[k], z);
      if (BEYOND < NU) p->l[i][k] += lane_dot(NU - BEYOND, p->free[k] + BEYOND, z + BEYOND);
    }
  }
  for (int i = 0; i < FREE; i++) {
    for (int k = 0; k <= i; k++) {
      const lanes rest = p->l[i][k] - lane_dot(k, p->l[i], p->l[k]);
      p->l[i][k] = k == i ? 1.0 / lane_sqrt(rest) : rest * p->l[k][k];
    }
  }
}

/* x += N L^-T L^-1 N^T z [lamc_loop_along, lamc_loop_add] */
LAMC_LANE_FUNCTION void lane_go_along(const lane_loops *p, const lanes *z, lanes *x) {
  lanes amounts[FREE + 1];
  for (int i = 0; i < FREE; i++) amounts[i] = lane_dot(NU, p->free[i], z);
  for (int i = 0; i < FREE; i++) amounts[i] = (amounts[i] - lane_dot(i, p->l[i], amounts)) * p->l[i][i];
  for (int i = FREE - 1; i >= 0; i--) {
    lanes sum = amounts[i];
    for (int k = i + 1; k < FREE; k++) sum -= p->l[k][i] * amounts[k];
    amounts[i] = sum * p->l[i][i];
  }
  for (int k = 0; k < FREE; k++) {
    for (int i = 0; i < NU; i++) x[i] += amounts[k] * p->free[k][i];
  }
}

/* ---- Accelerations ----------------------------------------------------------------------------------------- */

/* udot where loops are far from singular positions [lamc_loops_acceleration]; the lanes where they are not */
static lane_bits lane_accelerate(lane_loops *p, const lanes *c, lanes t, const lanes *y, lanes *udot) {
  lanes *f = p->raw + MASS, *j = f + NU, *gamma = j + ENTRIES, z[NU];
  const lanes *const goals[1] = {gamma};
  lane_dynamics(c, t, y, y + NQ, p->raw);
  p->odd = (lane_bits){0};
  lane_normalise(p, c, j, gamma);
  lane_order(p, j, goals, 1);
  lane_bits near = (lane_bits)(p->last < NEAR_SINGULAR);
  for (int i = 0; i < NM; i++)
    near |= (lane_bits)(p->norms[i] > 0.0) & (lane_bits)(p->norms[i] < NEAR_SINGULAR);
  lane_reduce(p);
  lane_impose(p, 0, udot);
  lane_momenta(p->raw, udot, z);
  for (int i = 0; i < NU; i++) z[i] = -(z[i] - f[i]);
  lane_go_along(p, z, udot);
  return p->odd | near;
}

/* ---- Closure ----------------------------------------------------------------------------------------------- */

/* How far the state is from closure, in what is close enough [openness, close_enough] */
LAMC_LANE_FUNCTION lanes lane_openness(const lane_loops *p) {
  lanes most = {0};
  for (int i = 0; i < NM; i++) {
    const lanes gap = lane_fabs(p->closure[i]) * p->norms[i];
    const lanes fading = lane_pick((lane_bits)(p->norms[i] < 1.0), p->norms[i] * p->last, p->last);
    const lanes enough = OUT_OF_NOTHING * fading * fading;
    const lanes least = lane_larger(enough, EACH(EXACT));
    const lanes off = gap / lane_pick((lane_bits)(enough > CLOSED), EACH(CLOSED), least);
    most = lane_most(most, lane_pick((lane_bits)(gap == 0.0), gap, off));
  }
  return most;
}

/* phi and J where the state is, and what they leave free; the largest of phi [evaluate_closure, lamc_loop_take] */
LAMC_LANE_FUNCTION lanes lane_close(lane_loops *p, const lanes *c) {
  lanes *phi = p->closure, *j = p->closure + NM, rates[NM];
  const lanes *const goals[GOALS] = {phi, rates};
  lane_closure(c, p->y, p->closure);
  const lanes open = lane_largest(phi, NM);
  lane_normalise(p, c, j, phi);
  for (int i = 0; i < NM; i++) {
    rates[i] = EACH(0.0);
    for (int e = LANE_ROW_START[i]; e < LANE_ROW_START[i + 1]; e++)
      rates[i] += j[e] * p->y[NQ + LANE_COLUMN[e]];
  }
  lane_order(p, j, goals, GOALS);
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
static lane_bits lane_settle_loops(lane_loops *p, const lanes *c, lanes t, lane_bits wanted, lanes *y,
                                   lanes *moved) {
  lanes step[NU], qdot[NQ], gap, open;
  memcpy(p->y, y, sizeof p->y);
  p->odd = (lane_bits){0};
  lane_system(c, t, p->y, p->y + NQ, p->raw);
  open = lane_close(p, c);
  gap = lane_openness(p);
  *moved = EACH(0.0);
  lane_bits goes_on = wanted;
  for (int round = 0; round < ROUNDS; round++) {
    goes_on &= ~(lane_bits)(gap <= 1.0);
    if (!lane_any(goes_on)) break;
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
    goes_on &= (lane_bits)(gap < 0.5 * before);
  }
  const lanes lost = lane_larger(EACH(LOST), c[NC - 1] / c[NC - 2]);
  const lane_bits done = wanted & ~p->odd & (lane_bits)(open <= lost);
  lane_make_up(p, 1, step);
  *moved = lane_larger(lane_largest(step, NU), *moved);
  for (int i = 0; i < NU; i++) p->y[NQ + i] += step[i];
  for (int i = 0; i < NQ + NU; i++) y[i] = lane_pick(done, p->y[i], y[i]);
  return done;
}

/* What loops.c remembers of a state that it settled with every equation */
static void lane_remember(const lamc_motion *motion) {
  lamc_real kept[LAMC_LOOPS_KEPT];
  lamc_loops_keep(motion, kept);
  kept[0] = RANK;
  lamc_loops_put_back(motion, kept);
}

#endif /* LAMC_LANE_LOOPS_H */
