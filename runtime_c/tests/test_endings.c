/* test_endings.c: every way in which a run can end, or be refused. */
#include "check.h"
#include "lamc.h"
#include "problems.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { WORK = 16 * 4, MOST_ROWS = 5000 };

static const double AT_ZERO[2] = {0.0, 1.0};

/* runs to t_end; the status, with where it stopped and how many rows there are */
static lamc_status outcome(const lamc_ode *ode, lamc_options options, const double *y0, double t_end,
                           lamc_run *run, long long *row_count, const volatile int *cancel) {
  static double t[MOST_ROWS], y[2 * MOST_ROWS];
  static double work[WORK];
  lamc_rows rows = make_rows(t, y, MOST_ROWS);
  lamc_status status = lamc_run_start(run, ode, LAMC_RK45, &options, 0.0, y0, t_end, NULL, 0, work);
  if (status == LAMC_OK) status = lamc_run_advance(run, &rows, 0, cancel);
  *row_count = rows.count;
  return status;
}

static void a_singularity_ends_in_underflow(check_counts *counts) {
  const lamc_ode ode = make_ode(1, blow_up);
  const double one[1] = {1.0};
  lamc_run run;
  long long count;
  const lamc_status status = outcome(&ode, tolerance(1e-6), one, 2.0, &run, &count, NULL);
  CHECK(counts, status == LAMC_STEP_UNDERFLOW);
  /* the pole is at 1, and the numerical one is off by the global error, some 1e-6 relative */
  CHECK(counts, fabs(run.t - 1.0) < 1e-5);
  CHECK(counts, count == run.accepted + 1);
}

static void the_end_of_definition_is_not_finite(check_counts *counts) {
  const lamc_ode ode = make_ode(1, ends_at_one);
  const double one[1] = {1.0};
  lamc_run run;
  long long count;
  CHECK(counts, outcome(&ode, tolerance(1e-6), one, 2.0, &run, &count, NULL) == LAMC_NOT_FINITE);
  CHECK(counts, run.t <= 1.0 && run.t > 1.0 - 1e-12); /* it goes as near as steps can */
  CHECK(counts, count > 1);
}

static void always_nan(const void *context, double t, const double *y, double *dydt) {
  (void)context, (void)y;
  dydt[0] = t > 0.0 ? NAN : 1.0;
}

static void always_infinite(const void *context, double t, const double *y, double *dydt) {
  (void)context, (void)y;
  dydt[0] = t > 0.0 ? -INFINITY : 1.0;
}

static void steep(const void *context, double t, const double *y, double *dydt) {
  (void)context, (void)t, (void)y;
  dydt[0] = DBL_MAX;
}

static void nothing_finite_ahead_is_told_and_does_not_hang(check_counts *counts) {
  const lamc_ode nan_ode = make_ode(1, always_nan), infinite_ode = make_ode(1, always_infinite);
  const lamc_ode steep_ode = make_ode(1, steep);
  const double one[1] = {1.0}, bad[1] = {NAN}, worse[1] = {INFINITY};
  lamc_run run;
  long long count;
  CHECK(counts, outcome(&nan_ode, tolerance(1e-6), one, 1.0, &run, &count, NULL) == LAMC_NOT_FINITE);
  CHECK(counts, count == 1 && run.accepted == 0);
  CHECK(counts, outcome(&infinite_ode, tolerance(1e-6), one, 1.0, &run, &count, NULL) == LAMC_NOT_FINITE);
  CHECK(counts, outcome(&steep_ode, tolerance(1e-6), one, 10.0, &run, &count, NULL) == LAMC_NOT_FINITE);
  CHECK(counts, outcome(&nan_ode, tolerance(1e-6), bad, 1.0, &run, &count, NULL) == LAMC_NOT_FINITE);
  CHECK(counts, outcome(&nan_ode, tolerance(1e-6), worse, 1.0, &run, &count, NULL) == LAMC_NOT_FINITE);
  CHECK(counts, count == 0);
}

static void the_step_limit_keeps_what_there_is(check_counts *counts) {
  const lamc_ode ode = make_ode(2, oscillator);
  lamc_options options = tolerance(1e-9);
  options.max_steps = 17;
  lamc_run run;
  long long count;
  CHECK(counts, outcome(&ode, options, AT_ZERO, 20.0, &run, &count, NULL) == LAMC_STEP_LIMIT);
  CHECK(counts, run.steps == 17 && count == run.accepted + 1);
  double t, y[2];
  lamc_rows rows = make_rows(&t, y, 1);
  CHECK(counts, lamc_run_advance(&run, &rows, 0, NULL) == LAMC_STEP_LIMIT); /* an end stays an end */
}

static volatile int cancel_flag = 0;

static void cancels_itself(const void *context, double t, const double *y, double *dydt) {
  oscillator(context, t, y, dydt);
  if (t > 5.0) cancel_flag = 1;
}

