/* lane_loops.h, of lamc: motion under the closure of small loops, for several runs side by side.
 *
 * In:    the model's M, f, J, gamma and phi in lanes. Out: accelerations, and states brought back to closure, with the bits
 *        of loops.c; which lanes are no regular case.
 * Never: decides on a lane where an equation fades or is let go: that one is left to loops.c.
 *
 * Operations are in the order of loop_equations.h and loops.c, whose names are here in brackets. */
#ifndef LAMC_LANE_LOOPS_H
#define LAMC_LANE_LOOPS_H

#include "lane_pivots.h"
#include "loops.h"

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
