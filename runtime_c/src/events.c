/* events.c, of lamc: finds where a guard passes zero, and takes the run there.
 *
 * In: guards with their rates. Out: a step that ends on the event, and the state after it.
 * Never: lets a step cross an event that it saw, so that within a step the equation is smooth; goes beyond the end of the
 * step that was accepted, where no error was estimated.
 *
 * The place is found on the continuous extension, and the step is then taken again with its end there, corrected by
 * Newton's method: the state at the event is as accurate as the method, not as its interpolation.
 *
 * A guard that its rates at the ends of a step could take to zero is looked at in PARTS parts of the step, and in each by
 * the cubic through both ends. What that misses: a guard that is negative at both ends, farther from zero than the rates
 * there reach, and yet positive between; and one that is positive for less than a part and bends more than a cubic. */
#include "events.h"

#include "integrals.h"

enum { PARTS = 8, MAX_HALVINGS = 100, MAX_CORRECTIONS = 6, LONG_STREAK = 10 };

static const lamc_real TOO_CLOSE = 1e-10; /* of the time of the run: events nearer to each other pile up */
static const lamc_real AT_ONCE =
    1e-10; /* of a step, besides the tolerance: guards so near to zero, at their rates, are struck too */

/* The parts of a run's room for events; k guards */
typedef struct room {
  int k;
  lamc_real
      *here; /* (PARTS + 1, 2, k): guards and their rates along the step; the first are where it began */
  lamc_real *there; /* (2, k), the last of them: where it ended */
  lamc_real *trial; /* (2, k) */
  lamc_real *when;  /* (k,): s into the step; negative: no event */
  lamc_real *due; /* (k,): 1 for the guards that are struck; then those not written yet, the next one last */
  lamc_real *y;   /* (n,) */
} room;

/* Two ends of a part of the step: s into it, the guard and its rate there */
typedef struct part {
  lamc_real low, at_low, rate_low;
  lamc_real high, at_high, rate_high;
} part;

long long lamc_events_size(const lamc_ode *ode) {
  return ode->guard_count > 0 ? (2LL * (PARTS + 1) + 4) * ode->guard_count + ode->n : 0;
}

static room room_of(const lamc_run *run) {
  room r;
  r.k = run->ode.guard_count;
  r.here = run->guards;
  r.there = r.here + (ptrdiff_t)PARTS * 2 * r.k;
  r.trial = r.there + 2 * r.k;
  r.when = r.trial + 2 * r.k;
  r.due = r.when + r.k;
  r.y = r.due + r.k;
  return r;
}

void lamc_events_start(lamc_run *run, lamc_real *memory) {
  run->guards = memory;
  if (run->ode.guard_count == 0) return;
  if (run->ode.sense != NULL) run->ode.sense(run->ode.context, run->t, y_here(run));
  run->ode.guards(run->ode.context, run->t, y_here(run), memory);
}

/* ---- Where a guard becomes positive ------------------------------------------------------------------------ */

/* All guards and their rates at `after` s into the step just taken */
static void guards_at(lamc_run *run, const room *r, lamc_real after, lamc_real *values) {
  const lamc_real t = smaller(run->t_old + after, run->t);
  (void)lamc_run_interpolate(run, t, r->y);
  run->ode.guards(run->ode.context, t, r->y, values);
}

static lamc_real guard_at(lamc_run *run, const room *r, int guard, lamc_real after) {
  guards_at(run, r, after, r->trial);
  return r->trial[guard];
}

/* 1 if a guard is positive where the step ended, or within reach of zero at the rates that it has at the ends */
static int is_near(const lamc_run *run, const room *r) {
  for (int g = 0; g < r->k; g++) {
    const lamc_real rate = larger(fabs(r->here[r->k + g]), fabs(r->there[r->k + g]));
    if (r->there[g] > 0.0 || smaller(fabs(r->here[g]), fabs(r->there[g])) <= run->h_last * rate) return 1;
  }
  return 0;
}

