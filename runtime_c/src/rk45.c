/* rk45.c: the explicit Runge-Kutta pair of Dormand and Prince, order 5 with an error estimate of order 4.
 *
 * In:    a lamc_ode, tolerances, output times. Out: rows, counters, a status.
 * Never: keeps anything outside the caller's lamc_rk45 and its work array; loops without counting a step.
 *
 * Starting step and PI step control: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I,
 * 2nd ed. (1993), section II.4, and volume II, section IV.2; the numbers are those of its code DOPRI5, and so are the
 * steps.
 *
 * The error norm is the root mean square over the components, so that a tolerance means what it means in DOPRI5,
 * CVODE and solve_ivp. The largest component instead was measured on pendulum chains of 1, 3 and 6 links: 6, 14 and
 * 24 % more steps for half the energy drift, which a smaller tolerance buys at the same price. */
#include "lamc.h"
#include "rk45_kernels.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

static const double MIN_RTOL = 1e-13;    /* about 500 units of round-off: below, the estimate is noise */
static const double SAFETY = 0.9;        /* aim below the tolerance */
static const double GROW_AT_MOST = 10.0; /* change of the step from one to the next */
static const double SHRINK_AT_MOST = 5.0;
static const double SHRINK_NOT_FINITE = 10.0; /* the step is divided by this after NaN or infinity */
static const double PI_BETA = 0.04;           /* weight of the last error: Hairer's choice for this pair */
static const double PI_ALPHA = 0.2 - 0.04 * 0.75;
static const double LOG_LEAST_ERROR = -9.210340371976182; /* log(1e-4): a lucky step is not trusted further */

/* n rounded up to whole blocks, and one block where n is 0 */
static int padded(int n) {
  return n > 0 ? (n + LANES - 1) / LANES * LANES : LANES;
}

long long lamc_rk45_work_size(int n) {
  if (n < 0 || n > INT_MAX / SLOT_COUNT - LANES) return 0;
  return (long long)SLOT_COUNT * padded(n);
}

const double *lamc_rk45_state(const lamc_rk45 *run) {
  return slot(run, SLOT_Y + run->side);
}

/* ---- One step ---------------------------------------------------------------------------------------------- */

/* Hairer's PI control: the factor by which the step changes after an accepted step with this error. */
static double growth_after(const lamc_rk45 *run, double log_error) {
  const double factor = SAFETY * exp(PI_BETA * run->log_error_old - PI_ALPHA * log_error);
  const double most = run->was_rejected ? 1.0 : GROW_AT_MOST; /* a step just refused would be refused again */
  return smaller(most, larger(1.0 / SHRINK_AT_MOST, factor));
}

static void accept(lamc_rk45 *run, double h, int is_last, double log_error) {
  run->h = smaller(h * growth_after(run, log_error), run->options.max_step);
  run->log_error_old = larger(log_error, LOG_LEAST_ERROR);
  run->t_old = run->t;
  run->t = is_last ? run->t_end : run->t + h;
  run->h_last = h;
  run->side = 1 - run->side;
  run->dense = LAMC_DENSE_POSSIBLE;
  run->row_due = run->t_eval == NULL;
  run->was_rejected = 0;
  run->accepted++;
}

static void reject(lamc_rk45 *run, double h, double log_error) {
  const double factor = run->was_finite ? SAFETY * exp(-PI_ALPHA * log_error) : 1.0 / SHRINK_NOT_FINITE;
  run->h = h * larger(factor, 1.0 / (run->was_finite ? SHRINK_AT_MOST : SHRINK_NOT_FINITE));
  run->was_rejected = 1;
  run->rejected++;
}

/* After an accepted step: the new state brought back to what must hold, and its slope with it. */
static lamc_status settle(lamc_rk45 *run) {
  if (run->ode.settle == NULL) return LAMC_OK;
  double *y = slot(run, SLOT_Y + run->side);
  double moved = 0.0;
  const lamc_status status = run->ode.settle(run->ode.context, run->t, y, &moved);
  if (moved > 0.0) evaluate(run, run->t, y, slot(run, SLOT_SLOPE + run->side));
  return status;
}

/* Tries one step. LAMC_OK if it was accepted, LAMC_PAUSED if it was not and a shorter one should be tried. */
static lamc_status try_step(lamc_rk45 *run) {
  const double rest = run->t_end - run->t;
  const int is_last = 1.01 * run->h >= rest; /* stretched a little, so that no sliver remains */
  const double h = is_last ? rest : (run->t + run->h) - run->t;
  if (!is_last && h <= 16.0 * DBL_EPSILON * fabs(run->t) + DBL_MIN) {
    return run->was_finite ? LAMC_STEP_UNDERFLOW : LAMC_NOT_FINITE;
  }
  if (run->steps >= run->options.max_steps) return LAMC_STEP_LIMIT;
  run->dense = LAMC_DENSE_NONE;
  run->steps++;
  take_stages(run, h);
  const double squared = squared_error(run, h);
  const double log_error = 0.5 * log(squared); /* -infinity at zero error, which the control can take */
  run->was_finite = is_finite(squared);
  if (run->was_finite && squared <= 1.0) {
    accept(run, h, is_last, log_error);
    return settle(run);
  }
  reject(run, h, log_error);
  return LAMC_PAUSED;
}

