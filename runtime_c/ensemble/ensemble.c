/* ensemble.c, of lamc: takes instances from a queue, several at a time, and steps them side by side.
 *
 * In: a lamc_ensemble. Out: rows, statuses, counters. Never: decides how long a step is, or what becomes of it.
 *
 * Every lane is a run of its own (lamc_run) with a motion of its own, and does with each step what a run by itself does: it is
 * accepted or refused, closed, searched for events. Only the stages of explicit methods, which take most of the time, are
 * evaluated for all lanes at once. What is not such a step, as the first one, an implicit one or the location of an event,
 * is the run's own. So a lane gives the bits of a run by itself. */
#include "lamc_ensemble.h"

#include "ensemble_work.h"
#include "rows.h"
#include "steps.h"

#include <stdatomic.h>

int lamc_ensemble_width(const lamc_ensemble *e) {
  return width_of(e);
}

long long lamc_ensemble_work_size(const lamc_ensemble *e) {
  return work_size_of(e);
}

/* ---- One instance ------------------------------------------------------------------------------------------ */

static void tell(const lamc_ensemble *e, const lane *l, lamc_status status) {
  long long *told = e->told + l->instance * LAMC_TOLD;
  told[LAMC_TOLD_EVALUATIONS] = l->run.evaluations;
  told[LAMC_TOLD_ACCEPTED] = l->run.accepted;
  told[LAMC_TOLD_REJECTED] = l->run.rejected;
  told[LAMC_TOLD_EVENTS] = l->run.events;
  told[LAMC_TOLD_SWITCHES] = l->run.switches;
  told[LAMC_TOLD_SINGULAR] = lamc_motion_singular_steps(&l->motion);
  told[LAMC_TOLD_METHOD] = l->run.method;
  e->t_reached[l->instance] = l->run.t;
  e->status[l->instance] = (int)status;
}

/* Rows that are due; 1 if the instance has come to its end, which is then told */
static int is_over(const lamc_ensemble *e, lane *l, lamc_status status) {
  if (status == LAMC_PAUSED) return 0;
  if (status == LAMC_OK) status = lamc_rows_write(&l->run, &l->rows);
  if (status == LAMC_OK && l->run.t < l->run.t_end) return 0;
  tell(e, l, status);
  l->instance = -1;
  return 1;
}

/* lamc_ode.settle of a motion in a lane */
static lamc_status settle(const void *context, lamc_real t, lamc_real *y, lamc_real *moved) {
  const lane *l = (const lane *)context;
  if (!l->is_settled) return lamc_motion_settle(&l->motion, t, y, moved);
  *moved = l->moved;
  return LAMC_OK;
}

/* The run of instance k from its start */
static lamc_status start(const lamc_ensemble *e, lane *l, long long k) {
  const lamc_model *model = e->model;
  const int n = model->coordinate_count + model->rate_count;
  const long long room = lamc_motion_work_size(model);
  l->instance = k;
  model->setup(e->parameters + k * e->parameter_stride, l->motion.constants);
  memset(l->motion.work, 0, (size_t)room * sizeof *l->motion.work);
  l->rows.y = e->y + k * e->row_count * n;
  l->rows.capacity = e->row_count;
  l->rows.count = 0;
  lamc_ode ode = plain_ode(&l->motion);
  if (ode.settle != NULL) ode.settle = settle;
  return lamc_run_start(&l->run, &ode, e->method, &e->options, 0, e->starts + k * e->start_stride, e->t_end,
                        e->t_eval, e->row_count, l->run_work);
}

/* The next instance into a lane; 0 where none is left */
static int refill(bench *b, int k) {
  const lamc_ensemble *e = b->e;
  for (;;) {
    const long long taken = atomic_fetch_add_explicit((_Atomic(long long) *)e->next, 1, memory_order_relaxed);
    if (taken >= e->count) return 0;
    const lamc_status status = start(e, b->lanes[k], taken);
    if (is_over(e, b->lanes[k], status)) continue;
    if (b->steps != NULL) b->steps->take_constants(b->block, k, b->lanes[k]->motion.constants);
    return 1;
  }
}

/* ---- Steps ------------------------------------------------------------------------------------------------- */

/* Whether rows lie within the step that the run has just taken */
static int has_rows(const lamc_run *run) {
  return run->t_eval_next < run->t_eval_count && run->t_eval[run->t_eval_next] < run->t;
}

/* Whether the step has come to a break, behind which the equation is another one: the run then asks for what lies before */
static int has_break(const lamc_run *run) {
  return run->next_break < run->ode.break_count && run->t >= run->ode.breaks[run->next_break];
}

/* Whether all that the run will be asked for within the step is its continuous extension, which takes evaluations */
static int wants_dense(const lamc_run *run) {
  return has_rows(run) && run->method == LAMC_DOP853 && run->ode.guard_count == 0 && !has_break(run);
}

/* Decides on the step just tried in lane k, up to dy/dt where it led. 1: that is still to be evaluated */
static int land(bench *b, int k, int is_beside) {
  lamc_run *run = &b->lanes[k]->run;
  int wants_slope = 0;
  b->taken[k] = lamc_run_land(run, b->h[k], b->is_last[k], b->squared[k], &wants_slope);
  b->lanes[k]->is_settled = 0;
  if (b->taken[k] != LAMC_OK) return 0;
  const int may_be_odd =
      run->ode.settle != NULL; /* and then has to work out its continuous extension itself */
  const int all =
      run->ode.guard_count > 0 || has_break(run) || (has_rows(run) && (may_be_odd || !wants_dense(run)));
  if (is_beside && (run->watch.is_auto || all)) b->steps->give_stages(b->block, run->method, k, run, all);
  return wants_slope;
}

