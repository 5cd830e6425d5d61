/* adjoint.c, of lamc: the way back along a tape.
 *
 * In: a lamc_adjoint, tapes from the last to the first. Out: derivatives of a weighted sum of the run's rows by its start and
 * by the sources. Never: looks at a run that is not on the tape. */
#include "lamc_adjoint.h"

#include "back_collocation.h"
#include "back_events.h"
#include "back_steps.h"
#include "guards.h"

static long long whole(long long size) {
  return (size + LANES - 1) / LANES * LANES;
}

long long lamc_adjoint_work_size(const lamc_model *model, const lamc_pullbacks *pullbacks) {
  if (model == NULL || pullbacks == NULL) return 0;
  const long long n = model->coordinate_count + model->rate_count;
  return whole(model->constant_count + 1) + whole(lamc_motion_work_size(model) + 1) + whole(n) +
         whole(pullbacks->source_count + model->held_count + 1) +
         lamc_scratch_of(model, pullbacks, NULL, NULL);
}

lamc_status lamc_adjoint_start(lamc_adjoint *a, const lamc_motion *motion, const lamc_pullbacks *pullbacks,
                               const lamc_real *row_t, const lamc_real *row_y, const long long *row_at,
                               const lamc_real *seeds, long long rows, lamc_real rtol, lamc_real *work) {
  if (a == NULL || motion == NULL || pullbacks == NULL || work == NULL || rows < 0) return LAMC_BAD_ARGUMENT;
  const lamc_model *model = motion->model;
  const long long n = model->coordinate_count + model->rate_count;
  memset(a, 0, sizeof *a);
  memset(work, 0, (size_t)lamc_adjoint_work_size(model, pullbacks) * sizeof *work);
  a->motion = *motion;
  a->motion.constants = work;
  a->motion.work = work + whole(model->constant_count + 1);
  a->state = a->motion.work + whole(lamc_motion_work_size(model) + 1);
  a->sources = a->state + whole(n);
  a->scratch = a->sources + whole(pullbacks->source_count + model->held_count + 1);
  memcpy(a->motion.constants, motion->constants, (size_t)model->constant_count * sizeof *work);
  a->pullbacks = pullbacks;
  a->row_t = row_t;
  a->row_y = row_y;
  a->row_at = row_at;
  a->seeds = seeds;
  a->rows = rows;
  a->rtol = rtol;
  a->next = -1;
  a->lost_guard = -1;
  if (model->cut_count > 0) lamc_loops_begin(&a->motion);
  return LAMC_OK;
}

/* Rows at the end of an entry, behind it: their derivatives are taken in. */
static void take_rows(lamc_adjoint *a, lamc_real t, long long number) {
  const int n = a->motion.model->coordinate_count + a->motion.model->rate_count;
  while (a->rows > 0 && a->row_t[a->rows - 1] >= t && a->row_at[a->rows - 1] > number) {
    a->rows--;
    lamc_add_to(n, 1, a->seeds + (ptrdiff_t)a->rows * n, a->state);
  }
}

/* 1 if nothing is weighed: no state, and nothing that a clock holds */
static int is_zero(const lamc_adjoint *a, int n) {
  const lamc_real *held = a->sources + a->pullbacks->source_count;
  for (int i = 0; i < n; i++)
    if (a->state[i] != 0) return 0;
  for (int i = 0; i < a->motion.model->held_count; i++)
    if (held[i] != 0) return 0;
  return 1;
}

/* 1 if any row within a step weighs something */
static int has_seeds(const lamc_adjoint *a, int n, lamc_real t_old) {
  for (long long row = a->rows - 1; row >= 0 && a->row_t[row] > t_old; row--)
    for (int i = 0; i < n; i++)
      if (a->seeds[(ptrdiff_t)row * n + i] != 0) return 1;
  return 0;
}

/* Constants as they were in an entry */
static void go_to(lamc_adjoint *a, const entry *e) {
  const lamc_model *model = a->motion.model;
  for (int g = 0; g < model->guard_count; g++)
    if (model->guard_modes[g] >= 0) a->motion.constants[model->guard_modes[g]] = e->modes[g];
  for (int k = 0; k < model->held_count; k++) a->motion.constants[model->held[k]] = e->held[k];
  if (model->series_count > 0 && (long long)*e->next != a->next) {
    a->next = (long long)*e->next;
    lamc_series_pass(&a->motion, a->next);
  }
}

