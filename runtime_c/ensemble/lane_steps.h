/* lane_steps.h, of lamc: steps of explicit Runge-Kutta methods, side by side. Included by the lanes of a model, behind its
 * equations lane_rates (HAS_RATES), lane_acceleration or lane_system (HAS_SYSTEM), the sizes NQ, NU and NC, and
 * SERIES_COUNT; with loops (HAS_LOOPS) behind lane_dynamics, lane_system and lane_closure, the sizes NM, RANK, ENTRIES, CUT
 * and BEYOND, and the places of entries LANE_ROW_START and LANE_COLUMN.
 *
 * In:    runs that stand at their own times, with steps of their own lengths. Out: where the steps lead, and their errors.
 * Never: adds in another order than rk45.c and dop853.c: lane by lane, all bits are theirs. */
#ifndef LAMC_LANE_STEPS_H
#define LAMC_LANE_STEPS_H

#include "dop853.h"
#include "lane_slopes.h"
#include "rk45.h"

/* ---- Between runs and lanes ---------------------------------------------------------------------------------- */

static void lane_put(lanes *v, int lane, const lamc_real *from) {
  for (int i = 0; i < N; i++) v[i][lane] = from[i];
}

static void lane_take(const lanes *v, int lane, lamc_real *to) {
  for (int i = 0; i < N; i++) to[i] = v[i][lane];
}

static void lane_take_constants(lamc_real *block, int lane, const lamc_real *constants) {
  lane_block *b = (lane_block *)(void *)block;
  for (int i = 0; i < NC; i++) b->c[i][lane] = constants[i];
}

static void lane_slope(lamc_real *block, lamc_run *const *runs) {
  lane_block *b = (lane_block *)(void *)block;
  lanes t = {0};
  for (int k = 0; k < LAMC_LANES; k++) {
    if (runs[k] == NULL) continue;
    t[k] = runs[k]->t;
    if (runs[k]->ode.settle != NULL) lane_put(b->y_new, k, y_here(runs[k]));
  }
  lane_rhs(b, runs, t, b->y_new, b->k[END]);
  for (int k = 0; k < LAMC_LANES; k++) {
    if (runs[k] == NULL) continue;
    runs[k]->evaluations++;
    lane_take(b->k[END], k, slope_here(runs[k]));
  }
}

/* ---- DOP853 -------------------------------------------------------------------------------------------------- */

/* Slope of stage k, from 0, as dop853.c counts them */
LAMC_LANE_FUNCTION const lanes *lane_stage(const lane_block *b, int k) {
  return b->k[k == 0 ? BEGIN : k <= STAGES ? k - 1 : k];
}

/* Sum of the first `count` stages of component i by weights, those that are zero left out as in dop853.c. With a constant
 * count the compiler is left with the terms alone. */
LAMC_LANE_FUNCTION lanes lane_sum(const lane_block *b, const lamc_real *weights, int count, int i) {
  lanes sum = {0};
  LAMC_UNROLLED for (int k = 0; k < count; k++) {
    if (weights[k] != 0.0) sum += weights[k] * lane_stage(b, k)[i];
  }
  return sum;
}

/* The argument of the stage `row`, a constant */
LAMC_LANE_FUNCTION void lane_argument(const lane_block *b, int row, lanes h, lanes *out) {
  for (int i = 0; i < N; i++) out[i] = b->y[i] + h * lane_sum(b, DOP853_A[row], row, i);
}

static void lane_dop853(lane_block *b, lamc_run *const *runs, const lamc_run *any, lanes t, lanes h,
                        lamc_real *squared) {
  const lamc_real atol = floor_of_scale(any), rtol = any->options.rtol;
#define STAGE(row)                                                                                           \
  lane_argument(b, row, h, b->s), lane_rhs(b, runs, t + DOP853_C[row] * h, b->s, b->k[row - 1])
  STAGE(1);
  STAGE(2);
  STAGE(3);
  STAGE(4);
  STAGE(5);
  STAGE(6);
  STAGE(7);
  STAGE(8);
  STAGE(9);
  STAGE(10);
  STAGE(11);
#undef STAGE
  lanes size = {0}, fifth = {0}, third = {0}; /* the latter as `weighed` of method.h */
  /* The new state and its errors at once: slopes of large models are slow to read. */
  for (int i = 0; i < N; i++) {
    b->y_new[i] = b->y[i] + h * lane_sum(b, DOP853_A[STAGES + 1], STAGES + 1, i);
    const lanes new_size = lane_fabs(b->y_new[i]);
    const lanes tolerance = atol + rtol * lane_larger(lane_fabs(b->y[i]), new_size);
    const lanes five = lane_sum(b, DOP853_E5, STAGES + 1, i) / tolerance;
    const lanes three = lane_sum(b, DOP853_E3, STAGES + 1, i) / tolerance;
    size += new_size;
    fifth += five * five;
    third += three * three;
  }
  const lanes both = fifth + 0.01 * third;
  const lanes error = h * h * fifth * fifth / (both * (double)N);
  for (int k = 0; k < LAMC_LANES; k++)
    squared[k] = !is_finite(size[k]) ? HUGE_VAL : both[k] > 0.0 ? error[k] : 0.0;
}

