/* linearise.c, of lamc: derivatives of the accelerations by coordinates, rates and time.
 *
 * In the residual form: with r = M udot - f - J^T lambda and c = J udot + gamma, both zero along the motion, d(udot) follows
 * from M d(udot) = J^T d(lambda) - dr, J d(udot) = -dc, where r and c are differentiated at constant udot and lambda: the
 * same linear system as that of the accelerations, and no derivative of an inverse. Where the model does not bring these
 * derivatives, and under Baumgarte's stabilisation, whose terms they lack, forward differences are taken. */
#include "linearise.h"

#include "cholesky.h"
#include "loops.h"
#include "motion.h"
#include "series.h"
#include "system.h"
#include "tolerances.h"

#include <math.h>
#include <string.h>

static long long triangle(long long n) {
  return n * (n + 1) / 2;
}

/* Numbers of the analytic form up to the derivatives, which a full Jacobian reads once more */
static long long before_derivatives(const lamc_model *model) {
  return (long long)model->rate_count + model->closure_count;
}

long long lamc_linearise_scratch(const lamc_model *model) {
  const long long n = model->rate_count, nq = model->coordinate_count, m = model->closure_count;
  const long long full = model->rates == NULL ? 0 : n * (nq + n) + n; /* by_q, by_u, by_t */
  const long long differences = nq + n + 2 * (nq > n ? nq : n);
  const long long flow = model->rates == NULL ? 0 : nq * (nq + n); /* derivatives of dq/dt */
  const long long analytic =
      before_derivatives(model) + (n + m) * (nq + n + 1) + flow + n * n + triangle(n) + n + m;
  return full + (model->jacobian == NULL || analytic < differences ? differences : analytic);
}

/* 1 if the derivatives are those of the accelerations that the run takes */
static int is_analytic(const lamc_motion *motion) {
  return motion->model->jacobian != NULL && motion->baumgarte == 0;
}

lamc_real lamc_linearise_cost(const lamc_motion *motion) {
  const lamc_model *model = motion->model;
  return is_analytic(motion) ? model->jacobian_cost + 1
                             : (lamc_real)(model->coordinate_count + model->rate_count) + 2;
}

static lamc_real step_from(lamc_real x) {
  return x + sqrt(LAMC_EPSILON) * fmax(LAMC_R(1.0), fabs(x));
}

static void by_differences(const lamc_motion *motion, lamc_real t, const lamc_real *y, lamc_real *by_q,
                           lamc_real *by_u, lamc_real *by_t, lamc_real *scratch) {
  const int n = motion->model->rate_count, nq = motion->model->coordinate_count;
  lamc_real *moved = scratch, *base = moved + nq + n, *there = base + n;
  lamc_motion_accelerate(motion, t, y, y + nq, base);
  memcpy(moved, y, (size_t)(nq + n) * sizeof *moved);
  for (int j = 0; j < nq + n; j++) {
    lamc_real *out = j < nq ? by_q + j : by_u + (j - nq);
    const int width = j < nq ? nq : n;
    moved[j] = step_from(y[j]);
    lamc_motion_accelerate(motion, t, moved, moved + nq, there);
    for (int i = 0; i < n; i++) out[(ptrdiff_t)i * width] = (there[i] - base[i]) / (moved[j] - y[j]);
    moved[j] = y[j];
  }
  const lamc_real later =
      t + sqrt(LAMC_EPSILON) *
              fmax(LAMC_R(1e-3), fabs(t)); /* a millisecond where t is zero: torques change no faster */
  lamc_motion_accelerate(motion, later, y, y + nq, there);
  for (int i = 0; i < n; i++) by_t[i] = (there[i] - base[i]) / (later - t);
}

/* M d(udot) = J^T d(lambda) - dr, column by column, with the factors that the acceleration left */
static void respond(const lamc_motion *motion, int count, const lamc_real *l, lamc_real *x,
                    const lamc_real *goal) {
  const lamc_model *model = motion->model;
  if (model->cut_count > 0) {
    lamc_loops_response(motion, count, goal, x);
  } else if (lamc_is_system(model)) {
    lamc_system_response(motion, x);
  } else {
    lamc_solve_lower(model->rate_count, l, x);
    lamc_solve_upper(model->rate_count, l, x);
  }
}

