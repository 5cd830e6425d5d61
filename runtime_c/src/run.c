/* run.c, of lamc: a run of any method from its start to its end: steps, output rows, events.
 *
 * In:    a lamc_ode, tolerances, output times. Out: rows, counters, a status.
 * Never: keeps anything outside the caller's lamc_run and its work array; loops without counting a step.
 *
 * Starting step and PI step control: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I,
 * 2nd ed. (1993), section II.4, and volume II, section IV.2.
 *
 * The error norm is the root mean square over the components, so that a tolerance means what it means in DOPRI5,
 * CVODE and solve_ivp. The largest component instead was measured on pendulum chains of 1, 3 and 6 links: 6, 14 and
 * 24 % more steps for half the energy drift, which a smaller tolerance buys at the same price. */
#include "control.h"
#include "events.h"
#include "integrals.h"
#include "rows.h"
#include "steps.h"
#include "watch.h"

#include <limits.h>

#ifdef LAMC_REAL_FLOAT
#error "steps that control their error need doubles"
#endif

static const lamc_real MIN_RTOL = 1e-13; /* about 500 units of round-off: below, the estimate is noise */
static const lamc_real SAFETY = 0.9;     /* aim below the tolerance */
static const lamc_real SHRINK_AT_MOST = 5.0;
static const lamc_real SHRINK_NOT_FINITE =
    10.0; /* the step is divided by this after NaN, infinity or lost closure */
static const lamc_real LOG_LEAST_ERROR =
    -13.287712379549449; /* log2(1e-4): a lucky step is not trusted further */

static const method *const METHODS[] = {NULL, LAMC_METHODS};

enum { METHOD_COUNT = sizeof METHODS / sizeof METHODS[0] }; /* LAMC_AUTO among them */

const method *lamc_method_of(int which) {
  return METHODS[which];
}

/* Numbers for one method; 0 if it cannot run */
static long long size_for(const lamc_ode *ode, const method *m) {
  const long long extra = m->extra == NULL ? 0 : m->extra(ode);
  if (m->extra != NULL && extra == 0) return 0;
  return (long long)(SLOT_OWN + m->slots) * padded(ode->n) + extra;
}

/* Numbers before those of events and integrals */
static long long size_of_methods(const lamc_ode *ode, lamc_method which) {
  if (which != LAMC_AUTO) return size_for(ode, METHODS[which]);
  long long most = 0;
  for (int i = 1; i < METHOD_COUNT; i++) {
    /* Exports link what `auto` takes, and no other */
    const long long size = METHODS[i] == NULL ? 0 : size_for(ode, METHODS[i]);
    if (size > most) most = size;
  }
  return most;
}

long long lamc_run_work_size(const lamc_ode *ode, lamc_method which) {
  if (ode == NULL || (int)which < LAMC_AUTO || (int)which >= METHOD_COUNT) return 0;
  if (ode->n < 0 || ode->n > INT_MAX / 64 - LANES || ode->guard_count < 0 || ode->scratch_size < 0) return 0;
  if (ode->coordinate_count < 0 || ode->coordinate_count > ode->n || ode->integral_count < 0) return 0;
  const long long size = size_of_methods(ode, which);
  return size == 0 ? 0 : size + lamc_events_size(ode) + lamc_integrals_size(ode);
}

const lamc_real *lamc_run_state(const lamc_run *run) {
  return y_here(run);
}

/* ---- One step ---------------------------------------------------------------------------------------------- */

/* Hairer's PI control: the factor by which the step changes after an accepted step with this error. */
static lamc_real growth_after(const lamc_run *run, const method *m, lamc_real log_error) {
  const lamc_real factor = SAFETY * lamc_control_exp2(m->beta * run->log_error_old - m->alpha * log_error);
  const lamc_real most =
      run->was_rejected ? 1.0 : m->grow_at_most; /* a step just refused would be refused again */
  return smaller(most, larger(1.0 / SHRINK_AT_MOST, factor));
}

/* The new state becomes the present one. */
static void move_on(lamc_run *run, lamc_real t, lamc_real h) {
  run->t_old = run->t;
  run->t = t;
  run->h_last = h;
  run->side = 1 - run->side;
  run->dense = LAMC_DENSE_POSSIBLE;
}

