/* test_events.c: zeros of guards are found in order, all of them, and where they are. */
#include "check.h"
#include "lamc.h"
#include "problems.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { WORK = 2000, MOST_EVENTS = 400, METHODS = 4 };

static const lamc_method METHOD[METHODS] = {LAMC_RK45, LAMC_DOP853, LAMC_RODAS5P, LAMC_RADAU5};

/* The oscillator q = sin t with guards that turn their sign at each event, as switches do */
typedef struct wave {
  double sharpness; /* guard 0: sin(sharpness q) */
  double level;     /* guard 1: q - level */
  double sign[2];
} wave;

static void wave_rhs(const void *context, double t, const double *y, double *dydt) {
  oscillator(context, t, y, dydt);
}

static void wave_jacobian(const void *context, double t, const double *y, double *by_q, double *by_u,
                          double *by_t, double *scratch) {
  (void)context, (void)t, (void)y, (void)scratch;
  by_q[0] = -1.0;
  by_u[0] = by_t[0] = 0.0;
}

static void wave_guards(const void *context, double t, const double *y, double *guards) {
  const wave *w = (const wave *)context;
  (void)t;
  guards[0] = w->sign[0] * sin(w->sharpness * y[0]);
  guards[1] = w->sign[1] * (y[0] - w->level);
  guards[2] = w->sign[0] * w->sharpness * cos(w->sharpness * y[0]) * y[1];
  guards[3] = w->sign[1] * y[1];
}

static void wave_sense(const void *context, double t, const double *y) {
  wave *w = (wave *)(uintptr_t)context;
  double guards[4];
  w->sign[0] = w->sign[1] = 1.0;
  wave_guards(context, t, y, guards);
  for (int g = 0; g < 2; g++) w->sign[g] = guards[g] > 0.0 ? -1.0 : 1.0;
}

static lamc_status wave_event(const void *context, double t, double *y, const double *struck) {
  wave *w = (wave *)(uintptr_t)context;
  (void)t, (void)y;
  for (int g = 0; g < 2; g++)
    if (struck[g] > 0.0) w->sign[g] = -w->sign[g];
  return LAMC_OK;
}

static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* The times in (from, to) at which sin t is one of the values k step + first, all below 1 in size */
static int passages(double first, double step, double from, double to, double *times) {
  const double pi = acos(-1.0);
  int count = 0;
  for (int k = -100; k <= 100; k++) {
    const double value = first + k * step;
    if (fabs(value) >= 1.0 || (step == 0.0 && k != 0)) continue;
    for (int turn = -1; turn < 10; turn++) {
      const double rising = asin(value) + 2.0 * pi * turn, falling = pi - asin(value) + 2.0 * pi * turn;
      if (rising > from && rising < to) times[count++] = rising;
      if (falling > from && falling < to) times[count++] = falling;
    }
  }
  qsort(times, (size_t)count, sizeof *times, ascending);
  return count;
}

/* Runs the wave from t0 to t_end; the events of each guard in order */
static lamc_status ride(wave *w, lamc_method method, double rtol, double t0, double t_end,
                        double times[2][MOST_EVENTS], int *counts, double *last, lamc_run *run) {
  static double work[WORK], event_t[MOST_EVENTS];
  static int event_guard[MOST_EVENTS];
  const lamc_options options = tolerance(rtol);
  const double y0[2] = {sin(t0), cos(t0)};
  double t;
  lamc_ode ode = make_ode(2, wave_rhs);
  ode.context = w;
  ode.jacobian = wave_jacobian;
  ode.guard_count = 2;
  ode.guards = wave_guards;
  ode.sense = wave_sense;
  ode.event = wave_event;
  lamc_rows rows = make_rows(&t, last, 1);
  rows.event_t = event_t;
  rows.event_guard = event_guard;
  rows.event_capacity = MOST_EVENTS;
  counts[0] = counts[1] = 0;
  if (lamc_run_work_size(&ode, method) > WORK) return LAMC_BAD_ARGUMENT;
  if (lamc_run_start(run, &ode, method, &options, t0, y0, t_end, &t_end, 1, work) != LAMC_OK)
    return run->status;
  const lamc_status status = lamc_run_advance(run, &rows, 0, NULL);
  for (long long i = 0; i < rows.event_count; i++) {
    if (i > 0 && event_t[i] < event_t[i - 1]) return LAMC_BAD_ARGUMENT;
    times[event_guard[i]][counts[event_guard[i]]++] = event_t[i];
  }
  return status;
}