/* Where the cubic through both ends, times `sign`, has its maximum inside, s into the step; negative: nowhere */
static lamc_real top_of_cubic(const part *p, lamc_real sign, lamc_real *top) {
  const lamc_real h = p->high - p->low, a = sign * p->at_low, b = sign * p->at_high;
  const lamc_real sa = sign * h * p->rate_low, sb = sign * h * p->rate_high;
  *top = -HUGE_VAL;
  if (!(sa > 0.0 && sb < 0.0)) return -1.0;
  const lamc_real c3 = 2.0 * (a - b) + sa + sb, c2 = 3.0 * (b - a) - 2.0 * sa - sb;
  /* 3 c3 s^2 + 2 c2 s + sa = 0; the root at which the slope goes from positive to negative */
  const lamc_real root = sqrt(larger(c2 * c2 - 3.0 * c3 * sa, 0.0));
  const lamc_real s = sa / (root - c2);
  if (!(s > 0.0 && s < 1.0)) return -1.0;
  *top = a + s * (sa + s * (c2 + s * c3));
  return p->low + s * h;
}

/* The guard passes zero between low, where it is not positive, and high, where it is: s into the step at which it is. The
 * bracket shrinks as by false position, and never takes more than one evaluation beyond halving: method ITP, I. F. D.
 * Oliveira, R. H. C. Takahashi, ACM Trans. Math. Softw. 47 (2020) 5, with k1 = 0.2 / (high - low), k2 = 2, n0 = 1. */
static lamc_real close_in(lamc_run *run, const room *r, int guard, lamc_real low, lamc_real at_low,
                          lamc_real high, lamc_real at_high) {
  const lamc_real enough = 2.0 * LAMC_EPSILON * larger(fabs(run->t), run->h_last);
  const lamc_real first = high - low;
  lamc_real reach = enough; /* enough 2^(halvings + 1): how wide the bracket may be yet */
  while (reach < first) reach *= 2.0;
  for (int i = 0; i < MAX_HALVINGS && high - low > 2.0 * enough; i++, reach *= 0.5) {
    const lamc_real width = high - low, half = low + 0.5 * width;
    const lamc_real line = at_high > at_low ? (low * at_high - high * at_low) / (at_high - at_low) : half;
    const lamc_real sign = half >= line ? 1.0 : -1.0, shift = 0.2 / first * width * width;
    const lamc_real aside = shift <= fabs(half - line) ? line + sign * shift : half;
    const lamc_real radius = larger(reach - 0.5 * width, 0.0);
    const lamc_real middle = fabs(aside - half) <= radius ? aside : half - sign * radius;
    if (!(middle > low && middle < high)) break; /* round-off */
    const lamc_real value = guard_at(run, r, guard, middle);
    if (value > 0.0) {
      high = middle;
      at_high = value;
    } else {
      low = middle;
      at_low = value;
    }
  }
  return high;
}

/* s into the step at which the guard becomes positive within a part of it; negative: it does not. *is_below: whether the
 * guard has been below zero before the part, then before its end. */
static lamc_real find_in(lamc_run *run, const room *r, int guard, const part *p, int *is_below) {
  const int was_below = *is_below;
  lamc_real extreme;
  *is_below = was_below || p->at_high <= 0.0;
  if (!was_below) {
    const lamc_real bottom = p->at_high > 0.0 ? top_of_cubic(p, -1.0, &extreme) : -1.0;
    const lamc_real value = bottom > 0.0 ? guard_at(run, r, guard, bottom) : 1.0;
    return value <= 0.0 ? close_in(run, r, guard, bottom, value, p->high, p->at_high) : -1.0;
  }
  if (p->at_high > 0.0) return close_in(run, r, guard, p->low, p->at_low, p->high, p->at_high);
  const lamc_real top = top_of_cubic(p, 1.0, &extreme);
  if (top < 0.0 || extreme < -0.1 * larger(fabs(p->at_low), fabs(p->at_high))) return -1.0;
  const lamc_real value = guard_at(run, r, guard, top);
  return value > 0.0 ? close_in(run, r, guard, p->low, p->at_low, top, value) : -1.0;
}

/* s into the step at which the guard becomes positive for the first time; negative: it does not. A guard may begin a little
 * above zero after an event there, by round-off, and must have been below before it counts; one that only rises from
 * there counts at once. */