static void a_raised_flag_stops_the_run_at_the_next_step(check_counts *counts) {
  const lamc_ode ode = make_ode(2, cancels_itself);
  lamc_run run;
  long long count;
  cancel_flag = 0;
  CHECK(counts, outcome(&ode, tolerance(1e-9), AT_ZERO, 20.0, &run, &count, &cancel_flag) == LAMC_CANCELLED);
  CHECK(counts, run.t_old <= 5.0 && run.t < 6.0);
  CHECK(counts, count == run.accepted + 1);
  CHECK(counts, outcome(&ode, tolerance(1e-9), AT_ZERO, 20.0, &run, &count, &cancel_flag) == LAMC_CANCELLED);
  CHECK(counts, count == 1 && run.steps == 0);
}

static void a_run_of_no_length_gives_its_start(check_counts *counts) {
  const lamc_ode ode = make_ode(2, oscillator);
  lamc_run run;
  long long count;
  CHECK(counts, outcome(&ode, tolerance(1e-9), AT_ZERO, 0.0, &run, &count, NULL) == LAMC_OK);
  CHECK(counts, count == 1 && run.steps == 0);
}

static void nothing(const void *context, double t, const double *y, double *dydt) {
  (void)context, (void)t, (void)y, (void)dydt;
}

static void a_mechanism_without_hinges_reaches_its_end(check_counts *counts) {
  const lamc_ode empty = make_ode(0, nothing);
  lamc_run run;
  long long count;
  CHECK(counts, outcome(&empty, tolerance(1e-9), AT_ZERO, 10.0, &run, &count, NULL) == LAMC_OK);
  CHECK(counts, run.t == 10.0 && run.steps < 20);
}

static void a_state_at_rest_is_crossed_in_few_steps(check_counts *counts) {
  const lamc_ode ode = make_ode(2, oscillator);
  const double rest[2] = {0.0, 0.0};
  lamc_options options = tolerance(1e-9);
  options.atol = 0.0; /* nothing to scale the error by: 0 / 0 must not be NaN */
  lamc_run run;
  long long count;
  CHECK(counts, outcome(&ode, options, rest, 1000.0, &run, &count, NULL) == LAMC_OK);
  CHECK(counts, run.steps < 30 && run.rejected == 0);
}

static void a_run_can_start_late_and_end_at_once(check_counts *counts) {
  /* one unit of round-off from start to end, far from zero */
  const lamc_ode ode = make_ode(2, oscillator);
  const lamc_options options = tolerance(1e-9);
  double work[WORK], t[8], y[16];
  lamc_run run;
  lamc_rows rows = make_rows(t, y, 8);
  const double late = 1e6, next = nextafter(1e6, 2e6);
  CHECK(counts,
        lamc_run_start(&run, &ode, LAMC_RK45, &options, late, AT_ZERO, next, NULL, 0, work) == LAMC_OK);
  CHECK(counts, lamc_run_advance(&run, &rows, 0, NULL) == LAMC_OK);
  CHECK(counts, run.t == next && rows.count == 2);
}

static void absurd_tolerances_end(check_counts *counts) {
  const lamc_ode ode = make_ode(2, oscillator);
  lamc_options options = {1e-13, 0.0, 0.0, 0.0, 100000};
  lamc_run run;
  long long count;
  /* purely relative, and a component passes through zero: whatever comes, it is an end */
  const lamc_status status = outcome(&ode, options, AT_ZERO, 3.0, &run, &count, NULL);
  CHECK(counts, status == LAMC_OK || status == LAMC_STEP_LIMIT || status == LAMC_STEP_UNDERFLOW);
  options.rtol = 1.0;
  options.atol = 1e300;
  CHECK(counts, outcome(&ode, options, AT_ZERO, 1e9, &run, &count, NULL) == LAMC_OK);
}

static lamc_status start_with(lamc_options options, double t0, double t_end, const double *times,
                              long long time_count) {
  const lamc_ode ode = make_ode(2, oscillator);
  static double work[WORK];
  lamc_run run;
  return lamc_run_start(&run, &ode, LAMC_RK45, &options, t0, AT_ZERO, t_end, times, time_count, work);
}

