/* rows.c, of lamc: the output of a run: rows at the times asked for or after each step, and events.
 *
 * In: a run just after a step. Out: rows and events in the caller's buffers. Never: moves the run. */
#include "rows.h"

#include "events.h"
#include "integrals.h"
#include "watch.h"

/* Room for the next row: its y, with its t set; NULL when the rows are full */
static lamc_real *next_row(lamc_rows *rows, int n, lamc_real t) {
  if (rows->count >= rows->capacity) return NULL;
  lamc_real *y = rows->y + rows->count * n;
  rows->t[rows->count++] = t;
  return y;
}

/* Writes the events that are due, if events are wanted. LAMC_OK, or LAMC_OUTPUT_FULL. */
static lamc_status write_events(lamc_run *run, lamc_rows *rows) {
  for (; run->event_due > 0; run->event_due--) {
    if (rows->event_t == NULL) continue;
    if (rows->event_count >= rows->event_capacity) return LAMC_OUTPUT_FULL;
    rows->event_t[rows->event_count] = run->t_event;
    rows->event_guard[rows->event_count++] = lamc_events_due(run);
  }
  return LAMC_OK;
}

/* y at a time within the last step by steps of their own from where that one began, and that one taken again, which gives
 * the same bits. LAMC_PAUSED: it cannot be had. */
static lamc_status row_by_steps(lamc_run *run, lamc_real t, lamc_real *y) {
  const size_t bytes = (size_t)run->ode.n * sizeof *y;
  const long long steps = run->steps;
  const lamc_real h = run->h_last, t_new = run->t, t_old = run->t_old;
  lamc_real part = t - t_old, squared;
  lamc_status status = LAMC_OK;
  lamc_run_move_back(run);
  memcpy(slot(run, SLOT_KEPT), y_here(run), bytes);
  memcpy(slot(run, SLOT_KEPT + 1), slope_here(run), bytes);
  while (run->t < t && status == LAMC_OK) {
    const int is_last = part >= t - run->t;
    status = lamc_run_take(run, is_last ? t - run->t : part, 0, &squared);
    if (status == LAMC_OK && is_last) run->t = t;
    if (status == LAMC_PAUSED && part > 1e-3 * h) {
      part *= 0.25;
      status = LAMC_OK;
    }
  }
  if (status == LAMC_OK) memcpy(y, y_here(run), bytes);
  memcpy(y_here(run), slot(run, SLOT_KEPT), bytes);
  memcpy(slope_here(run), slot(run, SLOT_KEPT + 1), bytes);
  run->t = t_old;
  const lamc_status again = lamc_run_take(run, h, t_new == run->t_end, &squared);
  run->steps = steps;
  if (again != LAMC_OK) return again < 0 ? again : LAMC_NOT_FINITE; /* cannot be: it was taken before */
  run->t = t_new;
  return status;
}

/* y at a time within the last step, between its ends. What the polynomial met inside may not be what the error estimate of
 * the step saw (DOP853's three extra stages, beside a singular position): such rows are worth steps of their own. */
static lamc_status row_between(lamc_run *run, lamc_real t, lamc_real *y) {
  const int can_step = lamc_method_of(run->method)->stable_extent > 0.0 && run->t_event != run->t;
  if (run->ode.doubts == NULL || !can_step || run->dense == LAMC_DENSE_READY) {
    (void)lamc_run_interpolate(run, t, y); /* cannot fail: the time lies in the step just accepted */
  } else {
    const long long before = run->ode.doubts(run->ode.context);
    (void)lamc_run_interpolate(run, t, y);
    if (run->ode.doubts(run->ode.context) > before) {
      const lamc_status status = row_by_steps(run, t, y);
      if (status != LAMC_PAUSED) return status;
      (void)lamc_run_interpolate(run, t, y);
    }
  }
  lamc_real moved = 0.0; /* it strays from what must hold by the tolerance */
  return run->ode.settle == NULL ? LAMC_OK : run->ode.settle(run->ode.context, t, y, &moved);
}

/* y at a time within the last step or at its end */
static lamc_status state_at(lamc_run *run, lamc_real t, lamc_real *y) {
  if (t == run->t) {
    memcpy(y, lamc_run_state(run), (size_t)run->ode.n * sizeof *y);
    return LAMC_OK;
  }
  const long long before = run->evaluations;
  const lamc_real work = lamc_watch_work(run);
  const lamc_status settled = row_between(run, t, y);
  run->watch.mark_cost += (lamc_real)(run->evaluations - before); /* rows must not sway LAMC_AUTO */
  lamc_watch_forget(run, work);
  return settled;
}

lamc_status lamc_run_at(lamc_run *run, lamc_real t, lamc_real *y) {
  if (run == NULL || y == NULL) return LAMC_BAD_ARGUMENT;
  if (!(t == run->t || (run->dense != LAMC_DENSE_NONE && t > run->t_old && t < run->t)))
    return LAMC_BAD_ARGUMENT;
  return state_at(run, t, y);
}

/* Integrals of the row just begun, if they are wanted */
static void write_integrals(const lamc_run *run, const lamc_rows *rows, lamc_real t) {
  const int k = run->ode.integral_count;
  if (k > 0 && rows->integrals != NULL) lamc_integrals_at(run, t, rows->integrals + (rows->count - 1) * k);
}

/* Writes the rows that are due at or before t. LAMC_OK, or LAMC_OUTPUT_FULL where some remain. */
lamc_status lamc_rows_write(lamc_run *run, lamc_rows *rows) {
  const int n = run->ode.n;
  const lamc_status status = write_events(run, rows);
  if (status != LAMC_OK) return status;
  if (run->row_due) {
    lamc_real *y = next_row(rows, n, run->t);
    if (y == NULL) return LAMC_OUTPUT_FULL;
    memcpy(y, lamc_run_state(run), (size_t)n * sizeof *y);
    write_integrals(run, rows, run->t);
    run->row_due = 0;
  }
  while (run->t_eval_next < run->t_eval_count && run->t_eval[run->t_eval_next] <= run->t) {
    const lamc_real t = run->t_eval[run->t_eval_next];
    lamc_real *y = next_row(rows, n, t);
    if (y == NULL) return LAMC_OUTPUT_FULL;
    write_integrals(run, rows, t);
    const lamc_status settled = state_at(run, t, y);
    if (settled != LAMC_OK) {
      rows->count--; /* a row that does not close is no result */
      return settled;
    }
    run->t_eval_next++;
  }
  return LAMC_OK;
}