static lamc_real find(lamc_run *run, const room *r, int guard) {
  const lamc_real h = run->h_last;
  int is_below = r->here[guard] <= 0.0;
  for (int i = 0; i < PARTS; i++) {
    const lamc_real *a = r->here + (ptrdiff_t)2 * r->k * i + guard, *b = a + 2 * r->k;
    const part p = {h * i / (lamc_real)PARTS, a[0], a[r->k], h * (i + 1) / (lamc_real)PARTS, b[0], b[r->k]};
    const lamc_real when = find_in(run, r, guard, &p, &is_below);
    if (when >= 0.0) return when;
  }
  return !is_below && r->there[guard] > r->here[guard] ? 0.0 : -1.0;
}

/* Fills when; the first guard to become positive, -1 if none does */
static int find_first(lamc_run *run, const room *r) {
  int first = -1;
  for (int i = 1; i < PARTS; i++)
    guards_at(run, r, run->h_last * i / (lamc_real)PARTS, r->here + (ptrdiff_t)2 * r->k * i);
  for (int g = 0; g < r->k; g++) {
    r->when[g] = find(run, r, g);
    if (r->when[g] >= 0.0 && (first < 0 || r->when[g] < r->when[first])) first = g;
  }
  return first;
}

/* ---- The step that ends there ------------------------------------------------------------------------------ */

/* Takes the step again so that it ends where the guard is zero. LAMC_PAUSED: the method refuses the shorter step.
 * *is_reached: 0 where the guard is still negative at the end of the step, since the continuous extension erred. */
static lamc_status step_to(lamc_run *run, const room *r, int guard, int *is_reached) {
  const lamc_real shortest = 4.0 * LAMC_EPSILON * fabs(run->t);
  const lamc_real whole = run->h_last, t_whole = run->t;
  lamc_real h = r->when[guard];
  /* no farther than a part of the step from where the continuous extension passes zero: another zero may lie there */
  lamc_real low = larger(h - whole / (lamc_real)PARTS, 0.0),
            high = smaller(h + whole / (lamc_real)PARTS, whole);
  run->accepted--;
  run->rejected++;
  *is_reached = 1;
  for (int i = 1;; i++) {
    lamc_real squared;
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
    if (h == whole) run->t = t_whole; /* the end of a run, to the last digit */
    run->ode.guards(run->ode.context, run->t, y_here(run), r->trial);
    const lamc_real value = r->trial[guard], rate = r->trial[r->k + guard];
    const lamc_real correction = rate > 0.0 ? -value / rate : 0.0;
    const int is_there = rate > 0.0 && fabs(correction) <= 4.0 * LAMC_EPSILON * larger(fabs(run->t), h);
    *is_reached = value >= 0.0 || is_there;
    if (is_there || !(rate > 0.0) || i == MAX_CORRECTIONS) break;
    if (value > 0.0) {
      high = h;
    } else {
      low = h;
    }
    const lamc_real next =
        h + correction > low && h + correction < high ? h + correction : 0.5 * (low + high);
    if (!(next > 0.0)) break;
    h = next;
    run->rejected++;
  }
  run->accepted++;
  return LAMC_OK;
}

/* Which guards are struck where the run stands: those that the step showed to be, and those that differ from them by
 * less than a step may be wrong. An impact that goes with another at one instant must not come after it: which of the two
 * was first would be the choice of an error. */
static void find_struck(lamc_run *run, const room *r, int first, lamc_real whole) {
  const lamc_real together = r->when[first] + 64.0 * LAMC_EPSILON * larger(fabs(run->t), whole);
  const lamc_real near = (AT_ONCE + run->options.rtol) * whole + 64.0 * LAMC_EPSILON * fabs(run->t);
  run->ode.guards(run->ode.context, run->t, y_here(run), r->trial);
  for (int g = 0; g < r->k; g++) {
    const lamc_real value = r->trial[g], rate = r->trial[r->k + g];
    const int is_seen = r->when[g] >= 0.0 && r->when[g] <= together;
    const int is_close = rate > 0.0 && fabs(value) <= near * rate;
    r->due[g] = g == first || is_seen || is_close ? 1.0 : 0.0;
  }
}

