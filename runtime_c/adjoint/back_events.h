/* back_events.h, of lamc: what an event does to the derivatives, backwards: jumps.h, transposed.
 *
 * With tau = -dg / g', how much later the event comes, and slopes f before and after it, the state behind a switch moves by
 * dy + (f- - f+) tau: what it is weighed with goes to dy, and by way of tau to what the guard depends on. */
#ifndef LAMC_BACK_EVENTS_H
#define LAMC_BACK_EVENTS_H

#include "back_steps.h"

static inline void lamc_no_gradient_from(lamc_adjoint *a, lamc_real t, lamc_no_gradient why, int guard) {
  if (a->lost != LAMC_GRADIENT_KNOWN) return;
  a->lost = (int)why;
  a->t_lost = t;
  a->lost_guard = guard;
}

/* Derivatives of a guard by q, u, t and sources, in r->out. Its rate along a slope; 0: it is touched and not passed */
static inline lamc_real lamc_guard_rate(lamc_adjoint *a, const room *r, lamc_real t, const lamc_real *y,
                                        const lamc_real *slope, int guard) {
  memset(r->weights, 0, (size_t)a->motion.model->guard_count * sizeof *r->weights);
  r->weights[guard] = 1;
  lamc_series_put(&a->motion, t);
  a->pullbacks->guards(a->motion.constants, t, y, y + r->nq, r->weights, r->out);
  lamc_real rate = r->out[r->n], size = fabs(rate);
  for (int i = 0; i < r->n; i++) {
    rate += r->out[i] * slope[i];
    size += fabs(r->out[i] * slope[i]);
  }
  return fabs(rate) > sqrt(LAMC_EPSILON) * size ? rate : 0;
}

/* Switches at one instant, whose effects on dy/dt must add up: see lamc_meet_switches. The modes are those before them. */
static inline void lamc_switches_back(lamc_adjoint *a, const room *r, const entry *e) {
  const lamc_model *model = a->motion.model;
  const int n = r->n;
  const lamc_real t = *e->t;
  lamc_real *before = r->begin, *after = r->seed, *sum = r->error, *added = r->first, size = 0, apart = 0;
  int last = -1, count = 0;
  memcpy(added, a->state, (size_t)n * sizeof *added);
  lamc_slope(a, r, t, e->before, before);
  memcpy(sum, before, (size_t)n * sizeof *sum);
  for (int g = 0; g < model->guard_count; g++) {
    if (!(e->struck[g] > 0)) continue;
    lamc_real *mode = &a->motion.constants[model->guard_modes[g]], of_delay = 0;
    *mode = 1 - *mode;
    lamc_slope(a, r, t, e->before, after);
    *mode = 1 - *mode;
    last = g;
    count++;
    for (int i = 0; i < n; i++) {
      of_delay += a->state[i] * (before[i] - after[i]);
      sum[i] -= before[i] - after[i];
    }
    if (*e->is_break > 0) continue; /* at its time, whatever the parameters */
    const lamc_real rate = lamc_guard_rate(a, r, t, e->before, before, g);
    if (rate == 0) {
      lamc_no_gradient_from(a, t, LAMC_GRADIENT_GRAZING, g);
      return;
    }
    lamc_add_to(n, -of_delay / rate, r->out, added);
    lamc_add_to(r->k, -of_delay / rate, r->out + n + 1, a->sources);
  }
  for (int g = 0; g < model->guard_count; g++) {
    if (!(e->struck[g] > 0)) continue;
    a->motion.constants[model->guard_modes[g]] = 1 - e->modes[g];
  }
  lamc_slope(a, r, t, e->before, after);
  for (int i = 0; i < n; i++) {
    size = larger(size, fabs(after[i]) + fabs(before[i]));
    apart = larger(apart, fabs(after[i] - sum[i]));
  }
  if (count > 1 && !(apart <= sqrt(LAMC_EPSILON) * size))
    lamc_no_gradient_from(a, t, LAMC_GRADIENT_TOGETHER, last);
  memcpy(a->state, added, (size_t)n * sizeof *added);
}

/* `a->state`, derivatives by the state behind an event, replaced by those before it */
static inline void lamc_event_back(lamc_adjoint *a, const room *r, const entry *e) {
  const lamc_model *model = a->motion.model;
  for (int g = 0; g < model->guard_count; g++) {
    if (e->struck[g] > 0 && model->guard_modes[g] < 0) {
      lamc_no_gradient_from(a, *e->t, LAMC_GRADIENT_IMPACT, g);
      return;
    }
  }
  for (int g = 0; g < model->guard_count; g++) {
    if (e->struck[g] > 0) a->motion.constants[model->guard_modes[g]] = 1 - e->modes[g];
  }
  lamc_pull_settle(a, r, *e->t, e->after, a->state);
  for (int g = 0; g < model->guard_count; g++) {
    if (e->struck[g] > 0) a->motion.constants[model->guard_modes[g]] = e->modes[g];
  }
  lamc_switches_back(a, r, e);
}

#endif /* LAMC_BACK_EVENTS_H */
