/* test_control.c: every way in which a run can stop, go on, or be refused. */
#include "../src/control.h"
#include "check.h"
#include "lamc.h"
#include "problems.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { WORK = 16 * 4, MOST_ROWS = 5000 };

static const double AT_ZERO[2] = {0.0, 1.0};

/* the oscillator to t = 20 at 1e-9, every step or at the given times; rows of [t, y0, y1] */
static long long run_in_slices(const double *times, long long time_count, long long budget,
                               long long capacity, double rows_out[][3], lamc_run *run) {
  const lamc_ode ode = make_ode(2, oscillator);
  const lamc_options options = tolerance(1e-9);
  static double t[MOST_ROWS], y[2 * MOST_ROWS];
  double work[WORK];
  long long total = 0;
  lamc_status status =
      lamc_run_start(run, &ode, LAMC_RK45, &options, 0.0, AT_ZERO, 20.0, times, time_count, work);
  lamc_rows rows = make_rows(t, y, capacity);
  while (status >= 0) {
    status = lamc_run_advance(run, &rows, budget, NULL);
    if (status != LAMC_OUTPUT_FULL && status != LAMC_OK) continue;
    for (long long i = 0; i < rows.count; i++, total++) {
      rows_out[total][0] = t[i];
      memcpy(&rows_out[total][1], &y[2 * i], 2 * sizeof *y);
    }
    rows.count = 0;
    if (status == LAMC_OK) return total;
  }
  return -1;
}

static void slices_and_small_buffers_give_the_same_bits(check_counts *counts) {
  static double whole[MOST_ROWS][3], sliced[MOST_ROWS][3];
  static double times[1000];
  for (int i = 0; i < 1000; i++) times[i] = 20.0 * i / 999.0;
  for (int with_times = 0; with_times < 2; with_times++) {
    const double *asked = with_times ? times : NULL;
    lamc_run a, b;
    const long long count = run_in_slices(asked, with_times ? 1000 : 0, 0, MOST_ROWS, whole, &a);
    CHECK(counts, count > 100);
    const long long budgets[] = {1, 50, 0, 7}, capacities[] = {MOST_ROWS, MOST_ROWS, 1, 3};
    for (int i = 0; i < 4; i++) {
      memset(sliced, 0, sizeof sliced);
      CHECK(counts,
            run_in_slices(asked, with_times ? 1000 : 0, budgets[i], capacities[i], sliced, &b) == count);
      CHECK(counts, memcmp(whole, sliced, sizeof whole) == 0);
      CHECK(counts, a.evaluations == b.evaluations && a.steps == b.steps);
    }
  }
}

static void a_budget_ends_a_slice(check_counts *counts) {
  const lamc_ode ode = make_ode(2, oscillator);
  const lamc_options options = tolerance(1e-9);
  double work[WORK], t[MOST_ROWS], y[2 * MOST_ROWS];
  lamc_run run;
  lamc_rows rows = make_rows(t, y, MOST_ROWS);
  CHECK(counts, lamc_run_start(&run, &ode, LAMC_RK45, &options, 0.0, AT_ZERO, 1e6, NULL, 0, work) == LAMC_OK);
  const long long before = run.evaluations;
  CHECK(counts, lamc_run_advance(&run, &rows, 60, NULL) == LAMC_PAUSED);
  CHECK(counts, run.evaluations == before + 60); /* six a step */
  CHECK(counts, rows.t[rows.count - 1] == run.t);
}

static void counters_add_up(check_counts *counts) {
  static double rows[MOST_ROWS][3];
  lamc_run run;
  const long long count = run_in_slices(NULL, 0, 0, MOST_ROWS, rows, &run);
  CHECK(counts, run.steps == run.accepted + run.rejected);
  CHECK(counts,
        run.evaluations == 6 * run.steps + 2); /* the slope at the start, and the probe of the first step */
  CHECK(counts, count == run.accepted + 1);
  CHECK(counts, rows[0][0] == 0.0 && rows[count - 1][0] == 20.0);
  CHECK(counts, run.h_last == rows[count - 1][0] - rows[count - 2][0]);
}

static void rows_lie_exactly_at_the_times_asked_for(check_counts *counts) {
  /* both ends, a time asked for twice, two times one unit of round-off apart */
  const double times[] = {0.0, 0.1, 0.1, 0.3, 0.30000000000000004, 19.999999999, 20.0};
  double rows[7][3];
  lamc_run run;
  CHECK(counts, run_in_slices(times, 7, 0, 7, rows, &run) == 7);
  for (int i = 0; i < 7; i++) {
    CHECK(counts, rows[i][0] == times[i]);
    CHECK(counts, fabs(rows[i][1] - sin(times[i])) < 1e-7); /* rtol 1e-9 over 20 rad */
  }
  CHECK(counts, rows[0][1] == 0.0 && rows[0][2] == 1.0);
  CHECK(counts, memcmp(rows[1], rows[2], sizeof rows[1]) == 0);
}

static void a_time_on_a_step_is_that_step(check_counts *counts) {
  static double steps[MOST_ROWS][3], same[MOST_ROWS][3];
  double times[MOST_ROWS];
  lamc_run run;
  const long long count = run_in_slices(NULL, 0, 0, MOST_ROWS, steps, &run);
  for (long long i = 0; i < count; i++) times[i] = steps[i][0];
  CHECK(counts, run_in_slices(times, count, 0, MOST_ROWS, same, &run) == count);
  CHECK(counts, memcmp(steps, same, sizeof steps) == 0);
}

