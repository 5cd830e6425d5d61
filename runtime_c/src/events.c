/* events.c, of lamc: finds where a guard passes zero, and takes the run there.
 *
 * In: guards with their rates. Out: a step that ends on the event, and the state after it.
 * Never: lets a step cross an event, so that within a step the equation is smooth.
 *
 * The place is found on the continuous extension, and the step is then taken again with its end there, corrected by
 * Newton's method: the state at the event is as accurate as the method, not as its interpolation. */
#include "events.h"

#include "integrals.h"

enum { MAX_HALVINGS = 80, MAX_CORRECTIONS = 4, LONG_STREAK = 10 };

static const double TOO_CLOSE = 1e-10; /* of the time of the run: events nearer to each other pile up */

/* The parts of a run's room for events; k guards */
typedef struct room {
  int k;
  double *here;  /* (2, k): guards and their rates where the step began */
  double *there; /* (2, k): where it ended */
  double *trial; /* (2, k) */
  double *when;  /* (k,): s into the step; negative: no event */
  double *y;     /* (n,) */
} room;

long long lamc_events_size(const lamc_ode *ode) {
  return ode->guard_count > 0 ? 7LL * ode->guard_count + ode->n : 0;
}

static room room_of(const lamc_run *run) {
  room r;
  r.k = run->ode.guard_count;
  r.here = run->guards;
  r.there = r.here + 2 * r.k;
  r.trial = r.there + 2 * r.k;
  r.when = r.trial + 2 * r.k;
  r.y = r.when + r.k;
  return r;
}

void lamc_events_start(lamc_run *run, double *memory) {
  run->guards = memory;
  if (run->ode.guard_count == 0) return;
  if (run->ode.sense != NULL) run->ode.sense(run->ode.context, run->t, y_here(run));
  run->ode.guards(run->ode.context, run->t, y_here(run), memory);
}

/* One guard at `after` s into the step just taken */
static double guard_at(lamc_run *run, const room *r, int guard, double after) {
  (void)lamc_run_interpolate(run, smaller(run->t_old + after, run->t), r->y);
  run->ode.guards(run->ode.context, run->t_old + after, r->y, r->trial);
  return r->trial[guard];
}

/* Where the cubic through both ends, times `sign`, has its maximum inside, as a part of the step; 0: nowhere */
static double top_of_cubic(const room *r, int guard, double h, double sign, double *top) {
  const double a = sign * r->here[guard], b = sign * r->there[guard];
  const double sa = sign * h * r->here[r->k + guard], sb = sign * h * r->there[r->k + guard];
  *top = -HUGE_VAL;
  if (!(sa > 0.0 && sb < 0.0)) return 0.0;
  const double c3 = 2.0 * (a - b) + sa + sb, c2 = 3.0 * (b - a) - 2.0 * sa - sb;
  /* 3 c3 s^2 + 2 c2 s + sa = 0; the root at which the slope goes from positive to negative */
  const double root = sqrt(larger(c2 * c2 - 3.0 * c3 * sa, 0.0));
  const double s = sa / (root - c2);
  if (!(s > 0.0 && s < 1.0)) return 0.0;
  *top = a + s * (sa + s * (c2 + s * c3));
  return s;
}

/* The guard passes zero between low, where it is not positive, and high, where it is. Illinois: false position that
 * halves the weight of an end that stays. */
static double close_in(lamc_run *run, const room *r, int guard, double low, double at_low, double high,
                       double at_high) {
  const double enough = 4.0 * DBL_EPSILON * larger(fabs(run->t), run->h_last);
  for (int i = 0; i < MAX_HALVINGS && high - low > enough; i++) {
    double middle =
        at_high > at_low ? (low * at_high - high * at_low) / (at_high - at_low) : 0.5 * (low + high);
    if (!(middle > low && middle < high)) middle = 0.5 * (low + high);
    const double value = guard_at(run, r, guard, middle);
    if (value > 0.0) {
      high = middle;
      at_high = value;
      at_low *= 0.5;
    } else {
      low = middle;
      at_low = value;
      at_high *= 0.5;
    }
  }
  return high;
}

/* s into the step at which the guard becomes positive; negative: it does not. A guard may begin a little above zero after
 * an event there, by round-off, and may be above zero inside the step only, or below it inside only. */
