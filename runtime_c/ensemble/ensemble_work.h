/* ensemble_work.h, of lamc: the memory of a thread that steps instances side by side.
 *
 * In: a lamc_ensemble, memory of a caller. Out: how much of it there must be; lanes without an instance.
 * Never: takes an instance, or a step. */
#ifndef LAMC_ENSEMBLE_WORK_H
#define LAMC_ENSEMBLE_WORK_H

#include "lamc_ensemble.h"
#include "lanes.h"

#include <string.h>

enum { MOST_LANES = 8, ALIGNMENT = 64 };

typedef struct lane {
  lamc_motion motion; /* the first: a run's context is the lane too */
  lamc_run run;
  lamc_rows rows;
  lamc_real *run_work;
  long long instance; /* -1: none */
  int is_settled;     /* 1: what must hold after a step was brought about side by side */
  lamc_real moved;    /* by that */
} lane;

/* What one thread works with */
typedef struct bench {
  const lamc_ensemble *e;
  const lamc_lane_steps *steps; /* NULL: every step is a run's own */
  lamc_real *block;
  lane *lanes[MOST_LANES];
  lamc_run *runs[MOST_LANES]; /* that take the step side by side; NULL: none in this lane */
  lamc_real h[MOST_LANES], squared[MOST_LANES];
  int is_last[MOST_LANES];
  lamc_status taken[MOST_LANES];
  int has_dense[MOST_LANES]; /* 1: the continuous extension was worked out side by side */
  int width;
} bench;

static const lamc_lane_steps *steps_of(const lamc_ensemble *e) {
  const int serves = e->method == LAMC_AUTO || lamc_lanes_serve((int)e->method);
  return e->use_lanes && serves ? lamc_this_lanes() : NULL;
}

static int width_of(const lamc_ensemble *e) {
  const lamc_lane_steps *steps = steps_of(e);
  return steps == NULL ? 1 : steps->width;
}

/* A multiple of 64 bytes, in numbers */
static long long whole(long long size) {
  const long long unit = ALIGNMENT / (long long)sizeof(lamc_real);
  return (size + unit - 1) / unit * unit;
}

static long long numbers_of_lane(void) {
  return whole((long long)((sizeof(lane) + sizeof(lamc_real) - 1) / sizeof(lamc_real)));
}

static lamc_ode plain_ode(const lamc_motion *motion) {
  lamc_ode ode = lamc_motion_ode(motion);
  ode.integral_count = 0;
  return ode;
}

/* Numbers for the run of one instance; 0 where it cannot be */
static long long run_size(const lamc_ensemble *e) {
  const lamc_motion motion = {e->model, NULL, NULL, 0, e->recording};
  const lamc_ode ode = plain_ode(&motion);
  return lamc_run_work_size(&ode, e->method);
}

static long long work_size_of(const lamc_ensemble *e) {
  const lamc_lane_steps *steps = steps_of(e);
  const long long run = run_size(e);
  const long long of_lane = numbers_of_lane() + whole(e->model->constant_count + 1) +
                            whole(lamc_motion_work_size(e->model) + 1) + whole(run) + whole(e->row_count);
  if (run == 0) return 0;
  return whole(1) + (steps == NULL ? 0 : whole(steps->size)) + width_of(e) * of_lane;
}

static lamc_real *cut(lamc_real **rest, long long size) {
  lamc_real *part = *rest;
  *rest += whole(size);
  return part;
}

static lamc_real *aligned(lamc_real *work) {
  const uintptr_t beyond = (uintptr_t)work % ALIGNMENT;
  return beyond == 0 ? work : work + (ALIGNMENT - beyond) / sizeof(lamc_real);
}

static void lay_out(bench *b, const lamc_ensemble *e, lamc_real *work) {
  memset(b, 0, sizeof *b);
  b->e = e;
  b->steps = steps_of(e);
  b->width = width_of(e);
  lamc_real *rest = aligned(work);
  if (b->steps != NULL) {
    b->block = cut(&rest, b->steps->size);
    memset(b->block, 0, (size_t)b->steps->size * sizeof *b->block);
  }
  const long long run = run_size(e);
  for (int k = 0; k < b->width; k++) {
    lane *l = b->lanes[k] = (lane *)(void *)cut(&rest, numbers_of_lane());
    memset(l, 0, sizeof *l);
    l->motion.model = e->model;
    l->motion.recording = e->recording;
    l->motion.constants = cut(&rest, e->model->constant_count + 1);
    l->motion.work = cut(&rest, lamc_motion_work_size(e->model) + 1);
    l->run_work = cut(&rest, run);
    l->rows.t = cut(&rest, e->row_count);
    l->instance = -1;
  }
}

#endif /* LAMC_ENSEMBLE_WORK_H */