static void bad_arguments_are_refused(check_counts *counts) {
  const lamc_options good = tolerance(1e-9);
  const double nan_time[1] = {NAN}, falling[2] = {0.5, 0.4}, early[1] = {-0.1}, late[1] = {1.1};
  CHECK(counts, start_with(good, 0.0, 1.0, NULL, 0) == LAMC_OK);
  CHECK(counts, start_with(good, 0.0, -1.0, NULL, 0) == LAMC_BAD_ARGUMENT);
  CHECK(counts, start_with(good, 0.0, INFINITY, NULL, 0) == LAMC_BAD_ARGUMENT);
  CHECK(counts, start_with(good, 0.0, NAN, NULL, 0) == LAMC_BAD_ARGUMENT);
  CHECK(counts, start_with(good, NAN, 1.0, NULL, 0) == LAMC_BAD_ARGUMENT);
  CHECK(counts, start_with(good, 0.0, 1.0, nan_time, 1) == LAMC_BAD_ARGUMENT);
  CHECK(counts, start_with(good, 0.0, 1.0, falling, 2) == LAMC_BAD_ARGUMENT);
  CHECK(counts, start_with(good, 0.0, 1.0, early, 1) == LAMC_BAD_ARGUMENT);
  CHECK(counts, start_with(good, 0.0, 1.0, late, 1) == LAMC_BAD_ARGUMENT);
  CHECK(counts, start_with(good, 0.0, 1.0, late, -1) == LAMC_BAD_ARGUMENT);
  const double bad_numbers[] = {NAN, -1.0, INFINITY};
  for (int i = 0; i < 3; i++) {
    for (int field = 0; field < 4; field++) {
      lamc_options bad = good;
      double *fields[] = {&bad.rtol, &bad.atol, &bad.first_step, &bad.max_step};
      *fields[field] = bad_numbers[i];
      CHECK(counts, start_with(bad, 0.0, 1.0, NULL, 0) == LAMC_BAD_ARGUMENT);
    }
  }
  lamc_options bad = good;
  bad.rtol = 0.0;
  CHECK(counts, start_with(bad, 0.0, 1.0, NULL, 0) == LAMC_BAD_ARGUMENT);
  bad = good;
  bad.max_steps = 0;
  CHECK(counts, start_with(bad, 0.0, 1.0, NULL, 0) == LAMC_BAD_ARGUMENT);
  for (int which = LAMC_AUTO; which <= LAMC_RADAU5; which++) {
    const lamc_ode negative = make_ode(-1, oscillator), huge = make_ode(2147483647, oscillator);
    CHECK(counts, lamc_run_work_size(&negative, (lamc_method)which) == 0);
    CHECK(counts, lamc_run_work_size(&huge, (lamc_method)which) == 0);
  }
}

static void a_refused_run_stays_refused(check_counts *counts) {
  const lamc_ode ode = make_ode(2, oscillator);
  const lamc_options options = tolerance(1e-9);
  double work[WORK], t, y[2];
  lamc_run run;
  lamc_rows rows = make_rows(&t, y, 1), none = make_rows(&t, y, 0);
  CHECK(counts, lamc_run_start(&run, &ode, LAMC_RK45, &options, 0.0, AT_ZERO, -1.0, NULL, 0, work) ==
                    LAMC_BAD_ARGUMENT);
  CHECK(counts, lamc_run_advance(&run, &rows, 0, NULL) == LAMC_BAD_ARGUMENT);
  CHECK(counts, lamc_run_start(&run, &ode, LAMC_RK45, &options, 0.0, AT_ZERO, 1.0, NULL, 0, work) == LAMC_OK);
  CHECK(counts, lamc_run_advance(&run, &none, 0, NULL) == LAMC_BAD_ARGUMENT);
  CHECK(counts, lamc_run_advance(&run, &rows, -1, NULL) == LAMC_BAD_ARGUMENT);
}

static void every_status_has_a_message_of_its_own(check_counts *counts) {
  const lamc_status all[] = {LAMC_OK,           LAMC_PAUSED,     LAMC_OUTPUT_FULL,   LAMC_STEP_UNDERFLOW,
                             LAMC_NOT_FINITE,   LAMC_STEP_LIMIT, LAMC_CANCELLED,     LAMC_BAD_ARGUMENT,
                             LAMC_CLOSURE_LOST, LAMC_RANK_LOST,  LAMC_EVENTS_PILE_UP};
  const char *unknown = lamc_status_message((lamc_status)99);
  CHECK(counts, unknown != NULL);
  for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
    CHECK(counts, strcmp(lamc_status_message(all[i]), unknown) != 0);
    for (size_t k = 0; k < i; k++)
      CHECK(counts, strcmp(lamc_status_message(all[i]), lamc_status_message(all[k])) != 0);
  }
}

int main(void) {
  const check_case cases[] = {
      CASE(a_singularity_ends_in_underflow),
      CASE(the_end_of_definition_is_not_finite),
      CASE(nothing_finite_ahead_is_told_and_does_not_hang),
      CASE(the_step_limit_keeps_what_there_is),
      CASE(a_raised_flag_stops_the_run_at_the_next_step),
      CASE(a_run_of_no_length_gives_its_start),
      CASE(a_mechanism_without_hinges_reaches_its_end),
      CASE(a_state_at_rest_is_crossed_in_few_steps),
      CASE(a_run_can_start_late_and_end_at_once),
      CASE(absurd_tolerances_end),
      CASE(bad_arguments_are_refused),
      CASE(a_refused_run_stays_refused),
      CASE(every_status_has_a_message_of_its_own),
  };
  return check_run(cases, (int)(sizeof cases / sizeof *cases));
}