static double find(lamc_run *run, const room *r, int guard) {
  const double h = run->h_last;
  const double begin = r->here[guard], end = r->there[guard];
  double extreme;
  if (begin > 0.0) {
    if (!(end > 0.0)) return -1.0;
    const double bottom = h * top_of_cubic(r, guard, h, -1.0, &extreme);
    const double value = bottom > 0.0 ? guard_at(run, r, guard, bottom) : 1.0;
    if (value <= 0.0) return close_in(run, r, guard, bottom, value, h, end);
    return end > begin ? 0.0 : -1.0;
  }
  if (end > 0.0) return close_in(run, r, guard, 0.0, begin, h, end);
  const double top = h * top_of_cubic(r, guard, h, 1.0, &extreme);
  if (top == 0.0 || extreme < -0.1 * larger(fabs(begin), fabs(end))) return -1.0;
  const double value = guard_at(run, r, guard, top);
  return value > 0.0 ? close_in(run, r, guard, 0.0, begin, top, value) : -1.0;
}

/* Fills when; the first guard to become positive, -1 if none does */
static int find_first(lamc_run *run, const room *r) {
  int first = -1;
  for (int g = 0; g < r->k; g++) {
    r->when[g] = find(run, r, g);
    if (r->when[g] >= 0.0 && (first < 0 || r->when[g] < r->when[first])) first = g;
  }
  return first;
}

/* Takes the step again so that it ends where the guard is zero. LAMC_PAUSED: the method refuses the shorter step. */
static lamc_status step_to(lamc_run *run, const room *r, int guard) {
  const double shortest = 4.0 * DBL_EPSILON * fabs(run->t);
  double h = r->when[guard];
  run->accepted--;
  run->rejected++;
  for (int i = 0; i < MAX_CORRECTIONS; i++) {
    double squared;
    lamc_run_move_back(run);
    run->has_polynomial = 0;
    run->has_jacobian = 0;
    if (h <= shortest) return LAMC_OK; /* the event is where the step began */
    const lamc_status taken = lamc_run_take(run, h, 0, &squared);
    if (taken == LAMC_PAUSED) {
      run->h = 0.5 * h;
      run->row_due = 0; /* the row where the run stands again is written */
      run->rejected++;
    }
    if (taken != LAMC_OK) return taken;
    run->ode.guards(run->ode.context, run->t, y_here(run), r->there);
    const double rate = r->there[r->k + guard];
    const double correction = rate > 0.0 ? -r->there[guard] / rate : 0.0;
    if (fabs(correction) <= 4.0 * DBL_EPSILON * larger(fabs(run->t), h) || h + correction <= 0.0) break;
    if (fabs(correction) > 0.5 * h || i + 1 == MAX_CORRECTIONS) break;
    h += correction;
    run->rejected++;
  }
  run->accepted++;
  return LAMC_OK;
}

/* Counts events that follow each other ever faster. */
static lamc_status keep_count(lamc_run *run, int guard) {
  const double limit = TOO_CLOSE * larger(fabs(run->t), fabs(run->t_end));
  const double gap = run->events > 0 ? run->t - run->t_event : HUGE_VAL;
  run->event_streak = gap < limit || gap < run->event_gap ? run->event_streak + 1 : 0;
  run->event_gap = gap;
  run->t_event = run->t;
  run->event_guard = guard;
  run->event_due = 1;
  run->events++;
  return gap < limit && run->event_streak > LONG_STREAK + run->ode.guard_count ? LAMC_EVENTS_PILE_UP
                                                                               : LAMC_OK;
}

lamc_status lamc_events_after_step(lamc_run *run) {
  if (run->ode.guard_count == 0) {
    lamc_integrals_step(run);
    return LAMC_OK;
  }
  const room r = room_of(run);
  run->ode.guards(run->ode.context, run->t, y_here(run), r.there);
  const int first = find_first(run, &r);
  if (first < 0) {
    memcpy(r.here, r.there, 2 * (size_t)r.k * sizeof *r.here);
    lamc_integrals_step(run);
    return LAMC_OK;
  }
  const double together = r.when[first] + 64.0 * DBL_EPSILON * larger(fabs(run->t), run->h_last);
  const int is_here = r.when[first] <= 4.0 * DBL_EPSILON * fabs(run->t);
  lamc_status status = step_to(run, &r, first);
  if (status != LAMC_OK) return status;
  if (!is_here) { /* rows within the step are still to be written: the polynomial must not see what the event does */
    double *y = r.y;
    (void)lamc_run_interpolate(run, 0.5 * (run->t_old + run->t), y);
  }
  lamc_integrals_step(run);
  lamc_integrals_before(run);
  for (int g = 0; g < r.k; g++) {
    if (g != first && !(r.when[g] >= 0.0 && r.when[g] <= together)) continue;
    status = run->ode.event(run->ode.context, run->t, y_here(run), g);
    if (status != LAMC_OK) return status;
    status = keep_count(run, g);
    if (status != LAMC_OK) return status;
  }
  lamc_integrals_after(run);
  run->ode.guards(run->ode.context, run->t, y_here(run), r.here);
  evaluate(run, run->t, y_here(run), slope_here(run));
  run->row_due = run->t_eval == NULL;
  lamc_run_restart(run);
  return LAMC_OK;
}
