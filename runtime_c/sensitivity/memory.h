/* memory.h, of lamc: what the run's last evaluations left, for derivatives at the same places.
 *
 * In:    each evaluation of dy/dt of the run, by way of lamc_remember. Out: the state it was of, multipliers, and the factors of
 *        M and J that solved it, found by dy/dt itself, to the last bit.
 * Never: changes what the run computes; says that it remembers what it does not. */
#ifndef LAMC_MEMORY_H
#define LAMC_MEMORY_H

#include "lamc_sensitivity.h"

#include "loop_work.h"
#include "method.h"
#include "motion.h"
#include "system.h"

enum { REMEMBERED = 16 }; /* evaluations: those of a step of DOP853 and of its continuous extension are 15 */

/* A place where dS/dt is asked for. work: of a motion, as an acceleration at this place leaves it */
typedef struct lamc_place {
  lamc_real t;
  const lamc_real *y, *udot, *lambda;
  int count; /* equations of loops that count */
  lamc_real *work;
} lamc_place;

/* 1 if the factors of its accelerations lie in a motion's work, and are few enough to be copied */
static inline int lamc_has_factors(const lamc_model *model) {
  if (model->cut_count == 0) return lamc_is_system(model);
  return model->residual == NULL && model->pattern->step_count == 0;
}

static inline long long lamc_factors_at_most(const lamc_model *model) {
  const long long n = model->rate_count;
  if (!lamc_has_factors(model)) return 0;
  return model->cut_count > 0 ? lamc_loop_work_size(model) : n * n;
}

/* Numbers at the beginning of the work that the factors lie in */
static inline ptrdiff_t lamc_factors_size(const lamc_motion *motion) {
  const lamc_model *model = motion->model;
  if (model->cut_count == 0 || !lamc_has_factors(model)) return (ptrdiff_t)lamc_factors_at_most(model);
  lamc_loop_parts p;
  lamc_loop_parts_of(motion, &p);
  return p.norms - motion->work + p.m;
}

/* An evaluation: t, how many equations count, y (n,), dy/dt (n,), lambda (m,), factors */
static inline long long lamc_memory_entry(const lamc_model *model) {
  const long long n = model->coordinate_count + model->rate_count;
  return padded((int)(2 + 2 * n + model->closure_count + lamc_factors_at_most(model)));
}

static inline long long lamc_memory_size(const lamc_model *model) {
  return REMEMBERED * lamc_memory_entry(model);
}

static inline lamc_real *lamc_memory_at(const lamc_sensitivity *s, int index) {
  return s->remembered + (ptrdiff_t)index * s->entry_size;
}

static inline void lamc_memory_begin(lamc_sensitivity *s) {
  s->entry_size = (ptrdiff_t)lamc_memory_entry(s->motion.model);
  s->factors_size = lamc_factors_size(&s->motion);
  for (int i = 0; i < REMEMBERED; i++) lamc_memory_at(s, i)[0] = NAN; /* of no time */
}

/* dy/dt of the run, and a copy of what it follows from */
static inline void lamc_remember(const void *context, lamc_real t, const lamc_real *y, lamc_real *dydt) {
  lamc_sensitivity *s = (lamc_sensitivity *)context; /* whose first member is the motion */
  const lamc_model *model = s->motion.model;
  const int nq = model->coordinate_count, n = nq + model->rate_count;
  s->latest = (s->latest + 1) % REMEMBERED;
  lamc_real *entry = lamc_memory_at(s, s->latest), *lambda = entry + 2 + (ptrdiff_t)2 * n;
  entry[0] = t;
  entry[1] = 0;
  memcpy(entry + 2, y, (size_t)n * sizeof *y);
  if (model->cut_count > 0) {
    lamc_motion_rates(&s->motion, y, y + nq, dydt);
    entry[1] = (lamc_real)lamc_loops_acceleration(&s->motion, t, y, y + nq, dydt + nq, lambda);
  } else {
    s->rhs(context, t, y, dydt);
  }
  memcpy(entry + 2 + n, dydt, (size_t)n * sizeof *y);
  const ptrdiff_t size = s->factors_size;
  if (size > 0) memcpy(lambda + model->closure_count, s->motion.work, (size_t)size * sizeof *y);
}

/* The place of a remembered evaluation */
static inline lamc_place lamc_remembered(const lamc_sensitivity *s, int index) {
  const lamc_model *model = s->motion.model;
  const int nq = model->coordinate_count, n = nq + model->rate_count;
  lamc_real *entry = lamc_memory_at(s, index), *y = entry + 2, *lambda = y + (ptrdiff_t)2 * n;
  const lamc_place place = {entry[0], y, y + n + nq, lambda, (int)entry[1], lambda + model->closure_count};
  return place;
}

/* The evaluation that gave `slope` at t. 0: it is not remembered with all that derivatives take */
static inline int lamc_recall(lamc_sensitivity *s, lamc_real t, const lamc_real *slope, lamc_place *place) {
  const lamc_model *model = s->motion.model;
  const int n = model->coordinate_count + model->rate_count;
  if (!lamc_has_factors(model) && model->acceleration == NULL) return 0;
  for (int i = 0; i < REMEMBERED; i++) {
    const int index = (s->recalled + 1 + i) % REMEMBERED; /* stages are asked for in their order */
    lamc_real *entry = lamc_memory_at(s, index);
    if (entry[0] != t || memcmp(entry + 2 + n, slope, (size_t)n * sizeof *slope) != 0) continue;
    s->recalled = index;
    *place = lamc_remembered(s, index);
    return 1;
  }
  return 0;
}

#endif /* LAMC_MEMORY_H */