/* 1 if forces may be rough within a step: where they begin or end with a power of time, or follow a table */
static int is_wary(const lamc_adjoint *a) {
  return a->motion.model->table_count > 0 || a->motion.model->guard_count > 0;
}

static void step_back(lamc_adjoint *a, const room *r, const entry *e) {
  const stretch s = {*e->t_old, *e->t, *e->h, e->before, e->after};
  if (lamc_is_replayed((int)*e->method)) {
    lamc_replay_back(a, r, (int)*e->method, &s, is_wary(a));
  } else if (!lamc_collocate_back(a, r, &s, e->nodes)) {
    lamc_no_gradient_from(a, *e->t_old, LAMC_GRADIENT_NOT_FINITE, -1);
  }
}

lamc_status lamc_adjoint_back(lamc_adjoint *a, const lamc_tape *tape, long long first) {
  if (a == NULL || tape == NULL) return LAMC_BAD_ARGUMENT;
  const room r = lamc_room_of(a);
  for (long long i = tape->count - 1; i >= 0 && a->lost == LAMC_GRADIENT_KNOWN; i--) {
    const entry e = lamc_entry_at(a->motion.model, tape->entries, i);
    take_rows(a, *e.t, first + i);
    const int is_step = *e.kind == ENTRY_STEP;
    if (is_zero(a, r.n) && !(is_step && has_seeds(a, r.n, *e.t_old))) continue; /* nothing depends on it */
    if (*e.singular > 0) lamc_no_gradient_from(a, *e.t, LAMC_GRADIENT_SINGULAR, -1);
    go_to(a, &e);
    if (is_step) {
      step_back(a, &r, &e);
    } else {
      lamc_event_back(a, &r, &e);
    }
    lamc_real sum = 0;
    for (int j = 0; j < r.n; j++) sum += fabs(a->state[j]);
    if (!is_finite(sum)) lamc_no_gradient_from(a, *e.t, LAMC_GRADIENT_NOT_FINITE, -1);
  }
  return a->lost == LAMC_GRADIENT_KNOWN ? LAMC_OK : LAMC_CANCELLED;
}

lamc_status lamc_adjoint_end(lamc_adjoint *a, lamc_real t0, const lamc_real *y0) {
  if (a == NULL || y0 == NULL) return LAMC_BAD_ARGUMENT;
  const room r = lamc_room_of(a);
  take_rows(a, t0, -1);
  lamc_samples_back(a, &r, t0, y0, NULL);
  if (!is_zero(a, r.n)) lamc_pull_settle(a, &r, t0, y0, a->state);
  return LAMC_OK;
}

lamc_status lamc_adjoint_outputs(lamc_adjoint *a, long long count, const lamc_real *t, const lamc_real *y,
                                 const lamc_real *pose_weights, const lamc_real *energy_weights,
                                 lamc_real *seeds) {
  if (a == NULL || count < 0 || t == NULL || y == NULL || seeds == NULL) return LAMC_BAD_ARGUMENT;
  const room r = lamc_room_of(a);
  const lamc_model *model = a->motion.model;
  for (long long k = 0; k < count; k++) {
    const lamc_real *q = y + (ptrdiff_t)k * r.n;
    if (model->guard_count > 0) lamc_guards_sense(&a->motion, t[k], q);
    lamc_series_put(&a->motion, t[k]);
    for (int part = 0; part < 2; part++) {
      const lamc_real *weights = part == 0 ? pose_weights : energy_weights;
      if (weights == NULL) continue;
      const ptrdiff_t across = part == 0 ? 12 * (ptrdiff_t)model->body_count : model->energy_count;
      (part == 0 ? a->pullbacks->poses : a->pullbacks->energies)(a->motion.constants, t[k], q, q + r.nq,
                                                                 weights + (ptrdiff_t)k * across, r.out);
      lamc_add_to(r.n, 1, r.out, seeds + (ptrdiff_t)k * r.n);
      lamc_add_to(r.k, 1, r.out + r.n, a->sources);
    }
  }
  return LAMC_OK;
}
