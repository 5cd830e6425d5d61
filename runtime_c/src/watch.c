/* watch.c, of lamc: LAMC_AUTO: an explicit method, and an implicit one where that is faster.
 *
 * In: the steps of a run as they are accepted. Out: requests to change the method.
 * Never: looks at a clock; the same run makes the same choices.
 *
 * An explicit method whose steps are as long as stability allows, step after step, may be held back by stiffness; or it
 * may be following an oscillation that the tolerance asks for. Which of the two cannot be told from its steps, so the
 * implicit method is tried for some steps, and kept if it moves faster by the evaluations that it costs. Trials that
 * fail become rarer. */
#include "watch.h"

#include "events.h"
#include "implicit.h"

enum {
  ENOUGH_SUSPICION = 20,
  TRIAL_STEPS = 12, /* the first ones may be short or refused */
  FIRST_BACKOFF = 100,
  LONGEST_BACKOFF = 100000,
  CALM_STEPS = 30 /* steps over which an explicit method must look faster before it is taken again */
};

static const lamc_real TIGHT = 3e-6;         /* tolerance below which the higher orders are faster */
static const lamc_real LINEAR_ALGEBRA = 3.0; /* of an implicit step, in evaluations: factors and solutions */
static const lamc_real TIGHT_FOR_RADAU = 1e-7;
static const lamc_real VERY_STIFF =
    100.0; /* times the step: k / (m g L) of some 1e7 (measured: triple pendulum) */
static const lamc_real CLEARLY_WORTH_IT = 10.0; /* times as fast: the trial need not go on */
static const lamc_real WORTH_IT = 1.25;         /* times as fast */
static const lamc_real PART_OF_EXTENT =
    0.45; /* of the stable extent: where explicit steps come to be limited by it */

/* The error estimate of a method of high order does not see a jump of a higher derivative within its long steps (measured
 * with a cubic spline of 21 points at 1e-9: rk45 errs by 7e-9, dop853 by 5e-6). */
static int explicit_choice(const lamc_run *run) {
  if (run->ode.is_rough) return LAMC_RK45;
  return run->options.rtol < TIGHT ? LAMC_DOP853 : LAMC_RK45;
}

static int can_be_implicit(const lamc_run *run) {
  return run->ode.n > 0 && lamc_implicit_size(&run->ode) > 0;
}

/* Everything done so far, in evaluations */
static lamc_real cost(const lamc_run *run) {
  return (lamc_real)run->evaluations + (lamc_real)run->jacobians * run->ode.jacobian_cost +
         (lamc_real)run->factorisations * LINEAR_ALGEBRA;
}

static void mark(lamc_run *run) {
  run->watch.mark_t = run->t;
  run->watch.mark_cost = cost(run);
}

void lamc_watch_start(lamc_run *run, lamc_method which) {
  run->method = (int)which;
  if (which != LAMC_AUTO) return;
  run->watch.is_auto = 1;
  run->watch.backoff = FIRST_BACKOFF;
  run->method = explicit_choice(run);
  mark(run);
}

void lamc_watch_switch(lamc_run *run) {
  if (run->watch.next_method == 0) return;
  const int was_implicit =
      lamc_method_of(run->method)->stable_extent == 0.0 && run->watch.next_method == LAMC_RADAU5;
  run->method = run->watch.next_method;
  run->watch.next_method = 0;
  run->watch.suspicions = 0;
  run->has_jacobian = 0;
  run->has_polynomial = 0;
  run->dense = LAMC_DENSE_NONE; /* the other method's */
  if (!was_implicit) {
    lamc_run_restart(run);
    run->may_pass = 1;
  }
  mark(run);
}

static void ask_for(lamc_run *run, int which) {
  run->watch.next_method = which;
  if (run->switches < LAMC_SWITCHES_KEPT) {
    run->switch_t[run->switches] = run->t;
    run->switch_method[run->switches] = which;
  }
  run->switches++;
}

/* Takes the request for a trial out of the log again: nothing came of it. */
static void forget_trial(lamc_run *run) {
  run->switches--;
}

