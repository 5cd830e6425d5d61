/* loop_work.h, of lamc: where the parts of the work array of loops lie.
 *
 * In:    the sizes of a model. Out: how many numbers loops need; the parts.
 * Never: reads what is in them, but for how J was eliminated last. */
#ifndef LAMC_LOOP_WORK_H
#define LAMC_LOOP_WORK_H

#include "loop_parts.h"
#include "loop_sparse.h"

/* J and a vector beside it */
static inline long long lamc_loop_closure_size(const lamc_model *model) {
  return model->closure_count + model->pattern->row_start[model->closure_count];
}

/* What is written before it is read elsewhere: the closure, or the lower triangle of N^T M N */
static inline long long lamc_loop_raw_size(const lamc_model *model) {
  const long long reduced = (long long)model->rate_count * (model->rate_count + 1) / 2;
  const long long closure = lamc_loop_closure_size(model);
  return closure > reduced ? closure : reduced;
}

/* J and its place as they were eliminated last: where M is not written down */
static inline long long lamc_loop_taken_size(const lamc_model *model) {
  if (model->residual == NULL) return 0;
  return model->pattern->row_start[model->closure_count] + model->coordinate_count;
}

/* Numbers of the elimination */
static inline long long lamc_loop_elimination_size(const lamc_model *model) {
  const long long n = model->rate_count, m = model->closure_count;
  if (model->pattern->step_count == 0) return 3 * m + 2 * n + m * n;
  const long long triangle = n * (n + 1) / 2;
  return n + 2 * (n + 1) + 2 * (triangle + n) + 2 * triangle + 3 * n + 5 * n + m;
}

static inline long long lamc_loop_work_size(const lamc_model *model) {
  const long long n = model->rate_count, nq = model->coordinate_count;
  const long long m = model->closure_count;
  const long long system = model->residual == NULL ? n * (n + 1) / 2 + n : 0;
  const long long state = 2 * (nq + n), around = 2 * (n + m);
  return system + lamc_loop_taken_size(model) + lamc_loop_closure_size(model) + lamc_loop_raw_size(model) +
         lamc_loop_elimination_size(model) + 2 * n * n + 3 * n + 3 * m + 2 * nq + state + LAMC_LOOPS_KEPT +
         around;
}

/* The next `count` numbers */
static inline lamc_real *lamc_loop_part(lamc_real **next, size_t count) {
  lamc_real *here = *next;
  *next += count;
  return here;
}

static inline void lamc_loop_place_elimination(lamc_loop_parts *p, lamc_real **next) {
  const size_t n = (size_t)p->n, m = (size_t)p->m, triangle = n * (n + 1) / 2;
  if (!p->is_sparse) {
    p->a = lamc_loop_part(next, m * n);
    p->rows = lamc_loop_part(next, m);
    p->columns = lamc_loop_part(next, n);
    p->peak = lamc_loop_part(next, m);
    p->filled = lamc_loop_part(next, m);
    p->inverse = lamc_loop_part(next, n);
    return;
  }
  memset(&p->found, 0, sizeof p->found); /* nothing of it is given */
  p->found.row.found = lamc_loop_part(next, n);
  p->found.update_start.found = lamc_loop_part(next, n + 1);
  p->found.left_start.found = lamc_loop_part(next, n + 1);
  p->found.update.found = lamc_loop_part(next, triangle + n);
  p->found.factor = lamc_loop_part(next, triangle + n);
  p->found.left.found = lamc_loop_part(next, triangle);
  p->found.value = lamc_loop_part(next, triangle);
  p->found.inverse = lamc_loop_part(next, n);
  p->found.peak = lamc_loop_part(next, n);
  p->found.noise = lamc_loop_part(next, n);
  p->row = lamc_loop_part(next, n);
  p->step_of = lamc_loop_part(next, n);
  p->touched = lamc_loop_part(next, n);
  p->is_touched = lamc_loop_part(next, n);
  p->due = lamc_loop_part(next, n);
  p->waiting = lamc_loop_part(next, m);
}

/* Filled in place: a record of fifty pointers that is cleared and returned costs a tenth of a small loop. Of the parts that
 * eliminate, only those of the loop's own kind are set. */
static inline void lamc_loop_parts_of(const lamc_motion *motion, lamc_loop_parts *p) {
  const lamc_model *model = motion->model;
  p->motion = motion;
  p->pattern = model->pattern;
  p->n = model->rate_count;
  p->nq = model->coordinate_count;
  p->m = model->closure_count;
  p->is_sparse = model->pattern->step_count > 0;
  p->has_mass = model->residual == NULL;
  p->beyond = model->joint_count;
  p->cut = p->beyond - model->cut_count;
  const size_t n = (size_t)p->n, nq = (size_t)p->nq, m = (size_t)p->m;
  lamc_real *next = motion->work;
  p->mass = lamc_loop_part(&next, p->has_mass ? n * (n + 1) / 2 : 0);
  p->f = lamc_loop_part(&next, p->has_mass ? n : 0);
  p->j = lamc_loop_part(&next, (size_t)p->pattern->row_start[m]);
  p->extra = lamc_loop_part(&next, m);
  p->raw = lamc_loop_part(&next, (size_t)lamc_loop_raw_size(model));
  lamc_loop_place_elimination(p, &next);
  p->place = lamc_loop_part(&next, nq);
  p->taken = lamc_loop_part(&next, (size_t)lamc_loop_taken_size(model));
  p->count = -1;
  p->free = lamc_loop_part(&next, n * n);
  p->l = lamc_loop_part(&next, n * n);
  p->x = lamc_loop_part(&next, n);
  p->z = lamc_loop_part(&next, n);
  p->step = lamc_loop_part(&next, n);
  p->goal = lamc_loop_part(&next, m);
  p->norms = lamc_loop_part(&next, m);
  p->reach = lamc_loop_part(&next, m);
  p->mean = lamc_loop_part(&next, n + m);
  p->plain = lamc_loop_part(&next, n + m);
  p->qdot = lamc_loop_part(&next, nq);
  p->y = lamc_loop_part(&next, nq + n);
  p->settled = lamc_loop_part(&next, nq + n);
  p->state = lamc_loop_part(&next, LAMC_LOOPS_KEPT);
  if (p->is_sparse) p->steps = p->state[5] > 0 ? lamc_sparse_planned(p) : p->found;
}

#endif /* LAMC_LOOP_WORK_H */
