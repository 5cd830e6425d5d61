/* loop_search.h, of lamc: an order in which rows of large loops are eliminated, looked for from nothing.
 *
 * In:    the rows of J. Out: which equations hold, by the row and the rate of each step, and what is left of the rows.
 * Never: looks at a plan: what comes out depends on the state alone.
 *
 * A row is freed of the rates that earlier steps eliminated, and gives up the largest of what is left (threshold
 * pivoting; I. S. Duff, A. M. Erisman, J. K. Reid, "Direct methods for sparse matrices"). Rows of which little is left
 * wait until the others are through. */
#ifndef LAMC_LOOP_SEARCH_H
#define LAMC_LOOP_SEARCH_H

#include "loop_parts.h"

enum { WORK_OF_STEP = 20 }; /* that a row is freed of, but for its entries */

static const lamc_real OF_LARGEST = LAMC_R(0.1); /* what a row has left of one at least, or it waits */

/* What is left of `row` by a step, and the largest of it */
static inline lamc_real lamc_sparse_collect(const lamc_loop_parts *p, int first, int beyond) {
  const lamc_steps *s = &p->steps;
  lamc_real most = 0;
  for (int e = first; e < beyond; e++) {
    const int rate = lamc_at(s->left, e);
    const lamc_real value = p->row[rate];
    s->value[e] = value;
    p->row[rate] = 0;
    most = fabs(value) > most ? fabs(value) : most;
  }
  return most;
}

static inline void lamc_sparse_scatter(const lamc_loop_parts *p, int row) {
  for (int e = p->pattern->row_start[row]; e < p->pattern->row_start[row + 1]; e++) {
    p->row[p->pattern->column[e]] = p->j[e];
  }
}

/* Takes from `row` what it has of the rate that step `k` eliminated; the multiple of that step */
static inline lamc_real lamc_sparse_update(const lamc_loop_parts *p, int k) {
  const lamc_steps *s = &p->steps;
  const int first = lamc_at(s->left_start, k), beyond = lamc_at(s->left_start, k + 1);
  const int rate = lamc_at(s->left, first);
  const lamc_real factor = p->row[rate] * s->inverse[k];
  p->row[rate] = 0;
  for (int e = first + 1; e < beyond; e++) p->row[lamc_at(s->left, e)] -= factor * s->value[e];
  lamc_loop_count_work(p, (lamc_real)(WORK_OF_STEP + 2 * (beyond - first)));
  return factor;
}

/* 1 if what a row has left may be round-off: where pivots in a chain are small, each takes that of the one before so many
 * times, and a row that depends on others has something left in the end */
static inline int lamc_sparse_is_noise(lamc_real peak, lamc_real noise) {
  return !(noise * LAMC_EPSILON < NOISE * peak);
}

/* A step that is to be taken from the row: a binary heap, the earliest first */
static inline void lamc_sparse_push(const lamc_loop_parts *p, int count, lamc_real step) {
  int at = count;
  for (; at > 0 && p->due[(at - 1) / 2] > step; at = (at - 1) / 2) p->due[at] = p->due[(at - 1) / 2];
  p->due[at] = step;
}

/* The earliest of `count`, which is taken out */
static inline int lamc_sparse_pop(const lamc_loop_parts *p, int count) {
  const lamc_real earliest = p->due[0], last = p->due[count - 1];
  int at = 0;
  for (int under = 1; under < count - 1; under = 2 * at + 1) {
    if (under + 1 < count - 1 && p->due[under + 1] < p->due[under]) under++;
    if (!(p->due[under] < last)) break;
    p->due[at] = p->due[under];
    at = under;
  }
  p->due[at] = last;
  return (int)earliest;
}

/* How much a row knows while it is freed */
typedef struct lamc_row_known {
  int rates; /* the first of p->touched */
  int due;   /* steps that eliminated one of them */
} lamc_row_known;

/* A rate that may be new to the row */
static inline void lamc_sparse_touch(const lamc_loop_parts *p, lamc_row_known *known, int rate) {
  if (p->is_touched[rate] != 0) return;
  p->touched[known->rates++] = (lamc_real)rate;
  p->is_touched[rate] = (lamc_real)known->rates;
  if (p->step_of[rate] >= 0) lamc_sparse_push(p, known->due++, p->step_of[rate]);
}

/* A rate that the row no longer knows: the last of the touched takes its place */
static inline void lamc_sparse_untouch(const lamc_loop_parts *p, lamc_row_known *known, int rate) {
  const lamc_real place = p->is_touched[rate], last = p->touched[--known->rates];
  p->touched[(int)place - 1] = last;
  p->is_touched[(int)last] = place;
  p->is_touched[rate] = 0;
}

/* Row `row` of J freed of what `count` steps eliminated, its updates written behind theirs; how many rates are left in
 * it, among the touched */
