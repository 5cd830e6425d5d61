/* lane_slopes.h, of lamc: the memory of several runs side by side, and dy/dt of all of them.
 *
 * In:    states and times in lanes, and the runs that these are of. Out: dy/dt, with the bits of each motion by itself.
 * Never: takes a step. */
#ifndef LAMC_LANE_SLOPES_H
#define LAMC_LANE_SLOPES_H

#include "lane_numbers.h"
#include "lanes.h"
#include "series.h"
#if HAS_LOOPS
#include "lane_loops.h"
#endif

enum {
  N = NQ + NU,
  STAGES = 11, /* slopes between the ends of a step: 2 to 12 of DOP853, 2 to 6 of RK45 */
  BEGIN = 11,  /* in `k`: the slope where the step begins */
  END = 12,    /* where it leads; three more of DOP853's continuous extension */
  SLOPES = 16,
  SERIES = SERIES_COUNT * LAMC_SERIES_ORDERS /* constants that inputs over time have */
};

typedef struct lane_block {
  lanes c[NC > 0 ? NC : 1];
  lanes y[N + 1], y_new[N + 1];
  lanes k[SLOPES][N + 1];
  lanes s[N + 1]; /* argument of the stage being evaluated */
#if HAS_SYSTEM
  lanes raw[NU * (NU + 1) / 2 + NU + 1], l[NU * NU + 1];
#endif
#if HAS_LOOPS
  lane_loops loops;
#endif
} lane_block;

#if HAS_SYSTEM
/* M = L L^T, as cholesky.h has it, and the solution of M x = f in place of f */
static void lane_solve(const lanes *m, lanes *l, lanes *x) {
  for (int i = 0; i < NU; i++) {
    for (int j = 0; j <= i; j++) {
      lanes sum = {0};
      for (int n = 0; n < j; n++) sum += l[i * NU + n] * l[j * NU + n];
      const lanes rest = m[j] - sum;
      l[i * NU + j] = j == i ? 1 / lane_sqrt(rest) : rest * l[j * NU + j];
    }
    m += i + 1;
  }
  for (int i = 0; i < NU; i++) {
    lanes sum = {0};
    for (int n = 0; n < i; n++) sum += l[i * NU + n] * x[n];
    x[i] = (x[i] - sum) * l[i * NU + i];
  }
  for (int i = NU - 1; i >= 0; i--) {
    lanes sum = x[i];
    for (int n = i + 1; n < NU; n++) sum -= l[n * NU + i] * x[n];
    x[i] = sum * l[i * NU + i];
  }
}
#endif

/* What inputs that follow a series are at the time of each lane, into its constants */
LAMC_LANE_FUNCTION void lane_put_series(lane_block *b, lamc_run *const *runs, lanes t) {
  for (int k = 0; SERIES > 0 && k < LAMC_LANES; k++) {
    if (runs[k] == NULL) continue;
    const lamc_motion *motion = (const lamc_motion *)runs[k]->ode.context;
    lamc_series_put(motion, t[k]);
    for (int i = 0; i < SERIES; i++) b->c[i][k] = motion->constants[i];
  }
}

/* dy/dt of every lane that has a run; the lanes where it is to be had from the run alone */
static lane_mask lane_try_rhs(lane_block *b, lamc_run *const *runs, lanes t, const lanes *y, lanes *dydt) {
  lane_mask odd = {0};
#if HAS_RATES
  lane_rates(b->c, y, y + NQ, dydt);
#else
  for (int i = 0; i < NU; i++) dydt[i] = y[NQ + i];
#endif
  lane_put_series(b, runs, t);
#if HAS_LOOPS
  lane_mask busy = {0}, settled;
  for (int k = 0; k < LAMC_LANES; k++) {
    if (runs[k] != NULL) lane_add(&busy, k);
  }
  odd = lane_accelerate(&b->loops, b->c, t, y, busy, dydt + NQ, &settled);
  for (int k = 0; k < LAMC_LANES && lane_some(settled); k++) {
    if (lane_has(settled, k) && !lane_has(odd, k)) lane_remember((const lamc_motion *)runs[k]->ode.context);
  }
#elif HAS_SYSTEM
  lane_system(b->c, t, y, y + NQ, b->raw);
  lane_solve(b->raw, b->l, b->raw + NU * (NU + 1) / 2);
  for (int i = 0; i < NU; i++) dydt[NQ + i] = b->raw[NU * (NU + 1) / 2 + i];
#else
  lane_acceleration(b->c, t, y, y + NQ, dydt + NQ);
#endif
  return odd;
}

/* dy/dt of every lane that has a run */
static void lane_rhs(lane_block *b, lamc_run *const *runs, lanes t, const lanes *y, lanes *dydt) {
  const lane_mask odd = lane_try_rhs(b, runs, t, y, dydt);
  if (!lane_some(odd)) return;
  for (int k = 0; k < LAMC_LANES; k++) {
    lamc_real own[N + 1], slope[N + 1];
    if (!lane_has(odd, k)) continue;
    for (int i = 0; i < N; i++) own[i] = y[i][k];
    runs[k]->ode.rhs(runs[k]->ode.context, t[k], own, slope);
    for (int i = 0; i < N; i++) dydt[i][k] = slope[i];
  }
}

#endif /* LAMC_LANE_SLOPES_H */
