/* back_events.h, of lamc: what an event does to the derivatives, backwards: jumps.h, transposed.
 *
 * With tau = -dg / g', how much later the event comes, and slopes f before and after it, the state behind a switch moves by
 * dy + (f- - f+) tau: what it is weighed with goes to dy, and by way of tau to what the guard depends on. */
#ifndef LAMC_BACK_EVENTS_H
#define LAMC_BACK_EVENTS_H

#include "back_steps.h"
#include "cholesky.h"

static inline void lamc_no_gradient_from(lamc_adjoint *a, lamc_real t, lamc_no_gradient why, int guard) {
  if (a->lost != LAMC_GRADIENT_KNOWN) return;
  a->lost = (int)why;
  a->t_lost = t;
  a->lost_guard = guard;
}

/* Modes of the guards from here on */
static inline void lamc_set_modes(lamc_adjoint *a, const lamc_real *modes) {
  const lamc_model *model = a->motion.model;
  for (int g = 0; g < model->guard_count; g++)
    if (model->guard_modes[g] >= 0) a->motion.constants[model->guard_modes[g]] = modes[g];
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
  lamc_set_modes(a, e->later);
  lamc_slope(a, r, t, e->before, after);
  for (int i = 0; i < n; i++) {
    size = larger(size, fabs(after[i]) + fabs(before[i]));
    apart = larger(apart, fabs(after[i] - sum[i]));
  }
  if (count > 1 && !(apart <= sqrt(LAMC_EPSILON) * size))
    lamc_no_gradient_from(a, t, LAMC_GRADIENT_TOGETHER, last);
  memcpy(a->state, added, (size_t)n * sizeof *added);
}

/* Samples of the clocks that are struck, or of all (NULL), at the state before: see lamc_sample. What weighs what they hold goes
 * to what they sample. */
static inline void lamc_samples_back(lamc_adjoint *a, const room *r, lamc_real t, const lamc_real *y,
                                     const lamc_real *struck) {
  const lamc_model *model = a->motion.model;
  if (model->held_count == 0) return;
  lamc_real *held = a->sources + a->pullbacks->source_count, *w = r->weights;
  memset(w, 0, (size_t)(model->clock_count + model->held_count) * sizeof *w);
  for (int h = 0; h < model->held_count; h++) {
    if (struck != NULL && !(struck[model->clock_guards[model->held_clocks[h]]] > 0)) continue;
    w[model->clock_count + h] = held[h];
    held[h] = 0;
  }
  lamc_series_put(&a->motion, t);
  a->pullbacks->samples(a->motion.constants, t, y, y + r->nq, w, r->out);
  lamc_add_to(r->n, 1, r->out, a->state);
  lamc_add_to(r->k, 1, r->out + r->n, a->sources);
}

/* What solves for rates after an impact: M as factors, and the loops; how many equations count */
static inline int lamc_weigh_impact(lamc_adjoint *a, const room *r, lamc_real t, const lamc_real *y) {
  const lamc_model *model = a->motion.model;
  if (model->cut_count > 0) return lamc_loops_weigh(&a->motion, t, y, y + r->nq);
  if (lamc_is_system(model)) {
    lamc_motion_accelerate(&a->motion, t, y, y + r->nq, r->udot);
  } else {
    model->inertia(a->motion.constants, y, r->jacobian);
    lamc_cholesky(r->nu, r->jacobian, r->matrix);
  }
  return 0;
}

/* x (nu,), a force, replaced by the rates that its impulse makes, M x = force + J^T mu, J x = 0; and mu */
static inline void lamc_struck_rates(lamc_adjoint *a, const room *r, int count, lamc_real *x, lamc_real *mu) {
  if (a->motion.model->cut_count > 0) {
    lamc_pull_loops(a, r, count, x, mu);
  } else if (lamc_is_system(a->motion.model)) {
    lamc_system_response(&a->motion, x);
  } else {
    lamc_solve_lower(r->nu, r->matrix, x);
    lamc_solve_upper(r->nu, r->matrix, x);
  }
}

static inline lamc_real lamc_pair(int n, const lamc_real *v, const lamc_real *w) {
  lamc_real sum = 0;
  for (int i = 0; i < n; i++) sum += v[i] * w[i];
  return sum;
}

/* Of u+ = u - (1 + e) (W u) / (W x) x, M x = W^T + J^T mu, J x = 0, at one guard: `a->state` by u+ replaced by that by the state
 * before, and derivatives by t; 0: that is not what the run made of it. weights: of the pullback; gradient: W */
