/* tape.c, of lamc: a run, step by step, with a tape of its steps and events.
 *
 * In: a lamc_taped. Out: rows of states, entries of a tape. Never: takes a step itself, or changes one. */
#include "lamc_adjoint.h"

#include "entries.h"
#include "guards.h"
#include "rows.h"
#include "series.h"

#include <limits.h>

long long lamc_tape_entry_size(const lamc_model *model) {
  return model == NULL ? 0 : lamc_entry_size(model);
}

int lamc_tape_margin(void) {
  return TAPE_MARGIN;
}

/* Modes of the guards as they are */
static void put_modes(const lamc_taped *s, lamc_real *modes) {
  const lamc_model *model = s->motion.model;
  for (int g = 0; g < model->guard_count; g++)
    modes[g] = model->guard_modes[g] >= 0 ? s->motion.constants[model->guard_modes[g]] : 0;
}

/* The next entry, with what all have */
static entry next_entry(lamc_taped *s, int kind) {
  const lamc_model *model = s->motion.model;
  const int is_full = s->tape->count >= s->tape->capacity;
  s->overflow |= is_full;
  if (!is_full) s->tape->count++;
  s->total++;
  entry e = lamc_entry_at(model, s->tape->entries, s->tape->count - 1);
  *e.kind = kind;
  *e.t_old = s->run.t_old;
  *e.t = s->run.t;
  *e.h = s->run.h_last;
  *e.method = s->run.method;
  *e.next = (lamc_real)s->next;
  *e.singular = *e.is_break = 0;
  for (int g = 0; g < model->guard_count; g++) e.struck[g] = e.later[g] = 0;
  put_modes(s, e.modes);
  for (int k = 0; k < model->held_count; k++) e.held[k] = s->motion.constants[model->held[k]];
  return e;
}

/* The last step of the run, whose end no event has changed yet */
static void follow(lamc_taped *s) {
  lamc_run *run = &s->run;
  const size_t bytes = (size_t)run->ode.n * sizeof(lamc_real);
  const entry e = next_entry(s, ENTRY_STEP);
  memcpy(e.before, y_there(run), bytes);
  memcpy(e.after, y_here(run), bytes);
  if (!lamc_is_replayed(run->method)) {
    const int dense = run->dense;
    for (int k = 0; k < RADAU_NODES - 1; k++) {
      const lamc_real t = smaller(run->t_old + RADAU_NODE[k] * run->h_last, run->t);
      (void)lamc_run_interpolate(run, t, e.nodes + (ptrdiff_t)k * run->ode.n);
    }
    if (run->ode.doubts != NULL) run->dense = dense; /* rows ask whether making it met doubts */
  }
  s->t = run->t;
}

static lamc_status meet(const void *context, lamc_real t, lamc_real *y, const lamc_real *struck) {
  lamc_taped *s = (lamc_taped *)context; /* whose first member is the motion */
  const size_t bytes = (size_t)s->run.ode.n * sizeof(lamc_real);
  if (s->run.t > s->t) follow(s);
  const entry e = next_entry(s, ENTRY_EVENT);
  *e.is_break = t == s->t_break ? 1 : 0;
  memcpy(e.struck, struck, (size_t)s->motion.model->guard_count * sizeof *struck);
  memcpy(e.before, y, bytes);
  const lamc_status status = lamc_guards_event(context, t, y, struck);
  memcpy(e.after, y, bytes);
  put_modes(s, e.later);
  return status;
}

/* A step that ended at a break of a series is taped before the run looks at what comes after it */
static void pass(const void *context, long long next) {
  lamc_taped *s = (lamc_taped *)context; /* whose first member is the motion */
  if (s->run.t > s->t) follow(s);
  s->t_break = s->run.t;
  s->next = next;
  lamc_series_pass(context, next);
}

lamc_status lamc_taped_start(lamc_taped *s, const lamc_motion *motion, lamc_method which,
                             const lamc_options *options, lamc_real t0, const lamc_real *y0, lamc_real t_end,
                             const lamc_real *t_eval, long long t_eval_count, lamc_real *run_work) {
  if (s == NULL || motion == NULL) return LAMC_BAD_ARGUMENT;
  memset(s, 0, sizeof *s);
  s->motion = *motion;
  s->t = t0;
  s->t_break = -HUGE_VAL;
  lamc_ode ode = lamc_motion_ode(&s->motion);
  ode.integral_count = 0;
  if (ode.guard_count > 0) ode.event = meet;
  if (ode.pass != NULL) ode.pass = pass;
  return lamc_run_start(&s->run, &ode, which, options, t0, y0, t_end, t_eval, t_eval_count, run_work);
}

lamc_status lamc_taped_advance(lamc_taped *s, lamc_tape *tape, lamc_rows *rows, long long *at,
                               long long budget, const volatile int *cancel) {
  if (s == NULL || tape == NULL || tape->entries == NULL || rows == NULL || at == NULL || budget < 0)
    return LAMC_BAD_ARGUMENT;
  if (rows->t == NULL || rows->y == NULL || rows->capacity <= 0 || rows->count < 0) return LAMC_BAD_ARGUMENT;
  lamc_run *run = &s->run;
  s->tape = tape;
  if (run->status < 0) return run->status;
  const long long end = budget > 0 ? run->evaluations + budget : LLONG_MAX;
  for (;;) {
    const long long first = rows->count;
    run->status = lamc_rows_write(run, rows);
    for (long long k = first; k < rows->count; k++) at[k] = s->total;
    if (run->status != LAMC_OK || run->t >= run->t_end) return run->status;
    run->status = LAMC_PAUSED;
    if (cancel != NULL && *cancel) return run->status = LAMC_CANCELLED;
    if (run->evaluations >= end || tape->capacity - tape->count < TAPE_MARGIN) return run->status;
    const long long singular = lamc_motion_singular_steps(&s->motion);
    const lamc_status status = lamc_run_step(run);
    if (status < 0) return status;
    if (run->t > s->t) follow(s);
    if (lamc_motion_singular_steps(&s->motion) > singular && tape->count > 0) {
      s->singular++;
      *lamc_entry_at(s->motion.model, tape->entries, tape->count - 1).singular = 1;
    }
  }
}
