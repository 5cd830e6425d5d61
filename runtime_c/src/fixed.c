/* fixed.c, of lamc: steps of a length that the caller chooses, for a bounded cost per step.
 *
 * In: a lamc_ode, a state, a step. Out: the state at its end. Never: tries a step again, or looks at its error.
 *
 * The classical Runge-Kutta method: W. Kutta, Z. Math. Phys. 46 (1901) 435-453. Four evaluations, stable for h times
 * eigenvalue up to 2.8: of the methods of order 4 and more, none takes fewer. Beyond, stiff.c. */
#include "fixed.h"

static const lamc_real BESIDE = LAMC_R(1e-6); /* of a step: a break so near to its end is there */

long long lamc_fixed_guards(const lamc_ode *ode) {
  return 2LL * ode->guard_count;
}

long long lamc_fixed_scratch(const lamc_ode *ode) {
  const long long guards = lamc_fixed_guards(ode);
  return 3LL * ode->n + (guards > 0 ? guards : 1); /* one: also where nothing moves */
}

/* Events of the guards that are positive at the end of the step, together: switches, and impacts that still go on */
static lamc_status meet(const lamc_ode *ode, lamc_real t, lamc_real *y, lamc_real *guards) {
  int met = 0;
  ode->guards(ode->context, t, y, guards);
  for (int g = 0; g < ode->guard_count; g++) {
    const int is_struck = guards[g] > 0 && guards[ode->guard_count + g] > 0;
    guards[g] = is_struck ? 1 : 0;
    met += is_struck;
  }
  return met > 0 ? ode->event(ode->context, t, y, guards) : LAMC_OK;
}

void lamc_fixed_review(const lamc_ode *ode, lamc_real t, const lamc_real *y) {
  if (ode->guard_count > 0 && ode->review != NULL) ode->review(ode->context, t, y);
}

lamc_status lamc_fixed_end(const lamc_ode *ode, lamc_real t, lamc_real *y, lamc_real *guards) {
  lamc_real moved = 0;
  const lamc_status status = ode->settle == NULL ? LAMC_OK : ode->settle(ode->context, t, y, &moved);
  return status == LAMC_OK && ode->guard_count > 0 ? meet(ode, t, y, guards) : status;
}

lamc_real lamc_fixed_begin(const lamc_ode *ode, lamc_real t, lamc_real h) {
  if (ode->pass == NULL || !(h > 0)) return t;
  const lamc_real near = BESIDE * h + 4 * LAMC_EPSILON * fabs(t); /* steps are counted up with round-off */
  long long low = 0, high = ode->break_count;
  while (low < high) {
    const long long middle = low + (high - low) / 2;
    if (ode->breaks[middle] > t + near) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  const int is_end = low < ode->break_count && fabs(ode->breaks[low] - (t + h)) <= near;
  ode->pass(ode->context, is_end ? low : ode->break_count);
  const lamc_real before = low > 0 ? ode->breaks[low - 1] : t;
  return before > t ? before : t;
}

lamc_status lamc_fixed_step(const lamc_ode *ode, lamc_real t, lamc_real h, lamc_real *y, lamc_real *scratch) {
  const int n = ode->n;
  const lamc_real begin = lamc_fixed_begin(ode, t, h);
  lamc_real *slope = scratch, *stage = slope + n, *sum = stage + n, *guards = sum + n;
  lamc_real size = 0, slopes = 0;
  lamc_fixed_review(ode, begin, y);
  ode->rhs(ode->context, begin, y, slope);
  for (int i = 0; i < n; i++) {
    sum[i] = slope[i];
    stage[i] = y[i] + LAMC_R(0.5) * h * slope[i];
    slopes += fabs(slope[i]);
  }
  if (!is_finite(slopes)) return LAMC_NOT_FINITE;
  for (int middle = 0; middle < 2; middle++) {
    ode->rhs(ode->context, t + LAMC_R(0.5) * h, stage, slope);
    for (int i = 0; i < n; i++) {
      sum[i] += 2 * slope[i];
      stage[i] = y[i] + (middle == 0 ? LAMC_R(0.5) * h : h) * slope[i];
    }
  }
  ode->rhs(ode->context, t + h, stage, slope);
  for (int i = 0; i < n; i++) {
    y[i] += h / 6 * (sum[i] + slope[i]);
    size += fabs(y[i]);
  }
  if (!is_finite(size)) return LAMC_NOT_FINITE;
  return lamc_fixed_end(ode, t + h, y, guards);
}