/* Seven zeros of guard 0 in each half turn, up to five of them in one step at the loose tolerances */
static void several_zeros_in_one_step_are_found_in_order(check_counts *counts) {
  const double t0 = 0.1, t_end = 12.0, rtols[] = {1e-3, 1e-5, 1e-9};
  for (int m = 0; m < METHODS; m++) {
    for (int i = 0; i < 3; i++) {
      wave w = {12.0, 0.5, {1.0, 1.0}};
      static double times[2][MOST_EVENTS], truth[MOST_EVENTS];
      int found[2];
      double last[2];
      lamc_run run;
      CHECK(counts, ride(&w, METHOD[m], rtols[i], t0, t_end, times, found, last, &run) == LAMC_OK);
      CHECK(counts, run.t == t_end && run.steps == run.accepted + run.rejected);
      for (int g = 0; g < 2; g++) {
        const int expected =
            passages(g == 0 ? 0.0 : w.level, g == 0 ? acos(-1.0) / w.sharpness : 0.0, t0, t_end, truth);
        CHECK(counts, found[g] == expected);
        /* the run's error over two turns, a hundred tolerances, by the rate at the passages: above 0.6 for both */
        for (int k = 0; k < expected && found[g] == expected; k++)
          CHECK(counts, fabs(times[g][k] - truth[k]) < 300.0 * rtols[i]);
      }
      CHECK(counts, hypot(last[0] - sin(t_end), last[1] - cos(t_end)) < 100.0 * rtols[i]);
    }
  }
}

/* The level is so near to the top that the guard is positive for a hundredth of the time, or never */
static void a_short_touch_is_seen_and_a_near_miss_is_none(check_counts *counts) {
  const double t0 = 0.1, t_end = 12.0;
  for (int m = 0; m < METHODS; m++) {
    for (int touches = 0; touches < 2; touches++) {
      wave w = {1e-3, touches ? 0.9995 : 1.0005, {1.0, 1.0}}; /* the tolerance, a hundred times: 1e-4 */
      static double times[2][MOST_EVENTS], truth[MOST_EVENTS];
      int found[2];
      double last[2];
      lamc_run run;
      CHECK(counts, ride(&w, METHOD[m], 1e-6, t0, t_end, times, found, last, &run) == LAMC_OK);
      const int expected = passages(w.level, 0.0, t0, t_end, truth);
      CHECK(counts, expected == (touches ? 4 : 0) && found[1] == expected);
      /* at a rate of 0.03 the run's error of 1e-4 shifts the passage by 3e-3 */
      for (int k = 0; k < expected && found[1] == expected; k++)
        CHECK(counts, fabs(times[1][k] - truth[k]) < 3e-3);
    }
  }
}

/* q'' = -q - 5 q |q| - c q' comes to rest at zero, where a guard passes zero, with all its digits lost; context: c, and the guard's sign */
static void rest_rhs(const void *context, double t, const double *y, double *dydt) {
  (void)t;
  dydt[0] = y[1];
  dydt[1] = -y[0] - 5.0 * y[0] * fabs(y[0]) - *(const double *)context * y[1];
}

static void rest_jacobian(const void *context, double t, const double *y, double *by_q, double *by_u,
                          double *by_t, double *scratch) {
  (void)t, (void)scratch;
  by_q[0] = -1.0 - 10.0 * fabs(y[0]);
  by_u[0] = -*(const double *)context;
  by_t[0] = 0.0;
}

static void rest_guards(const void *context, double t, const double *y, double *guards) {
  const double sign = ((const double *)context)[1];
  (void)t;
  guards[0] = sign * y[0];
  guards[1] = sign * y[1];
}

static lamc_status rest_event(const void *context, double t, double *y, const double *struck) {
  double *sign = (double *)(uintptr_t)context + 1;
  (void)t, (void)y, (void)struck;
  *sign = -*sign;
  return LAMC_OK;
}

static void a_motion_comes_to_rest_where_a_guard_is_zero(check_counts *counts) {
  const double damping[] = {0.02, 0.3, 1.0, 1.9, 3.0}, y0[2] = {0.4, 0.0};
  for (int m = 0; m < METHODS; m++) {
    for (int d = 0; d < 5; d++) {
      double context[2] = {damping[d], -1.0};
      const lamc_options options = tolerance(1e-6);
      static double work[WORK];
      double t = 2000.0, last[2];
      lamc_ode ode = make_ode(2, rest_rhs);
      lamc_rows rows = make_rows(&t, last, 1);
      lamc_run run;
      ode.context = context;
      ode.jacobian = rest_jacobian;
      ode.guard_count = 1;
      ode.guards = rest_guards;
      ode.event = rest_event;
      CHECK(counts, lamc_run_start(&run, &ode, METHOD[m], &options, 0.0, y0, t, &t, 1, work) == LAMC_OK);
      CHECK(counts, lamc_run_advance(&run, &rows, 0, NULL) == LAMC_OK);
      CHECK(counts, hypot(last[0], last[1]) < 1e-6 && run.t == 2000.0);
    }
  }
}

int main(void) {
  const check_case cases[] = {
      CASE(several_zeros_in_one_step_are_found_in_order),
      CASE(a_short_touch_is_seen_and_a_near_miss_is_none),
      CASE(a_motion_comes_to_rest_where_a_guard_is_zero),
  };
  return check_run(cases, (int)(sizeof cases / sizeof *cases));
}