static inline int lamc_sparse_free(const lamc_loop_parts *p, int row, int count) {
  const lamc_steps *s = &p->steps;
  lamc_row_known known = {0, 0};
  int update = (int)s->update_start.found[count];
  for (int e = p->pattern->row_start[row]; e < p->pattern->row_start[row + 1]; e++) {
    lamc_sparse_touch(p, &known, p->pattern->column[e]);
  }
  lamc_sparse_scatter(p, row);
  while (known.due > 0) {
    const int step = lamc_sparse_pop(p, known.due--);
    lamc_sparse_untouch(p, &known, (int)s->left.found[(int)s->left_start.found[step]]);
    for (int e = (int)s->left_start.found[step] + 1; e < (int)s->left_start.found[step + 1]; e++) {
      lamc_sparse_touch(p, &known, (int)s->left.found[e]);
    }
    s->update.found[update] = (lamc_real)step;
    s->factor[update++] = lamc_sparse_update(p, step);
  }
  s->update_start.found[count + 1] = (lamc_real)update;
  for (int k = 0; k < known.rates; k++) p->is_touched[(int)p->touched[k]] = 0;
  return known.rates;
}

/* The largest of what is left */
static inline lamc_real lamc_sparse_peak(const lamc_loop_parts *p, int known) {
  lamc_real most = 0;
  for (int k = 0; k < known; k++) {
    const lamc_real value = fabs(p->row[(int)p->touched[k]]);
    most = value > most ? value : most;
  }
  return most;
}

static inline void lamc_sparse_forget(const lamc_loop_parts *p, int known) {
  for (int k = 0; k < known; k++) p->row[(int)p->touched[k]] = 0;
}

/* Which of the rates that are left a row gives up: the plan's, which fills up few rows, unless another is much larger */
static inline int lamc_sparse_choose(const lamc_loop_parts *p, int place, int known, lamc_real peak) {
  const lamc_pattern *plan = p->pattern;
  if (place < plan->step_count) {
    const int planned = plan->left[plan->left_start[place]];
    if (fabs(p->row[planned]) > OF_LARGEST * peak) return planned;
  }
  int best = (int)p->touched[0];
  for (int k = 1; k < known; k++) {
    const int rate = (int)p->touched[k];
    if (fabs(p->row[rate]) > fabs(p->row[best])) best = rate;
  }
  return best;
}

/* The row that was freed, at `place` in the plan's order, becomes step `count` */
static inline void lamc_sparse_take(const lamc_loop_parts *p, int place, int count, int known,
                                    lamc_real peak) {
  const lamc_steps *s = &p->steps;
  const int first = (int)s->left_start.found[count], best = lamc_sparse_choose(p, place, known, peak);
  int beyond = first + 1;
  s->left.found[first] = (lamc_real)best;
  for (int k = 0; k < known; k++) {
    const int rate = (int)p->touched[k];
    if (rate != best && p->row[rate] != 0) s->left.found[beyond++] = (lamc_real)rate;
  }
  s->row.found[count] = (lamc_real)p->pattern->step_row[place];
  s->left_start.found[count + 1] = (lamc_real)beyond;
  s->peak[count] = lamc_sparse_collect(p, first, beyond);
  s->inverse[count] = 1 / s->value[first];
  p->step_of[best] = (lamc_real)count;
}

/* What is known while an order is looked for */
typedef struct lamc_search {
  int count;      /* steps */
  int waiting;    /* rows that wait: the first of p->waiting */
  lamc_real most; /* the largest that is left in any of them, where it was last looked at */
} lamc_search;

/* One look at the rows that wait: those with `least` left become steps, up to `rank` */
static inline void lamc_sparse_round(const lamc_loop_parts *p, int rank, lamc_real least, lamc_search *now) {
  const int waiting = now->waiting;
  now->waiting = 0;
  now->most = 0;
  for (int k = 0; k < waiting && now->count < rank; k++) {
    const int place = (int)p->waiting[k];
    const int known = lamc_sparse_free(p, p->pattern->step_row[place], now->count);
    const lamc_real peak = lamc_sparse_peak(p, known);
    if (peak >= least) {
      lamc_sparse_take(p, place, now->count++, known, peak);
      continue;
    }
    lamc_sparse_forget(p, known);
    p->waiting[now->waiting++] = (lamc_real)place;
    now->most = peak > now->most ? peak : now->most;
  }
}

/* All rows wait, in their order */
static inline void lamc_sparse_line_up(const lamc_loop_parts *p) {
  for (int i = 0; i < p->m; i++) p->waiting[i] = (lamc_real)i;
}

/* From nothing; how many equations were taken. What fades is let go as in lamc_dense_order. */
static inline int lamc_sparse_find(const lamc_loop_parts *p, int rank) {
  const lamc_steps *s = &p->steps;
  lamc_search now = {0, p->m, 0};
  lamc_sparse_line_up(p);
  for (int i = 0; i < p->n; i++) p->step_of[i] = -1;
  memset(p->is_touched, 0, (size_t)p->n * sizeof *p->is_touched);
  s->update_start.found[0] = s->left_start.found[0] = 0;
  lamc_sparse_round(p, rank, OF_LARGEST, &now);
  while (now.count < rank && now.most > PASSING) {
    const lamc_real least = OF_LARGEST * now.most;
    lamc_sparse_round(p, rank, least > PASSING ? least : PASSING, &now);
  }
  if (now.count < rank) {
    while (now.count > 0 && s->peak[now.count - 1] < TOGETHER) now.count--;
  }
  return now.count;
}

#endif /* LAMC_LOOP_SEARCH_H */