/* The continuous extension of the step just taken, and where runs look for it: make_dense of dop853.c */
static void lane_dense(lamc_real *block, lamc_run *const *runs, int *done) {
  lane_block *b = (lane_block *)(void *)block;
  lanes t = {0}, h = {0};
  lane_mask odd = {0};
  for (int k = 0; k < LAMC_LANES; k++) {
    if (runs[k] == NULL) continue;
    t[k] = runs[k]->t_old;
    h[k] = runs[k]->h_last;
  }
  lane_argument(b, 13, h, b->s);
  odd |= lane_try_rhs(b, runs, t + DOP853_C[13] * h, b->s, b->k[13]);
  lane_argument(b, 14, h, b->s);
  odd |= lane_try_rhs(b, runs, t + DOP853_C[14] * h, b->s, b->k[14]);
  lane_argument(b, 15, h, b->s);
  odd |= lane_try_rhs(b, runs, t + DOP853_C[15] * h, b->s, b->k[15]);
  for (int k = 0; k < LAMC_LANES; k++) done[k] = runs[k] != NULL && !lane_has(odd, k);
  for (int i = 0; i < N; i++) {
    const lanes change = b->y_new[i] - b->y[i], begin = b->k[BEGIN][i], end = b->k[END][i];
    const lanes terms[7] = {
        change,
        h * begin - change,
        2.0 * change - h * (end + begin),
        lane_sum(b, DOP853_D[0], SLOPES, i),
        lane_sum(b, DOP853_D[1], SLOPES, i),
        lane_sum(b, DOP853_D[2], SLOPES, i),
        lane_sum(b, DOP853_D[3], SLOPES, i),
    };
    for (int k = 0; k < LAMC_LANES; k++) {
      for (int j = 0; done[k] && j < 7; j++) slot(runs[k], SLOT_OWN + DOP853_DENSE + j)[i] = terms[j][k];
    }
  }
}

/* ---- RK45 ---------------------------------------------------------------------------------------------------- */

static void lane_rk45(lane_block *b, lamc_run *const *runs, const lamc_run *any, lanes t, lanes h,
                      lamc_real *squared) {
  const lamc_real atol = floor_of_scale(any), rtol = any->options.rtol;
  const lanes *y = b->y, *k1 = b->k[BEGIN], *k7 = b->k[END];
  lanes *k2 = b->k[0], *k3 = b->k[1], *k4 = b->k[2], *k5 = b->k[3], *k6 = b->k[4], *s = b->s;
  for (int i = 0; i < N; i++) s[i] = y[i] + h * (RK45_A21 * k1[i]);
  lane_rhs(b, runs, t + RK45_C2 * h, s, k2);
  for (int i = 0; i < N; i++) s[i] = y[i] + h * (RK45_A31 * k1[i] + RK45_A32 * k2[i]);
  lane_rhs(b, runs, t + RK45_C3 * h, s, k3);
  for (int i = 0; i < N; i++) s[i] = y[i] + h * (RK45_A41 * k1[i] + RK45_A42 * k2[i] + RK45_A43 * k3[i]);
  lane_rhs(b, runs, t + RK45_C4 * h, s, k4);
  for (int i = 0; i < N; i++)
    s[i] = y[i] + h * (RK45_A51 * k1[i] + RK45_A52 * k2[i] + RK45_A53 * k3[i] + RK45_A54 * k4[i]);
  lane_rhs(b, runs, t + RK45_C5 * h, s, k5);
  for (int i = 0; i < N; i++)
    s[i] = y[i] +
           h * (RK45_A61 * k1[i] + RK45_A62 * k2[i] + RK45_A63 * k3[i] + RK45_A64 * k4[i] + RK45_A65 * k5[i]);
  lane_rhs(b, runs, t + h, s, k6);
  for (int i = 0; i < N; i++)
    b->y_new[i] =
        y[i] + h * (RK45_B1 * k1[i] + RK45_B3 * k3[i] + RK45_B4 * k4[i] + RK45_B5 * k5[i] + RK45_B6 * k6[i]);
  lane_rhs(b, runs, t + h, b->y_new, b->k[END]);
  lanes sum[LANES] = {{0}}, size[LANES] = {{0}}; /* LANES sums, as rk45.c has them */
  for (int i = 0; i < N; i++) {
    const lanes error = RK45_E1 * k1[i] + RK45_E3 * k3[i] + RK45_E4 * k4[i] + RK45_E5 * k5[i] +
                        RK45_E6 * k6[i] + RK45_E7 * k7[i];
    const lanes new_size = lane_fabs(b->y_new[i]);
    const lanes ratio = h * error / (atol + rtol * lane_larger(new_size, lane_fabs(y[i])));
    sum[i % LANES] += ratio * ratio;
    size[i % LANES] += new_size;
  }
  const lanes sizes = size[0] + size[1] + size[2] + size[3];
  const lanes error = (sum[0] + sum[1] + sum[2] + sum[3]) / (double)N;
  for (int k = 0; k < LAMC_LANES; k++) squared[k] = is_finite(sizes[k]) ? error[k] : HUGE_VAL;
}