/* What follows from the step; the lane is filled anew where its instance came to an end */
static void conclude(bench *b, int k) {
  lane *l = b->lanes[k];
  const long long events = l->run.events;
  const lamc_status status = lamc_run_conclude(&l->run, b->taken[k], b->h[k], b->squared[k]);
  if (b->steps != NULL && l->run.events != events) b->steps->take_constants(b->block, k, l->motion.constants);
  if (b->has_dense[k]) { /* as rows.c, which would have asked for it now */
    l->run.dense = LAMC_DENSE_READY;
    l->run.evaluations += 3;
    l->run.watch.mark_cost += 3;
    b->has_dense[k] = 0;
  }
  if (is_over(b->e, l, status)) (void)refill(b, k);
}

/* A step by the run alone */
static void step_alone(bench *b, int k) {
  lamc_run *run = &b->lanes[k]->run;
  run->dense = LAMC_DENSE_NONE;
  run->steps++;
  b->squared[k] = lamc_method_of(run->method)->attempt(run, b->h[k]);
  if (land(b, k, 0)) evaluate(run, run->t, y_here(run), slope_here(run));
  if (b->taken[k] == LAMC_OK) b->taken[k] = lamc_run_stand(run);
  conclude(b, k);
}

/* The lanes whose next step is one to take side by side, by the method of the first of them; the others take theirs. How
 * many. */
static int gather(bench *b, int *which) {
  int count = 0;
  *which = 0;
  for (int k = 0; k < b->width; k++) {
    lane *l = b->lanes[k];
    b->runs[k] = NULL;
    if (l->instance < 0) continue;
    const lamc_status status = lamc_run_next(&l->run, &b->h[k], &b->is_last[k]);
    if (status != LAMC_OK) {
      (void)is_over(b->e, l, status);
      (void)refill(b, k); /* whose step is for the next time round */
      continue;
    }
    const int used = l->run.method;
    if (b->steps == NULL || !lamc_lanes_serve(used) || (*which != 0 && *which != used)) {
      step_alone(b, k);
      continue;
    }
    *which = used;
    b->runs[k] = &l->run;
    count++;
  }
  return count;
}

/* What must hold where the attempt led, in the lanes that will be accepted */
static void settle_beside(bench *b) {
  lamc_run *wanting[MOST_LANES] = {NULL};
  lamc_real t[MOST_LANES] = {0}, moved[MOST_LANES] = {0};
  int count = 0, done[MOST_LANES] = {0};
  for (int k = 0; k < b->width; k++) {
    if (b->runs[k] == NULL || !(b->squared[k] <= 1.0)) continue;
    wanting[k] = b->runs[k];
    t[k] = b->is_last[k] ? lamc_run_stop(b->runs[k]) : b->runs[k]->t + b->h[k];
    count++;
  }
  if (count > 0) b->steps->settle(b->block, wanting, t, moved, done);
  for (int k = 0; k < b->width; k++) {
    b->lanes[k]->is_settled = done[k];
    b->lanes[k]->moved = moved[k];
  }
}

/* The step of all lanes that `gather` found */
static void step_beside(bench *b, int which) {
  for (int k = 0; k < b->width; k++) {
    if (b->runs[k] == NULL) continue;
    b->runs[k]->dense = LAMC_DENSE_NONE;
    b->runs[k]->steps++;
  }
  b->steps->attempt(b->block, which, b->runs, b->h, b->squared);
  if (b->steps->settle != NULL) settle_beside(b);
  int count = 0;
  lamc_run *wanting[MOST_LANES] = {NULL};
  for (int k = 0; k < b->width; k++) {
    if (b->runs[k] == NULL || !land(b, k, 1)) continue;
    wanting[k] = b->runs[k];
    count++;
  }
  if (count > 0) b->steps->slope(b->block, wanting);
  lamc_run *dense[MOST_LANES] = {NULL};
  count = 0;
  for (int k = 0; k < b->width; k++) {
    if (b->runs[k] == NULL || b->taken[k] != LAMC_OK) continue;
    b->taken[k] = lamc_run_stand(b->runs[k]);
    b->has_dense[k] = b->taken[k] == LAMC_OK && wants_dense(b->runs[k]);
    if (!b->has_dense[k]) continue;
    dense[k] = b->runs[k];
    count++;
  }
  if (count > 0) b->steps->dense(b->block, dense, b->has_dense);
  for (int k = 0; k < b->width; k++) {
    if (b->runs[k] != NULL) conclude(b, k);
  }
}

/* Instances under way end where they are. */
static lamc_status stop(bench *b) {
  for (int k = 0; k < b->width; k++) {
    if (b->lanes[k]->instance >= 0) tell(b->e, b->lanes[k], LAMC_CANCELLED);
  }
  return LAMC_CANCELLED;
}

lamc_status lamc_ensemble_run(const lamc_ensemble *e, lamc_real *work) {
  if (e == NULL || work == NULL || e->model == NULL || e->next == NULL || e->count < 0 || e->row_count <= 0)
    return LAMC_BAD_ARGUMENT;
  bench b;
  lay_out(&b, e, work);
  for (int k = 0; k < b.width; k++) (void)refill(&b, k);
  for (;;) {
    if (e->cancel != NULL && *e->cancel) return stop(&b);
    int busy = 0, which;
    for (int k = 0; k < b.width; k++) busy |= b.lanes[k]->instance >= 0;
    if (!busy) return LAMC_OK;
    if (gather(&b, &which) > 0) step_beside(&b, which);
  }
}