static inline int lamc_rates_back(lamc_adjoint *a, const room *r, const entry *e, int guard,
                                  const lamc_real *gradient, lamc_real restitution, lamc_real *by_time) {
  const int nu = r->nu, k = a->motion.model->guard_count;
  const lamc_real *u = e->before + r->nq, *after = e->after + r->nq;
  lamc_real *by_rates = a->state + r->nq, *w = r->weights, *row = w + k + (ptrdiff_t)guard * nu;
  lamc_real *z = w + k + (ptrdiff_t)k * nu + 1, *x = z + nu, *mu = x + nu, *eta = mu + r->m;
  const lamc_real v = lamc_pair(nu, gradient, u);
  const int count = lamc_weigh_impact(a, r, *e->t, e->before);
  memset(w, 0, (size_t)((ptrdiff_t)k * (1 + nu) + 1 + 2 * nu + 2 * r->m) * sizeof *w);
  memcpy(x, gradient, (size_t)nu * sizeof *x);
  lamc_struck_rates(a, r, count, x, mu);
  const lamc_real own = lamc_pair(nu, gradient, x), impulse = (1 + restitution) * v / own;
  lamc_real size = 0, apart = 0;
  for (int i = 0; i < nu; i++) {
    size = larger(size, fabs(u[i]) + fabs(impulse * x[i]));
    apart = larger(apart, fabs(u[i] - impulse * x[i] - after[i]));
  }
  if (!(v > 0) || !(apart <= sqrt(LAMC_EPSILON) * size)) return 0;
  const lamc_real share = lamc_pair(nu, by_rates, x);
  for (int i = 0; i < nu; i++) z[i] = impulse * (share / own * gradient[i] - by_rates[i]);
  lamc_struck_rates(a, r, count, z, eta);
  for (int i = 0; i < nu; i++) {
    row[i] = z[i] + impulse * share / own * x[i] - (1 + restitution) / own * share * u[i];
    by_rates[i] -= (1 + restitution) / own * share * gradient[i];
  }
  w[guard] = -v * share / own;
  w[k + (ptrdiff_t)k * nu] = 1;
  lamc_series_put(&a->motion, *e->t);
  a->pullbacks->impacts(a->motion.constants, *e->t, e->before, u, w, r->out);
  lamc_add_to(r->n, 1, r->out, a->state);
  lamc_add_to(r->k, 1, r->out + r->n + 1, a->sources);
  *by_time = r->out[r->n];
  return 1;
}

/* One impact: see lamc_meet_one. The modes are those before it. */
static inline void lamc_impact_back(lamc_adjoint *a, const room *r, const entry *e, int guard) {
  const lamc_real t = *e->t;
  const lamc_model *model = a->motion.model;
  lamc_real *before = r->begin, *slope = r->seed, by_time = 0;
  lamc_slope(a, r, t, e->before, before);
  lamc_set_modes(a, e->later);
  lamc_slope(a, r, t, e->after, slope);
  lamc_set_modes(a, e->modes);
  lamc_real of_delay = -lamc_pair(r->n, a->state, slope);
  lamc_series_put(&a->motion, t);
  model->impacts(a->motion.constants, t, e->before, r->weights);
  const lamc_real restitution = r->weights[guard], *row = r->weights + model->guard_count;
  memcpy(r->error, row + (ptrdiff_t)guard * r->nu, (size_t)r->nu * sizeof *slope);
  if (!lamc_rates_back(a, r, e, guard, r->error, restitution, &by_time)) {
    lamc_no_gradient_from(a, t, LAMC_GRADIENT_IMPACT, guard);
    return;
  }
  of_delay += lamc_pair(r->n, a->state, before) + by_time;
  if (*e->is_break > 0) return;
  const lamc_real rate = lamc_guard_rate(a, r, t, e->before, before, guard);
  if (rate == 0) {
    lamc_no_gradient_from(a, t, LAMC_GRADIENT_GRAZING, guard);
    return;
  }
  lamc_add_to(r->n, -of_delay / rate, r->out, a->state);
  lamc_add_to(r->k, -of_delay / rate, r->out + r->n + 1, a->sources);
}

/* `a->state`, derivatives by the state behind an event, replaced by those before it */
static inline void lamc_event_back(lamc_adjoint *a, const room *r, const entry *e) {
  const lamc_model *model = a->motion.model;
  int impacts = 0, ticks = 0, count = 0, guard = -1;
  for (int g = model->guard_count - 1; g >= 0; g--) {
    if (!(e->struck[g] > 0)) continue;
    guard = g;
    count++;
    impacts += model->guard_modes[g] == -1;
    ticks += model->guard_modes[g] < -1;
  }
  if (ticks > 0 && ticks == count) { /* at their times, whatever the parameters */
    lamc_samples_back(a, r, *e->t, e->before, e->struck);
    return;
  }
  if (count > 1 && impacts + ticks > 0) {
    lamc_no_gradient_from(a, *e->t, LAMC_GRADIENT_TOGETHER, guard);
    return;
  }
  lamc_set_modes(a, e->later);
  lamc_pull_settle(a, r, *e->t, e->after, a->state);
  lamc_set_modes(a, e->modes);
  if (impacts > 0) {
    lamc_impact_back(a, r, e, guard);
  } else {
    lamc_switches_back(a, r, e);
  }
}

#endif /* LAMC_BACK_EVENTS_H */