void lamc_run_move_back(lamc_run *run) {
  run->t = run->t_old;
  run->side = 1 - run->side;
  run->dense = LAMC_DENSE_NONE;
}

static void reject(lamc_run *run, lamc_real h, lamc_real factor, lamc_real least) {
  run->h = h * larger(factor, least);
  run->was_rejected = 1;
  run->rejected++;
}

lamc_real lamc_run_stop(const lamc_run *run) {
  if (run->next_break >= run->ode.break_count) return run->t_end;
  return smaller(run->ode.breaks[run->next_break], run->t_end);
}

lamc_status lamc_run_land(lamc_run *run, lamc_real h, int is_last, lamc_real squared, int *wants_slope) {
  run->was_finite = is_finite(squared);
  if (!run->was_finite || squared > 1.0) return LAMC_PAUSED;
  move_on(run, is_last ? lamc_run_stop(run) : run->t + h, h);
  lamc_real moved = 0.0;
  lamc_status settled = LAMC_OK;
  if (run->ode.settle != NULL) settled = run->ode.settle(run->ode.context, run->t, y_here(run), &moved);
  run->was_closed = settled != LAMC_CLOSURE_LOST;
  if (!run->was_closed) {
    lamc_run_move_back(run);
    return LAMC_PAUSED;
  }
  *wants_slope = moved > 0.0 || !METHODS[run->method]->gives_slope;
  return settled;
}

lamc_status lamc_run_stand(lamc_run *run) {
  run->was_finite = all_finite(run, slope_here(run));
  if (run->was_finite) return LAMC_OK;
  lamc_run_move_back(run);
  return LAMC_PAUSED;
}

lamc_status lamc_run_take(lamc_run *run, lamc_real h, int is_last, lamc_real *squared) {
  int wants_slope;
  run->dense = LAMC_DENSE_NONE;
  run->steps++;
  *squared = METHODS[run->method]->attempt(run, h);
  const lamc_status landed = lamc_run_land(run, h, is_last, *squared, &wants_slope);
  if (landed != LAMC_OK) return landed;
  if (wants_slope) evaluate(run, run->t, y_here(run), slope_here(run));
  return lamc_run_stand(run);
}

/* What follows from a step that holds. */
static void accept(lamc_run *run, const method *m, lamc_real h, lamc_real log_error) {
  run->h = smaller(h * growth_after(run, m, log_error), run->options.max_step);
  run->log_error_old = larger(log_error, LOG_LEAST_ERROR);
  run->row_due = run->t_eval == NULL;
  run->was_rejected = 0;
  run->has_jacobian = 0;
  run->may_pass = 0;
  run->accepted++;
  if (m->keeps_dense) {
    m->make_dense(run);
    run->dense = LAMC_DENSE_READY;
  }
}

lamc_status lamc_run_next(lamc_run *run, lamc_real *h, int *is_last) {
  lamc_watch_switch(run);
  const lamc_real stop = lamc_run_stop(run), rest = stop - run->t;
  *is_last = 1.01 * run->h >= rest;                  /* stretched a little, so that no sliver remains */
  *h = *is_last ? rest : (run->t + run->h) - run->t; /* what t really moves by */
  run->h_free = *is_last && stop < run->t_end ? run->h : 0.0;
  if (!*is_last && *h <= 16.0 * LAMC_EPSILON * fabs(run->t) + LAMC_LEAST) {
    if (!run->was_closed) return LAMC_CLOSURE_LOST;
    return run->was_finite ? LAMC_STEP_UNDERFLOW : LAMC_NOT_FINITE;
  }
  return run->steps >= run->options.max_steps ? LAMC_STEP_LIMIT : LAMC_OK;
}

static int is_at_break(const lamc_run *run) {
  return run->next_break < run->ode.break_count && run->t >= run->ode.breaks[run->next_break];
}

