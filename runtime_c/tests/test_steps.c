/* test_steps.c: runs that a caller takes step by step, and puts elsewhere. */
#include "check.h"
#include "lamc.h"
#include "problems.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { WORK = 16 * 4, TIMES = 200 };

static const double AT_ZERO[2] = {0.0, 1.0};
static const double END = 20.0;

/* What the oscillator is at so many times, by rows */
static lamc_run by_rows(double *y) {
  const lamc_ode ode = make_ode(2, oscillator);
  const lamc_options options = tolerance(1e-9);
  static double times[TIMES], t[TIMES];
  double work[WORK];
  lamc_run run;
  for (int i = 0; i < TIMES; i++) times[i] = END * (i + 1) / TIMES;
  lamc_rows rows = make_rows(t, y, TIMES);
  (void)lamc_run_start(&run, &ode, LAMC_RK45, &options, 0.0, AT_ZERO, END, times, TIMES, work);
  (void)lamc_run_advance(&run, &rows, 0, NULL);
  return run;
}

static void steps_taken_singly_are_those_of_a_run_with_rows(check_counts *counts) {
  const lamc_ode ode = make_ode(2, oscillator);
  const lamc_options options = tolerance(1e-9);
  static double rows[2 * TIMES], y[2 * TIMES];
  double work[WORK];
  lamc_run run;
  const lamc_run whole = by_rows(rows);
  CHECK(counts, lamc_run_start(&run, &ode, LAMC_RK45, &options, 0.0, AT_ZERO, END, NULL, 0, work) == LAMC_OK);
  CHECK(counts, lamc_run_at(&run, 0.0, y) == LAMC_OK);
  CHECK(counts, lamc_run_at(&run, 0.1, y) == LAMC_BAD_ARGUMENT); /* no step covers it yet */
  for (int i = 0; i < TIMES; i++) {
    const double t = END * (i + 1) / TIMES;
    while (run.t < t) CHECK(counts, lamc_run_step(&run) == LAMC_OK);
    CHECK(counts, lamc_run_at(&run, t, y + (size_t)2 * (size_t)i) == LAMC_OK);
  }
  CHECK(counts, memcmp(rows, y, sizeof y) == 0);
  CHECK(counts, run.steps == whole.steps && run.evaluations == whole.evaluations);
  CHECK(counts, lamc_run_step(&run) == LAMC_OK && run.t == END && run.steps == whole.steps);
  CHECK(counts, lamc_run_at(&run, END + 1.0, y) == LAMC_BAD_ARGUMENT);
}

static void a_run_without_an_end_goes_on(check_counts *counts) {
  const lamc_ode ode = make_ode(2, oscillator);
  const lamc_options options = tolerance(1e-9);
  double work[WORK], y[2];
  lamc_run run;
  CHECK(counts,
        lamc_run_start(&run, &ode, LAMC_RK45, &options, 0.0, AT_ZERO, DBL_MAX, NULL, 0, work) == LAMC_OK);
  while (run.t < 100.0) CHECK(counts, lamc_run_step(&run) == LAMC_OK);
  CHECK(counts, lamc_run_at(&run, 100.0, y) == LAMC_OK);
  CHECK(counts, fabs(y[0] - sin(100.0)) < 1e-6); /* a thousand steps of 1e-9 and less */
}

static void a_run_put_elsewhere_follows_the_solution_through_there(check_counts *counts) {
  const lamc_ode ode = make_ode(2, oscillator);
  const lamc_options options = tolerance(1e-9);
  const double other[2] = {sin(1.0 + 0.5), cos(1.0 + 0.5)}, nowhere[2] = {NAN, 0.0};
  double work[WORK], y[2];
  lamc_run run;
  CHECK(counts, lamc_run_start(&run, &ode, LAMC_RK45, &options, 0.0, AT_ZERO, END, NULL, 0, work) == LAMC_OK);
  while (run.t < 2.0) (void)lamc_run_step(&run);
  const double h = run.h;
  CHECK(counts, lamc_run_put(&run, 1.0, other) == LAMC_OK); /* back, and half a radian ahead */
  CHECK(counts, run.t == 1.0 && run.h == h);
  CHECK(counts, lamc_run_at(&run, 1.5, y) == LAMC_BAD_ARGUMENT);
  while (run.t < 5.0) CHECK(counts, lamc_run_step(&run) == LAMC_OK);
  CHECK(counts, lamc_run_at(&run, 5.0, y) == LAMC_OK);
  CHECK(counts, fabs(y[0] - sin(5.5)) < 1e-7); /* some fifty steps of 1e-9 */
  CHECK(counts, lamc_run_put(&run, END + 1.0, other) == LAMC_BAD_ARGUMENT);
  CHECK(counts, lamc_run_put(&run, 1.0, nowhere) == LAMC_NOT_FINITE);
}

int main(void) {
  const check_case cases[] = {
      CASE(steps_taken_singly_are_those_of_a_run_with_rows),
      CASE(a_run_without_an_end_goes_on),
      CASE(a_run_put_elsewhere_follows_the_solution_through_there),
  };
  return check_run(cases, sizeof cases / sizeof *cases);
}
