/* linearise.c, of lamc: derivatives of the accelerations by angles, rates and time.
 *
 * In the residual form: with r = M udot - f - J^T lambda and c = J udot + gamma, both zero along the motion, d(udot) follows
 * from M d(udot) = J^T d(lambda) - dr, J d(udot) = -dc, where r and c are differentiated at constant udot and lambda: the
 * same linear system as that of the accelerations, and no derivative of an inverse. Where the model does not bring these
 * derivatives, and under Baumgarte's stabilisation, whose terms they lack, forward differences are taken. */
#include "linearise.h"

#include "cholesky.h"
#include "loops.h"

#include <float.h>
#include <math.h>
#include <string.h>

static long long triangle(long long n) {
  return n * (n + 1) / 2;
}

long long lamc_linearise_scratch(const lamc_model *model) {
  const long long n = model->joint_count, m = model->closure_count;
  if (model->jacobian == NULL) return 4 * n;
  return n + m + (n + m) * (2 * n + 1) + n * n + triangle(n) + n + m;
}

/* 1 if the derivatives are those of the accelerations that the run takes */
static int is_analytic(const lamc_motion *motion) {
  return motion->model->jacobian != NULL && motion->baumgarte == 0.0;
}

double lamc_linearise_cost(const lamc_motion *motion) {
  const lamc_model *model = motion->model;
  return is_analytic(motion) ? model->jacobian_cost + 1.0 : 2.0 * model->joint_count + 2.0;
}

static void accelerate(const lamc_motion *motion, double t, const double *q, const double *u, double *udot) {
  if (motion->model->cut_count == 0) {
    motion->model->acceleration(motion->constants, t, q, u, udot);
  } else {
    (void)lamc_loops_acceleration(motion, t, q, u, udot, NULL);
  }
}

static void by_differences(const lamc_motion *motion, double t, const double *y, double *by_q, double *by_u,
                           double *by_t, double *scratch) {
  const int n = motion->model->joint_count;
  double *moved = scratch, *base = moved + 2 * n, *there = base + n;
  const double part = sqrt(DBL_EPSILON);
  accelerate(motion, t, y, y + n, base);
  memcpy(moved, y, 2 * (size_t)n * sizeof *moved);
  for (int j = 0; j < 2 * n; j++) {
    double *out = j < n ? by_q + j : by_u + (j - n);
    const double step = part * fmax(1.0, fabs(y[j]));
    moved[j] = y[j] + step;
    accelerate(motion, t, moved, moved + n, there);
    for (int i = 0; i < n; i++) out[i * n] = (there[i] - base[i]) / (moved[j] - y[j]);
    moved[j] = y[j];
  }
  const double later =
      t + part * fmax(1e-3, fabs(t)); /* a millisecond where t is zero: torques change no faster */
  accelerate(motion, later, y, y + n, there);
  for (int i = 0; i < n; i++) by_t[i] = (there[i] - base[i]) / (later - t);
}

void lamc_linearise(const void *context, double t, const double *y, double *by_q, double *by_u, double *by_t,
                    double *scratch) {
  const lamc_motion *motion = (const lamc_motion *)context;
  const lamc_model *model = motion->model;
  const int n = model->joint_count, m = model->closure_count, columns = 2 * n + 1;
  if (!is_analytic(motion)) {
    by_differences(motion, t, y, by_q, by_u, by_t, scratch);
    return;
  }
  const ptrdiff_t entries = (ptrdiff_t)(n + m) * columns;
  double *udot = scratch, *lambda = udot + n, *derivative = lambda + m, *l = derivative + entries;
  double *inertia = l + (ptrdiff_t)n * n, *x = inertia + triangle(n), *goal = x + n;
  int count = 0;
  if (model->cut_count == 0) {
    model->acceleration(motion->constants, t, y, y + n, udot);
    model->inertia(motion->constants, y, inertia);
    lamc_cholesky(n, inertia, l);
  } else {
    count = lamc_loops_acceleration(motion, t, y, y + n, udot, lambda);
  }
  model->jacobian(motion->constants, t, y, y + n, udot, lambda, derivative);
  for (int j = 0; j < columns; j++) {
    for (int i = 0; i < n; i++) x[i] = -derivative[(ptrdiff_t)i * columns + j];
    for (int i = 0; i < m; i++) goal[i] = derivative[(ptrdiff_t)(n + i) * columns + j];
    if (model->cut_count == 0) {
      lamc_solve_lower(n, l, x);
      lamc_solve_upper(n, l, x);
    } else {
      lamc_loops_response(motion, count, goal, x);
    }
    double *out = j < n ? by_q + j : by_u + (j - n);
    for (int i = 0; i < n; i++) *(j < 2 * n ? out + (ptrdiff_t)i * n : by_t + i) = x[i];
  }
}