/* The first break behind the time where the run stands comes next. */
static void find_break(lamc_run *run) {
  const lamc_ode *ode = &run->ode;
  long long low = 0, high = ode->break_count;
  while (low < high) {
    const long long middle = low + (high - low) / 2;
    if (ode->breaks[middle] > run->t) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  run->next_break = low;
  if (ode->pass != NULL) ode->pass(ode->context, low);
}

/* After a step that ended at a break: the next one sees what follows. What is still asked for within the step must not, so
 * its continuous extension is made now. Steps go on as long as they were before the break cut one short. */
static lamc_status pass_break(lamc_run *run) {
  if (run->dense == LAMC_DENSE_POSSIBLE) {
    const long long before = run->evaluations;
    const lamc_real work = lamc_watch_work(run);
    METHODS[run->method]->make_dense(run);
    run->dense = LAMC_DENSE_READY;
    run->watch.mark_cost += (lamc_real)(run->evaluations - before); /* it must not sway LAMC_AUTO */
    lamc_watch_forget(run, work);
  }
  find_break(run);
  run->has_jacobian = run->has_polynomial = 0;
  run->log_error_old = LOG_LEAST_ERROR;
  run->h = smaller(larger(run->h, run->h_free), run->options.max_step);
  evaluate(run, run->t, y_here(run), slope_here(run));
  if (!all_finite(run, slope_here(run))) return LAMC_NOT_FINITE;
  return lamc_events_at_break(run);
}

lamc_status lamc_run_conclude(lamc_run *run, lamc_status taken, lamc_real h, lamc_real squared) {
  const method *m = METHODS[run->method];
  const lamc_real log_error = 0.5 * lamc_control_log2(squared);
  if (taken == LAMC_PAUSED) {
    if (run->was_finite && run->was_closed) {
      reject(run, h, SAFETY * lamc_control_exp2(-m->alpha * log_error), 1.0 / SHRINK_AT_MOST);
    } else {
      reject(run, h, 0.0, 1.0 / SHRINK_NOT_FINITE);
    }
    return LAMC_PAUSED;
  }
  if (taken != LAMC_OK) return taken;
  accept(run, m, h, log_error);
  lamc_status status = run->ode.judge == NULL ? LAMC_OK : run->ode.judge(run->ode.context);
  if (status == LAMC_OK) status = lamc_events_after_step(run);
  if (status == LAMC_OK && run->watch.is_auto) lamc_watch_step(run);
  return status == LAMC_OK && is_at_break(run) ? pass_break(run) : status;
}

/* Tries one step. LAMC_OK if it was accepted, LAMC_PAUSED if it was not and a shorter one should be tried. */
static lamc_status try_step(lamc_run *run) {
  lamc_real h, squared;
  int is_last;
  const lamc_status status = lamc_run_next(run, &h, &is_last);
  if (status != LAMC_OK) return status;
  const lamc_status taken = lamc_run_take(run, h, is_last, &squared);
  return lamc_run_conclude(run, taken, h, squared);
}

/* ---- Dense output ------------------------------------------------------------------------------------------ */

lamc_status lamc_run_interpolate(lamc_run *run, lamc_real t, lamc_real *y) {
  if (run == NULL || y == NULL || run->dense == LAMC_DENSE_NONE) return LAMC_BAD_ARGUMENT;
  if (!(t >= run->t_old && t <= run->t)) return LAMC_BAD_ARGUMENT;
  const int n = run->ode.n;
  if (t == run->t || t == run->t_old) { /* the ends of a step must not pick up the polynomial's rounding */
    memcpy(y, t == run->t ? y_here(run) : y_there(run), (size_t)n * sizeof *y);
    return LAMC_OK;
  }
  const method *m = METHODS[run->method];
  if (run->dense == LAMC_DENSE_POSSIBLE) m->make_dense(run);
  run->dense = LAMC_DENSE_READY;
  m->interpolate(run, (t - run->t_old) / run->h_last, y);
  return LAMC_OK;
}

/* ---- Start ------------------------------------------------------------------------------------------------- */

/* Root mean square of v over the tolerance at y */
static lamc_real norm(const lamc_run *run, const lamc_real *v, const lamc_real *y) {
  lamc_real sum = 0.0;
  for (int i = 0; i < run->ode.n; i++) {
    const lamc_real ratio = v[i] / (floor_of_scale(run) + run->options.rtol * fabs(y[i]));
    sum += ratio * ratio;
  }
  return run->ode.n > 0 ? sqrt(sum / run->ode.n) : 0.0;
}

static lamc_real largest(int n, const lamc_real *v) {
  lamc_real most = 0.0;
  for (int i = 0; i < n; i++) most = larger(most, fabs(v[i]));
  return most;
}

/* The first step of an implicit method on y = [q, u]: long, since fast oscillations that the tolerance does not ask for can
 * be stepped over but not grown out of: at steps near their period they are resolved and keep the step there. Where it is
 * too long, a few refusals shorten it. The motion within the step stays small: 0.1 rad by rates, 0.01 by accelerations. */
static lamc_real long_step(const lamc_run *run, lamc_real longest) {
  const int nq = coordinates_of(&run->ode);
  const lamc_real rate = largest(nq, slope_here(run));
  const lamc_real acceleration = largest(run->ode.n - nq, slope_here(run) + nq);
  lamc_real h = larger(0.01 * longest, smaller(longest, 64.0 * LAMC_EPSILON * fabs(run->t)));
  if (rate > 0.0) h = smaller(h, 0.1 / rate);
  if (acceleration > 0.0) h = smaller(h, sqrt(0.02 / acceleration));
  return h;
}

/* The first step: Hairer, Norsett, Wanner I, section II.4, algorithm for the starting step size. One evaluation. */
static lamc_real choose_first_step(lamc_run *run, lamc_real longest) {
  const method *m = METHODS[run->method];
  if (m->stable_extent == 0.0) return long_step(run, longest);
  const lamc_real *y = y_here(run);
  const lamc_real *slope = slope_here(run);
  lamc_real *probe = slot(run, SLOT_STAGE);
  lamc_real *slope_probe = slot(run, SLOT_OWN);
  const lamc_real size = norm(run, y, y);
  const lamc_real speed = norm(run, slope, y);
  lamc_real h = size < 1e-5 || speed < 1e-5 ? 1e-6 : 0.01 * size / speed;
  if (!is_finite(h) || h <= 0.0) h = 1e-6; /* the norms overflow: tiny tolerances or huge slopes */
  h = smaller(h, longest);
  for (int i = 0; i < run->ode.n; i++) probe[i] = y[i] + h * slope[i];
  evaluate(run, run->t + h, probe, slope_probe);
  for (int i = 0; i < run->ode.n; i++) probe[i] = slope_probe[i] - slope[i];
  const lamc_real bend = norm(run, probe, y) / h;
  const lamc_real most = larger(speed, bend);
  if (!is_finite(speed) || !is_finite(bend)) return h;
  const lamc_real exponent = m->alpha + 0.75 * m->beta; /* 1 / order */
  const lamc_real h_order = most <= 1e-15 ? larger(1e-6, 1e-3 * h) : pow(0.01 / most, exponent);
  return smaller(smaller(100.0 * h, h_order), longest);
}

void lamc_run_restart(lamc_run *run) {
  const lamc_real longest = smaller(run->t_end - run->t, run->options.max_step);
  run->has_jacobian = 0;
  run->has_polynomial = 0;
  run->log_error_old = LOG_LEAST_ERROR;
  if (longest > 0.0) run->h = choose_first_step(run, longest);
}

static int is_valid(const lamc_options *o) {
  return o->rtol >= MIN_RTOL && o->rtol <= 1.0 && o->atol >= 0.0 && is_finite(o->atol) &&
         o->first_step >= 0.0 && is_finite(o->first_step) && o->max_step >= 0.0 && is_finite(o->max_step) &&
         o->max_steps > 0;
}

/* 1 if the times ascend within t0 .. t_end */
static int ascends(const lamc_real *times, long long count, lamc_real t0, lamc_real t_end) {
  lamc_real last = t0;
  for (long long i = 0; i < count; i++) {
    if (!(times[i] >= last)) return 0;
    last = times[i];
  }
  return last <= t_end;
}

lamc_status lamc_run_start(lamc_run *run, const lamc_ode *ode, lamc_method which, const lamc_options *options,
                           lamc_real t0, const lamc_real *y0, lamc_real t_end, const lamc_real *t_eval,
                           long long t_eval_count, lamc_real *work) {
  if (run == NULL) return LAMC_BAD_ARGUMENT;
  memset(run, 0, sizeof *run);
  run->status = LAMC_BAD_ARGUMENT;
  if (ode == NULL || ode->rhs == NULL || options == NULL || y0 == NULL || work == NULL) return run->status;
  const long long size = lamc_run_work_size(ode, which);
  if (size == 0 || (ode->guard_count > 0 && (ode->guards == NULL || ode->event == NULL))) return run->status;
  if (ode->integral_count > 0 && ode->integrands == NULL) return run->status;
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
  run->was_finite = run->was_closed = run->may_pass = 1;
  run->event_guard = -1;
  run->work = work;
  lamc_watch_start(run, which);
  memset(work, 0, (size_t)size * sizeof *work);
  memcpy(y_here(run), y0, (size_t)ode->n * sizeof *y0);

  run->status = LAMC_NOT_FINITE;
  if (!all_finite(run, y0)) return run->status;
  find_break(run);
  lamc_real *ends = work + size - lamc_integrals_size(ode);
  lamc_integrals_start(run, ends);
  lamc_events_start(run, ends - lamc_events_size(ode));
  evaluate(run, t0, y_here(run), slope_here(run));
  if (!all_finite(run, slope_here(run))) return run->status;
  const lamc_real longest = smaller(t_end - t0, run->options.max_step);
  if (longest > 0.0) {
    run->h =
        options->first_step > 0.0 ? smaller(options->first_step, longest) : choose_first_step(run, longest);
  }
  run->status = LAMC_PAUSED;
  return LAMC_OK;
}

/* ---- Running ----------------------------------------------------------------------------------------------- */

lamc_status lamc_run_advance(lamc_run *run, lamc_rows *rows, long long budget, const volatile int *cancel) {
  if (run == NULL || rows == NULL || budget < 0) return LAMC_BAD_ARGUMENT;
  if (rows->t == NULL || rows->y == NULL || rows->capacity <= 0 || rows->count < 0) return LAMC_BAD_ARGUMENT;
  if (run->status < 0) return run->status;
  const long long evaluations_end = budget > 0 ? run->evaluations + budget : LLONG_MAX;
  for (;;) {
    run->status = lamc_rows_write(run, rows);
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

lamc_status lamc_run_step(lamc_run *run) {
  if (run == NULL) return LAMC_BAD_ARGUMENT;
  if (run->status < 0) return run->status;
  if (run->t >= run->t_end) return LAMC_OK;
  do {
    run->status = try_step(run);
  } while (run->status == LAMC_PAUSED);
  return run->status;
}

lamc_status lamc_run_put(lamc_run *run, lamc_real t, const lamc_real *y) {
  if (run == NULL || y == NULL || !(t <= run->t_end)) return LAMC_BAD_ARGUMENT;
  run->t = run->t_old = t;
  run->dense = LAMC_DENSE_NONE;
  run->log_error_old = LOG_LEAST_ERROR;
  run->has_jacobian = run->has_polynomial = run->was_rejected = 0;
  run->was_finite = run->was_closed = 1;
  run->row_due = run->t_eval == NULL;
  run->watch.mark_t = smaller(run->watch.mark_t, t); /* a trial under way fails */
  memcpy(y_here(run), y, (size_t)run->ode.n * sizeof *y);
  find_break(run);
  if (run->ode.guard_count > 0 && run->ode.review != NULL) run->ode.review(run->ode.context, t, y_here(run));
  if (run->ode.guard_count > 0) run->ode.guards(run->ode.context, t, y_here(run), run->guards);
  evaluate(run, t, y_here(run), slope_here(run));
  run->status = all_finite(run, y) && all_finite(run, slope_here(run)) ? LAMC_PAUSED : LAMC_NOT_FINITE;
  return run->status == LAMC_PAUSED ? LAMC_OK : run->status;
}