/* ---- Dense output ------------------------------------------------------------------------------------------ */

lamc_status lamc_rk45_interpolate(lamc_rk45 *run, double t, double *y) {
  if (run == NULL || y == NULL || run->dense == LAMC_DENSE_NONE) return LAMC_BAD_ARGUMENT;
  if (!(t >= run->t_old && t <= run->t)) return LAMC_BAD_ARGUMENT;
  if (t == run->t) { /* the end of a step needs no polynomial, and must not pick up its rounding */
    memcpy(y, lamc_rk45_state(run), (size_t)run->ode.n * sizeof *y);
    return LAMC_OK;
  }
  if (run->dense == LAMC_DENSE_POSSIBLE) make_dense(run);
  const double *r1 = slot(run, SLOT_Y + 1 - run->side);
  const double *r2 = slot(run, SLOT_DENSE);
  const double *r3 = slot(run, SLOT_DENSE + 1);
  const double *r4 = slot(run, SLOT_DENSE + 2);
  const double *r5 = slot(run, SLOT_DENSE + 3);
  const double a = (t - run->t_old) / run->h_last;
  const double b = 1.0 - a;
  for (int i = 0; i < run->ode.n; i++) y[i] = r1[i] + a * (r2[i] + b * (r3[i] + a * (r4[i] + b * r5[i])));
  return LAMC_OK;
}

/* ---- Start ------------------------------------------------------------------------------------------------- */

/* Root mean square of v over the tolerance at y */
static double norm(const lamc_rk45 *run, const double *v, const double *y) {
  double sum = 0.0;
  for (int i = 0; i < run->ode.n; i++) {
    const double ratio = v[i] / (floor_of_scale(run) + run->options.rtol * fabs(y[i]));
    sum += ratio * ratio;
  }
  return run->ode.n > 0 ? sqrt(sum / run->ode.n) : 0.0;
}

/* The first step: Hairer, Norsett, Wanner I, section II.4, algorithm for the starting step size. One evaluation. */
static double choose_first_step(lamc_rk45 *run, double longest) {
  const double *y = slot(run, SLOT_Y + run->side);
  const double *slope = slot(run, SLOT_SLOPE + run->side);
  double *probe = slot(run, SLOT_STAGE);
  double *slope_probe = slot(run, SLOT_K2);
  const double size = norm(run, y, y);
  const double speed = norm(run, slope, y);
  double h = size < 1e-5 || speed < 1e-5 ? 1e-6 : 0.01 * size / speed;
  if (!is_finite(h) || h <= 0.0) h = 1e-6; /* the norms overflow: tiny tolerances or huge slopes */
  h = smaller(h, longest);
  for (int i = 0; i < run->ode.n; i++) probe[i] = y[i] + h * slope[i];
  evaluate(run, run->t + h, probe, slope_probe);
  for (int i = 0; i < run->ode.n; i++) probe[i] = slope_probe[i] - slope[i];
  const double bend = norm(run, probe, y) / h;
  const double most = larger(speed, bend);
  if (!is_finite(speed) || !is_finite(bend)) return h;
  const double h_order = most <= 1e-15 ? larger(1e-6, 1e-3 * h) : pow(0.01 / most, 0.2);
  return smaller(smaller(100.0 * h, h_order), longest);
}

static int is_valid(const lamc_options *o) {
  return o->rtol >= MIN_RTOL && o->rtol <= 1.0 && o->atol >= 0.0 && is_finite(o->atol) &&
         o->first_step >= 0.0 && is_finite(o->first_step) && o->max_step >= 0.0 && is_finite(o->max_step) &&
         o->max_steps > 0;
}

/* 1 if the times ascend within t0 .. t_end */
static int ascends(const double *times, long long count, double t0, double t_end) {
  double last = t0;
  for (long long i = 0; i < count; i++) {
    if (!(times[i] >= last)) return 0;
    last = times[i];
  }
  return last <= t_end;
}