/* Counts events that follow each other ever faster. */
static lamc_status keep_count(lamc_run *run, int guard) {
  const lamc_real whole =
      run->t_end < DBL_MAX ? fabs(run->t_end) : 0.0; /* a run without an end has no length */
  const lamc_real limit = TOO_CLOSE * larger(fabs(run->t), whole);
  const lamc_real gap = run->events > 0 ? run->t - run->t_event : HUGE_VAL;
  run->event_streak = gap < limit || gap < run->event_gap ? run->event_streak + 1 : 0;
  run->event_gap = gap;
  run->t_event = run->t;
  run->event_guard = guard;
  run->events++;
  return gap < limit && run->event_streak > LONG_STREAK + run->ode.guard_count ? LAMC_EVENTS_PILE_UP
                                                                               : LAMC_OK;
}

/* Counts all guards that were struck, and lists them for the rows. */
static lamc_status count_struck(lamc_run *run, const room *r) {
  lamc_status status = LAMC_OK;
  int count = 0;
  for (int g = 0; g < r->k; g++) {
    if (!(r->due[g] > 0.0)) continue;
    const lamc_status kept = keep_count(run, g);
    if (status == LAMC_OK) status = kept;
    r->due[count++] = (lamc_real)g;
  }
  for (int i = 0; i < count / 2; i++) {
    const lamc_real keep = r->due[i];
    r->due[i] = r->due[count - 1 - i];
    r->due[count - 1 - i] = keep;
  }
  run->event_due = count;
  return status;
}

int lamc_events_due(const lamc_run *run) {
  return (int)room_of(run).due[run->event_due - 1];
}

/* After a step without an event */
static void go_on(lamc_run *run, const room *r, const lamc_real *guards) {
  memcpy(r->here, guards, 2 * (size_t)r->k * sizeof *r->here);
  lamc_integrals_step(run);
}

/* What the guards that are struck do, where the run stands */
static lamc_status go_through(lamc_run *run, const room *r) {
  lamc_integrals_before(run);
  lamc_status status = run->ode.event(run->ode.context, run->t, y_here(run), r->due);
  if (status == LAMC_OK) status = count_struck(run, r);
  if (status != LAMC_OK) return status;
  lamc_integrals_after(run);
  run->ode.guards(run->ode.context, run->t, y_here(run), r->here);
  evaluate(run, run->t, y_here(run), slope_here(run));
  run->row_due = run->t_eval == NULL;
  lamc_run_restart(run);
  return LAMC_OK;
}

lamc_status lamc_events_after_step(lamc_run *run) {
  if (run->ode.guard_count == 0) {
    lamc_integrals_step(run);
    return LAMC_OK;
  }
  const room r = room_of(run);
  const int dense = run->dense;
  run->ode.guards(run->ode.context, run->t, y_here(run), r.there);
  const int first = is_near(run, &r) ? find_first(run, &r) : -1;
  if (first < 0) {
    if (run->ode.doubts != NULL) run->dense = dense; /* rows ask whether making it met doubts */
    go_on(run, &r, r.there);
    return LAMC_OK;
  }
  const lamc_real whole = run->h_last;
  const int is_here = r.when[first] <= 4.0 * LAMC_EPSILON * fabs(run->t);
  int is_reached;
  lamc_status status = step_to(run, &r, first, &is_reached);
  if (status != LAMC_OK) return status;
  if (!is_reached) {
    go_on(run, &r, r.trial);
    return LAMC_OK;
  }
  if (!is_here) { /* rows within the step are still to be written: the polynomial must not see what the event does */
    lamc_real *y = r.y;
    (void)lamc_run_interpolate(run, 0.5 * (run->t_old + run->t), y);
  }
  lamc_integrals_step(run);
  find_struck(run, &r, first, whole);
  return go_through(run, &r);
}

lamc_status lamc_events_at_break(lamc_run *run) {
  if (run->ode.guard_count == 0) return LAMC_OK;
  const room r = room_of(run);
  int struck = 0;
  run->ode.guards(run->ode.context, run->t, y_here(run), r.there);
  for (int g = 0; g < r.k; g++) {
    const int is_struck = r.there[g] > 0.0 && !(r.here[g] > 0.0);
    r.due[g] = is_struck ? 1.0 : 0.0;
    struck += is_struck;
  }
  memcpy(r.here, r.there, 2 * (size_t)r.k * sizeof *r.here);
  return struck > 0 ? go_through(run, &r) : LAMC_OK;
}