/* ---- What ensemble.c asks for -------------------------------------------------------------------------------- */

static void lane_attempt(lamc_real *block, int which, lamc_run *const *runs, const lamc_real *h,
                         lamc_real *squared) {
  lane_block *b = (lane_block *)(void *)block;
  const lamc_run *any = NULL;
  lanes t = {0}, steps = {0};
  for (int k = 0; k < LAMC_LANES; k++) {
    if (runs[k] == NULL) continue;
    any = runs[k];
    t[k] = runs[k]->t;
    steps[k] = h[k];
    lane_put(b->y, k, y_here(runs[k]));
    lane_put(b->k[BEGIN], k, slope_here(runs[k]));
  }
  if (which == LAMC_DOP853) {
    lane_dop853(b, runs, any, t, steps, squared);
  } else {
    lane_rk45(b, runs, any, t, steps, squared);
  }
  for (int k = 0; k < LAMC_LANES; k++) {
    if (runs[k] == NULL) continue;
    runs[k]->evaluations += which == LAMC_DOP853 ? STAGES : 6;
    lane_take(b->y_new, k, y_there(runs[k]));
    if (which == LAMC_RK45) lane_take(b->k[END], k, slope_there(runs[k]));
  }
}

static void lane_give_stages(const lamc_real *block, int which, int lane, lamc_run *run, int all) {
  const lane_block *b = (const lane_block *)(const void *)block;
  const int count = which == LAMC_DOP853 ? STAGES : 5;
  for (int k = all ? 0 : count - 1; k < count; k++) lane_take(b->k[k], lane, slot(run, SLOT_OWN + k));
  lane_take(b->s, lane, slot(run, SLOT_STAGE));
}

#if HAS_LOOPS
static void lane_settle(lamc_real *block, lamc_run *const *runs, const lamc_real *t, lamc_real *moved,
                        int *done) {
  lane_block *b = (lane_block *)(void *)block;
  lanes at = {0}, way;
  lane_mask wanted = {0};
  for (int k = 0; k < LAMC_LANES; k++) {
    if (runs[k] == NULL) continue;
    at[k] = t[k];
    lane_add(&wanted, k);
  }
  lane_put_series(b, runs, at);
  const lane_mask settled = lane_settle_loops(&b->loops, b->c, at, wanted, b->y_new, &way);
  for (int k = 0; k < LAMC_LANES; k++) {
    done[k] = lane_has(settled, k);
    if (!done[k]) continue;
    moved[k] = way[k];
    lane_take(b->y_new, k, y_there(runs[k]));
    lane_remember((const lamc_motion *)runs[k]->ode.context);
  }
}
#else
#define lane_settle NULL
#endif

const lamc_lane_steps *lamc_this_lanes(void) {
  static const lamc_lane_steps steps = {
      LAMC_LANES,          sizeof(lane_block) / sizeof(lamc_real),
      lane_take_constants, lane_attempt,
      lane_give_stages,    lane_slope,
      lane_dense,          lane_settle,
  };
  return &steps;
}

#endif /* LAMC_LANE_STEPS_H */