static void watch_explicit(lamc_run *run, const method *m) {
  lamc_watch *w = &run->watch;
  if (w->rest > 0) {
    if (--w->rest == 0) mark(run);
    return;
  }
  w->eigenvalue = m->eigenvalue(run);
  const int limited = run->h_last * w->eigenvalue > PART_OF_EXTENT * m->stable_extent;
  if (limited) {
    if (w->suspicions++ == 0) mark(run);
  } else {
    w->suspicions -= w->suspicions > 0;
  }
  if (w->suspicions < ENOUGH_SUSPICION) return;
  w->pace = (run->t - w->mark_t) / (cost(run) - w->mark_cost);
  w->probe_steps = TRIAL_STEPS;
  ask_for(run, LAMC_RODAS5P);
}

/* The last step of a trial decides: by then the step has grown to what the tolerance allows. */
static void watch_trial(lamc_run *run) {
  lamc_watch *w = &run->watch;
  const lamc_real pace = (run->t - w->mark_t) / (cost(run) - w->mark_cost);
  mark(run);
  if (--w->probe_steps > 0 && pace < CLEARLY_WORTH_IT * w->pace) return;
  w->probe_steps = 0;
  if (pace > WORTH_IT * w->pace) {
    w->backoff = FIRST_BACKOFF;
    /* Far beyond the fast motion Rosenbrock methods lose digits that Radau IIA keeps (1e-5: nine of ten); but they get
     * past it at first, and at tight tolerances their many steps are the cheaper ones */
    if (run->h_last * w->eigenvalue > VERY_STIFF && run->options.rtol > TIGHT_FOR_RADAU)
      ask_for(run, LAMC_RADAU5);
    return;
  }
  forget_trial(run);
  w->rest = w->backoff;
  if (w->backoff < LONGEST_BACKOFF) w->backoff *= 2;
  w->next_method = explicit_choice(run);
}

/* Largest sum of sizes in a row, over the entries of a block (rows, columns) of a matrix `width` wide */
static lamc_real largest_row_sum(const lamc_real *block, int rows, int columns, int width) {
  lamc_real most = 0.0;
  for (int i = 0; i < rows; i++) {
    lamc_real sum = 0.0;
    for (int j = 0; j < columns; j++) sum += fabs(block[(ptrdiff_t)i * width + j]);
    most = larger(most, sum);
  }
  return most;
}

/* An upper bound of the sizes of the eigenvalues of [0 I; A B] by row sums of A and B; where dq/dt is not u, of
 * [F G; A B], with what F and G bring by the way */
static lamc_real eigenvalue_bound(const lamc_run *run) {
  const implicit parts = lamc_implicit_parts(run, lamc_method_of(run->method)->slots);
  const int k = parts.k, nq = coordinates_of(&run->ode), nu = run->ode.n - nq;
  if (parts.has_structure)
    return larger(sqrt(largest_row_sum(parts.by_q, k, k, k)), largest_row_sum(parts.by_u, k, k, k));
  const lamc_real *below = parts.by_q + (ptrdiff_t)nq * k;
  const lamc_real flow = largest_row_sum(parts.by_q, nq, nq, k);
  const lamc_real gear = largest_row_sum(parts.by_q + nq, nq, nu, k);
  const lamc_real stiffness = largest_row_sum(below, nu, nq, k),
                  damping = largest_row_sum(below + nq, nu, nu, k);
  return larger(sqrt(stiffness * gear), larger(damping, flow));
}

static void watch_implicit(lamc_run *run, const method *m) {
  lamc_watch *w = &run->watch;
  const method *other = lamc_method_of(explicit_choice(run));
  const lamc_real their_step =
      PART_OF_EXTENT * other->stable_extent / larger(eigenvalue_bound(run), LAMC_LEAST);
  const lamc_real their_pace = their_step / other->evaluations;
  const lamc_real our_pace = run->h_last / (m->evaluations + run->ode.jacobian_cost + LINEAR_ALGEBRA);
  w->suspicions = their_pace > WORTH_IT * our_pace ? w->suspicions + 1 : 0;
  if (w->suspicions < CALM_STEPS) return;
  w->rest = FIRST_BACKOFF;
  ask_for(run, explicit_choice(run));
}

void lamc_watch_step(lamc_run *run) {
  if (!can_be_implicit(run)) return;
  const method *m = lamc_method_of(run->method);
  if (run->watch.probe_steps > 0) {
    watch_trial(run);
  } else if (m->eigenvalue != NULL) {
    watch_explicit(run, m);
  } else {
    watch_implicit(run, m);
  }
}