lamc_status lamc_rk45_start(lamc_rk45 *run, const lamc_ode *ode, const lamc_options *options, double t0,
                            const double *y0, double t_end, const double *t_eval, long long t_eval_count,
                            double *work) {
  if (run == NULL) return LAMC_BAD_ARGUMENT;
  memset(run, 0, sizeof *run);
  run->status = LAMC_BAD_ARGUMENT;
  if (ode == NULL || ode->rhs == NULL || options == NULL || y0 == NULL || work == NULL) return run->status;
  if (lamc_rk45_work_size(ode->n) == 0) return run->status;
  if (!is_valid(options) || !is_finite(t0) || !is_finite(t_end) || t_end < t0) return run->status;
  if (t_eval_count < 0 || (t_eval != NULL && !ascends(t_eval, t_eval_count, t0, t_end))) return run->status;

  run->ode = *ode;
  run->options = *options;
  if (run->options.max_step == 0.0) run->options.max_step = DBL_MAX;
  run->t = run->t_old = t0;
  run->t_end = t_end;
  run->t_eval = t_eval;
  run->t_eval_count = t_eval == NULL ? 0 : t_eval_count;
  run->log_error_old = LOG_LEAST_ERROR;
  run->stride = padded(ode->n);
  run->row_due = t_eval == NULL;
  run->was_finite = 1;
  run->work = work;
  memset(work, 0, (size_t)lamc_rk45_work_size(ode->n) * sizeof *work);
  memcpy(slot(run, SLOT_Y), y0, (size_t)ode->n * sizeof *y0);

  run->status = LAMC_NOT_FINITE;
  double *slope = slot(run, SLOT_SLOPE);
  evaluate(run, t0, slot(run, SLOT_Y), slope);
  for (int i = 0; i < ode->n; i++)
    if (!is_finite(y0[i]) || !is_finite(slope[i])) return run->status;
  const double longest = smaller(t_end - t0, run->options.max_step);
  if (longest > 0.0) {
    run->h =
        options->first_step > 0.0 ? smaller(options->first_step, longest) : choose_first_step(run, longest);
  }
  run->status = LAMC_PAUSED;
  return LAMC_OK;
}

/* ---- Running ----------------------------------------------------------------------------------------------- */

/* Room for the next row: its y, with its t set; NULL when the rows are full */
static double *next_row(lamc_rows *rows, int n, double t) {
  if (rows->count >= rows->capacity) return NULL;
  double *y = rows->y + rows->count * n;
  rows->t[rows->count++] = t;
  return y;
}

/* Writes the rows that are due at or before t. LAMC_OK, or LAMC_OUTPUT_FULL where some remain. */
static lamc_status write_rows(lamc_rk45 *run, lamc_rows *rows) {
  const int n = run->ode.n;
  if (run->row_due) {
    double *y = next_row(rows, n, run->t);
    if (y == NULL) return LAMC_OUTPUT_FULL;
    memcpy(y, lamc_rk45_state(run), (size_t)n * sizeof *y);
    run->row_due = 0;
  }
  while (run->t_eval_next < run->t_eval_count && run->t_eval[run->t_eval_next] <= run->t) {
    const double t = run->t_eval[run->t_eval_next];
    double *y = next_row(rows, n, t);
    if (y == NULL) return LAMC_OUTPUT_FULL;
    if (t == run->t) {
      memcpy(y, lamc_rk45_state(run), (size_t)n * sizeof *y);
    } else {
      (void)lamc_rk45_interpolate(run, t, y); /* cannot fail: a row before t lies in the step just accepted */
      double moved = 0.0; /* between the ends of a step the polynomial strays from closure by the tolerance */
      const lamc_status settled =
          run->ode.settle == NULL ? LAMC_OK : run->ode.settle(run->ode.context, t, y, &moved);
      if (settled != LAMC_OK) {
        rows->count--; /* a row that does not close is no result */
        return settled;
      }
    }
    run->t_eval_next++;
  }
  return LAMC_OK;
}

lamc_status lamc_rk45_advance(lamc_rk45 *run, lamc_rows *rows, long long budget, const volatile int *cancel) {
  if (run == NULL || rows == NULL || budget < 0) return LAMC_BAD_ARGUMENT;
  if (rows->t == NULL || rows->y == NULL || rows->capacity <= 0 || rows->count < 0) return LAMC_BAD_ARGUMENT;
  if (run->status < 0) return run->status;
  const long long evaluations_end = budget > 0 ? run->evaluations + budget : LLONG_MAX;
  for (;;) {
    run->status = write_rows(run, rows);
    if (run->status != LAMC_OK || run->t >= run->t_end) return run->status;
    do {
      run->status = LAMC_PAUSED;
      if (cancel != NULL && *cancel) return run->status = LAMC_CANCELLED;
      if (run->evaluations >= evaluations_end) return run->status;
      run->status = try_step(run);
      if (run->status < 0) return run->status;
    } while (run->status == LAMC_PAUSED);
  }
}