static void by_residuals(const lamc_motion *motion, lamc_real t, const lamc_real *y, lamc_real *by_q,
                         lamc_real *by_u, lamc_real *by_t, lamc_real *scratch) {
  const lamc_model *model = motion->model;
  const int n = model->rate_count, nq = model->coordinate_count, m = model->closure_count;
  const int columns = nq + n + 1;
  const ptrdiff_t flow = model->rates == NULL ? 0 : (ptrdiff_t)nq * (nq + n);
  lamc_real *udot = scratch, *lambda = udot + n, *derivative = lambda + m;
  lamc_real *l = derivative + (ptrdiff_t)(n + m) * columns + flow;
  lamc_real *inertia = l + (ptrdiff_t)n * n, *x = inertia + triangle(n), *goal = x + n;
  int count = 0;
  lamc_series_put(motion, t);
  if (model->cut_count > 0) {
    count = lamc_loops_acceleration(motion, t, y, y + nq, udot, lambda);
  } else {
    lamc_motion_accelerate(motion, t, y, y + nq, udot);
    if (!lamc_is_system(model)) {
      model->inertia(motion->constants, y, inertia);
      lamc_cholesky(n, inertia, l);
    }
  }
  model->jacobian(motion->constants, t, y, y + nq, udot, lambda, derivative);
  for (int j = 0; j < columns; j++) {
    for (int i = 0; i < n; i++) x[i] = -derivative[(ptrdiff_t)i * columns + j];
    for (int i = 0; i < m; i++) goal[i] = derivative[(ptrdiff_t)(n + i) * columns + j];
    respond(motion, count, l, x, goal);
    for (int i = 0; i < n; i++) {
      if (j < nq) {
        by_q[(ptrdiff_t)i * nq + j] = x[i];
      } else if (j < nq + n) {
        by_u[(ptrdiff_t)i * n + (j - nq)] = x[i];
      } else {
        by_t[i] = x[i];
      }
    }
  }
}

void lamc_linearise(const void *context, lamc_real t, const lamc_real *y, lamc_real *by_q, lamc_real *by_u,
                    lamc_real *by_t, lamc_real *scratch) {
  const lamc_motion *motion = (const lamc_motion *)context;
  if (is_analytic(motion)) {
    by_residuals(motion, t, y, by_q, by_u, by_t, scratch);
  } else {
    by_differences(motion, t, y, by_q, by_u, by_t, scratch);
  }
}

/* Rows of by_y for dq/dt, by differences; scratch (nq + nu + 2 nq,) */
static void rates_by_differences(const lamc_motion *motion, const lamc_real *y, lamc_real *by_y,
                                 lamc_real *scratch) {
  const int n = motion->model->rate_count, nq = motion->model->coordinate_count;
  lamc_real *moved = scratch, *base = moved + nq + n, *there = base + nq;
  lamc_motion_rates(motion, y, y + nq, base);
  memcpy(moved, y, (size_t)(nq + n) * sizeof *moved);
  for (int j = 0; j < nq + n; j++) {
    moved[j] = step_from(y[j]);
    lamc_motion_rates(motion, moved, moved + nq, there);
    for (int i = 0; i < nq; i++) by_y[(ptrdiff_t)i * (nq + n) + j] = (there[i] - base[i]) / (moved[j] - y[j]);
    moved[j] = y[j];
  }
}

void lamc_linearise_fully(const void *context, lamc_real t, const lamc_real *y, lamc_real *by_y,
                          lamc_real *by_t, lamc_real *scratch) {
  const lamc_motion *motion = (const lamc_motion *)context;
  const lamc_model *model = motion->model;
  const int n = model->rate_count, nq = model->coordinate_count, size = nq + n;
  lamc_real *by_q = scratch, *by_u = by_q + (ptrdiff_t)n * nq, *late = by_u + (ptrdiff_t)n * n,
            *rest = late + n;
  lamc_linearise(context, t, y, by_q, by_u, late, rest);
  if (is_analytic(motion)) {
    const lamc_real *derivative = rest + before_derivatives(model);
    const lamc_real *flow = derivative + (ptrdiff_t)(n + model->closure_count) * (size + 1);
    memcpy(by_y, flow, (size_t)nq * (size_t)size * sizeof *by_y);
  } else {
    rates_by_differences(motion, y, by_y, rest);
  }
  for (int i = 0; i < n; i++) {
    lamc_real *row = by_y + (ptrdiff_t)(nq + i) * size;
    memcpy(row, by_q + (ptrdiff_t)i * nq, (size_t)nq * sizeof *row);
    memcpy(row + nq, by_u + (ptrdiff_t)i * n, (size_t)n * sizeof *row);
  }
  for (int i = 0; i < nq; i++) by_t[i] = 0;
  memcpy(by_t + nq, late, (size_t)n * sizeof *by_t);
}
