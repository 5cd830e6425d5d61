/* test_slices.c: a run in slices and with small buffers, the rows that it gives, and times asked for. */
#include "check.h"
#include "lamc.h"
#include "problems.h"

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

int main(void) {
  const check_case cases[] = {
      CASE(slices_and_small_buffers_give_the_same_bits),
      CASE(a_budget_ends_a_slice),
      CASE(counters_add_up),
      CASE(rows_lie_exactly_at_the_times_asked_for),
      CASE(a_time_on_a_step_is_that_step),
      CASE(interpolation_covers_the_last_step_only),
  };
  return check_run(cases, (int)(sizeof cases / sizeof *cases));
}