static void interpolation_covers_the_last_step_only(check_counts *counts) {
  const lamc_ode ode = make_ode(2, oscillator);
  const lamc_options options = tolerance(1e-9);
  double work[WORK], t[MOST_ROWS], y[2 * MOST_ROWS], between[2];
  lamc_run run;
  lamc_rows rows = make_rows(t, y, MOST_ROWS);
  CHECK(counts,
        lamc_run_start(&run, &ode, LAMC_RK45, &options, 0.0, AT_ZERO, 20.0, NULL, 0, work) == LAMC_OK);
  CHECK(counts, lamc_run_interpolate(&run, 0.0, between) == LAMC_BAD_ARGUMENT); /* no step yet */
  CHECK(counts, lamc_run_advance(&run, &rows, 0, NULL) == LAMC_OK);
  const double middle = 0.5 * (run.t_old + run.t);
  CHECK(counts, lamc_run_interpolate(&run, middle, between) == LAMC_OK);
  CHECK(counts, fabs(between[0] - sin(middle)) < 1e-7); /* rtol 1e-9 over 20 rad */
  CHECK(counts, lamc_run_interpolate(&run, run.t_old, between) == LAMC_OK);
  CHECK(counts, memcmp(between, &y[2 * (rows.count - 2)], sizeof between) == 0);
  CHECK(counts, lamc_run_interpolate(&run, run.t_old - 1e-9, between) == LAMC_BAD_ARGUMENT);
  CHECK(counts, lamc_run_interpolate(&run, 20.1, between) == LAMC_BAD_ARGUMENT);
  CHECK(counts, lamc_run_interpolate(&run, NAN, between) == LAMC_BAD_ARGUMENT);
}

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

static void the_longest_and_the_first_step_are_obeyed(check_counts *counts) {
  static double t[MOST_ROWS], y[2 * MOST_ROWS];
  const lamc_ode ode = make_ode(2, oscillator);
  lamc_options options = tolerance(1e-3);
  options.first_step = 1e-3;
  options.max_step = 0.01;
  double work[WORK];
  lamc_run run;
  lamc_rows rows = make_rows(t, y, MOST_ROWS);
  CHECK(counts, lamc_run_start(&run, &ode, LAMC_RK45, &options, 0.0, AT_ZERO, 1.0, NULL, 0, work) == LAMC_OK);
  CHECK(counts, lamc_run_advance(&run, &rows, 0, NULL) == LAMC_OK);
  CHECK(counts, t[1] == 1e-3);
  /* 1 %: the last step may be stretched so that no sliver remains */
  for (long long i = 1; i < rows.count; i++) CHECK(counts, t[i] - t[i - 1] <= 0.01 * 1.0101);
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

static void every_status_has_a_message(check_counts *counts) {
  for (int status = -6; status <= 3; status++) {
    const char *message = lamc_status_message((lamc_status)status);
    CHECK(counts, message != NULL && strlen(message) > 5);
  }
}

/* Against the library's. 1.2e-4 and 1.5e-4 are what polynomials of their orders leave between powers of two. */
static void logarithms_and_powers_of_control_have_their_digits(check_counts *counts) {
  for (int e = -1022; e < 1024; e++) {
    CHECK(counts, lamc_control_log2(ldexp(1.0, e)) == e);
    CHECK(counts, lamc_control_exp2(e) == ldexp(1.0, e));
  }
  double last_log = -1022.0, last_power = 0.0;
  for (int i = 1; i <= 20000; i++) {
    const double x = ldexp(1.0 + i % 1000 / 1000.0, i / 1000 - 10), y = -10.0 + i / 1000.0;
    const double log_x = lamc_control_log2(x), power = lamc_control_exp2(y);
    CHECK(counts, fabs(log_x - log2(x)) <= 1.2e-4);
    CHECK(counts, fabs(power - exp2(y)) <= 1.5e-4 * exp2(y));
    CHECK(counts, log_x > last_log && power > last_power); /* a larger error never means a longer step */
    last_log = log_x;
    last_power = power;
  }
  CHECK(counts, lamc_control_log2(0.0) == -1023.0);
  CHECK(counts, lamc_control_exp2(0.17 * 0.5 * 1023.0) > 1e6); /* zero error: as long as control lets it be */
}

int main(void) {
  const check_case cases[] = {
      CASE(logarithms_and_powers_of_control_have_their_digits),
      CASE(slices_and_small_buffers_give_the_same_bits),
      CASE(a_budget_ends_a_slice),
      CASE(counters_add_up),
      CASE(rows_lie_exactly_at_the_times_asked_for),
      CASE(a_time_on_a_step_is_that_step),
      CASE(interpolation_covers_the_last_step_only),
      CASE(a_singularity_ends_in_underflow),
      CASE(the_end_of_definition_is_not_finite),
      CASE(nothing_finite_ahead_is_told_and_does_not_hang),
      CASE(the_step_limit_keeps_what_there_is),
      CASE(a_raised_flag_stops_the_run_at_the_next_step),
      CASE(a_run_of_no_length_gives_its_start),
      CASE(a_mechanism_without_hinges_reaches_its_end),
      CASE(a_state_at_rest_is_crossed_in_few_steps),
      CASE(the_longest_and_the_first_step_are_obeyed),
      CASE(a_run_can_start_late_and_end_at_once),
      CASE(absurd_tolerances_end),
      CASE(bad_arguments_are_refused),
      CASE(a_refused_run_stays_refused),
      CASE(every_status_has_a_message),
  };
  return check_run(cases, (int)(sizeof cases / sizeof *cases));
}
