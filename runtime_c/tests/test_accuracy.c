/* test_accuracy.c: the order of Dormand-Prince 5(4) and of its dense output, and what a tolerance buys. */
#include "check.h"
#include "lamc.h"
#include "problems.h"

#include <math.h>
#include <string.h>

enum { MOST_COMPONENTS = 4, MOST_ROWS = 4000, WORK = 16 * 4 };

/* y at t_end; -1 evaluations on failure */
static long long solve(const lamc_ode *ode, const lamc_options *options, const double *y0, double t_end,
                       double *y) {
  double work[WORK], t;
  lamc_run run;
  lamc_rows rows = make_rows(&t, y, 1);
  if (lamc_run_start(&run, ode, LAMC_RK45, options, 0.0, y0, t_end, &t_end, 1, work) != LAMC_OK) return -1;
  return lamc_run_advance(&run, &rows, 0, NULL) == LAMC_OK ? run.evaluations : -1;
}

/* slope between the errors with a step and with half the step; `exact` holds all components */
static double observed_order(const lamc_ode *ode, const double *y0, double t_end, const double *exact,
                             double h) {
  double error[2];
  for (int i = 0; i < 2; i++) {
    const lamc_options options = fixed_step(i == 0 ? h : 0.5 * h);
    double y[MOST_COMPONENTS];
    if (solve(ode, &options, y0, t_end, y) < 0) return NAN;
    error[i] = 0.0;
    for (int j = 0; j < ode->n; j++) error[i] = hypot(error[i], y[j] - exact[j]);
  }
  return log2(error[0] / error[1]);
}

static void fixed_steps_converge_with_order_five(check_counts *counts) {
  /* 0.15: the next term of the error expansion is still there at these steps (0.05 and 0.025, 400 and 800 a turn) */
  const lamc_ode harmonic = make_ode(2, oscillator), forced = make_ode(1, driven),
                 orbit = make_ode(4, kepler);
  const double at_zero[2] = {0.0, 1.0}, one[1] = {1.0};
  const double ellipse[4] = {0.7, 0.0, 0.0, sqrt(1.3 / 0.7)}, turn = 2.0 * acos(-1.0); /* closes */
  const double harmonic_end[2] = {sin(1.0), cos(1.0)}, forced_end[1] = {exp(sin(2.0))};
  CHECK(counts, fabs(observed_order(&harmonic, at_zero, 1.0, harmonic_end, 0.05) - 5.0) < 0.15);
  CHECK(counts, fabs(observed_order(&forced, one, 2.0, forced_end, 0.05) - 5.0) < 0.15);
  CHECK(counts, fabs(observed_order(&orbit, ellipse, turn, ellipse, turn / 400.0) - 5.0) < 0.15);
}

static void a_single_step_errs_with_order_six(check_counts *counts) {
  /* local error h^6, 0.3 for the next term */
  const lamc_ode forced = make_ode(1, driven);
  const double one[1] = {1.0};
  double error[2];
  for (int i = 0; i < 2; i++) {
    const double h = i == 0 ? 0.2 : 0.1;
    const lamc_options options = fixed_step(h);
    double y[1];
    CHECK(counts, solve(&forced, &options, one, h, y) > 0);
    error[i] = fabs(y[0] - exp(sin(h)));
  }
  CHECK(counts, fabs(log2(error[0] / error[1]) - 6.0) < 0.3);
}

/* the largest error of the dense output over one step of length h */
static double dense_error(double h) {
  const lamc_ode ode = make_ode(2, oscillator);
  const lamc_options options = fixed_step(h);
  const double y0[2] = {0.0, 1.0};
  double work[WORK], times[99], t[99], y[2 * 99], largest = 0.0;
  for (int i = 0; i < 99; i++) times[i] = h * (i + 1) / 100.0;
  lamc_run run;
  lamc_rows rows = make_rows(t, y, 99);
  if (lamc_run_start(&run, &ode, LAMC_RK45, &options, 0.0, y0, h, times, 99, work) != LAMC_OK) return NAN;
  if (lamc_run_advance(&run, &rows, 0, NULL) != LAMC_OK || run.accepted != 1) return NAN;
  for (int i = 0; i < 99; i++) largest = fmax(largest, fabs(y[2 * i] - sin(t[i])));
  return largest;
}

static void dense_output_has_order_four(check_counts *counts) {
  /* local error h^5 between the ends of a step, 0.2 for the next term */
  CHECK(counts, fabs(log2(dense_error(0.2) / dense_error(0.1)) - 5.0) < 0.2);
}

static void dense_output_is_not_the_weakest_link(check_counts *counts) {
  /* 1000 times between the steps are at most twice as far off as the state that is carried along: measured 1.1 */
  const lamc_ode ode = make_ode(2, oscillator);
  const lamc_options options = tolerance(1e-11);
  const double y0[2] = {0.0, 1.0};
  static double times[MOST_ROWS], t[MOST_ROWS], y[2 * MOST_ROWS];
  double work[WORK], at_end[2], largest = 0.0;
  for (int i = 0; i < 1000; i++) times[i] = 20.0 * (i + 1) / 1000.0;
  lamc_run run;
  lamc_rows rows = make_rows(t, y, MOST_ROWS);
  CHECK(counts, lamc_run_start(&run, &ode, LAMC_RK45, &options, 0.0, y0, 20.0, times, 1000, work) == LAMC_OK);
  CHECK(counts, lamc_run_advance(&run, &rows, 0, NULL) == LAMC_OK);
  for (int i = 0; i < 1000; i++)
    largest = fmax(largest, hypot(y[2 * i] - sin(t[i]), y[2 * i + 1] - cos(t[i])));
  CHECK(counts, solve(&ode, &options, y0, 20.0, at_end) > 0);
  CHECK(counts, largest < 2.0 * hypot(at_end[0] - sin(20.0), at_end[1] - cos(20.0)));
}

static void error_is_proportional_to_the_tolerance(check_counts *counts) {
  /* each factor of 100 in the tolerance gives 100 in the error, within a factor of 4 (step control) */
  const lamc_ode ode = make_ode(2, oscillator);
  const double y0[2] = {0.0, 1.0};
  double error[4];
  for (int i = 0; i < 4; i++) {
    const lamc_options options = tolerance(pow(10.0, -5.0 - 2.0 * i));
    double y[2];
    CHECK(counts, solve(&ode, &options, y0, 20.0, y) > 0);
    error[i] = hypot(y[0] - sin(20.0), y[1] - cos(20.0));
  }
  for (int i = 0; i < 3; i++)
    CHECK(counts, error[i] > 25.0 * error[i + 1] && error[i] < 400.0 * error[i + 1]);
}

static void arenstorf_orbit_closes(check_counts *counts) {
  /* The orbit multiplies an error by about 1e6 a turn (Hairer, Norsett, Wanner I, section II.10, fig. 10.2: 1e-7
   * needs some 10^4 evaluations with DOPRI5). At 1e-12 it closes to 1e-5 with room. */
  const lamc_ode ode = make_ode(4, arenstorf);
  const lamc_options options = tolerance(1e-12);
  double y[4];
  const long long evaluations = solve(&ode, &options, ARENSTORF_START, ARENSTORF_PERIOD, y);
  CHECK(counts, evaluations > 0 && evaluations < 20000);
  CHECK(counts, hypot(y[0] - ARENSTORF_START[0], y[1] - ARENSTORF_START[1]) < 1e-5);
}

static void eccentric_orbit_keeps_its_energy(check_counts *counts) {
  /* e = 0.6, ten turns at 1e-10; energy -1/2. 1e-8: a hundred times the tolerance for some thousand steps */
  const lamc_ode ode = make_ode(4, kepler);
  const lamc_options options = tolerance(1e-10);
  const double y0[4] = {0.4, 0.0, 0.0, 2.0};
  double y[4];
  CHECK(counts, solve(&ode, &options, y0, 20.0 * acos(-1.0), y) > 0);
  CHECK(counts, fabs(0.5 * (y[2] * y[2] + y[3] * y[3]) - 1.0 / hypot(y[0], y[1]) + 0.5) < 1e-8);
}

int main(void) {
  const check_case cases[] = {
      CASE(fixed_steps_converge_with_order_five),
      CASE(a_single_step_errs_with_order_six),
      CASE(dense_output_has_order_four),
      CASE(dense_output_is_not_the_weakest_link),
      CASE(error_is_proportional_to_the_tolerance),
      CASE(arenstorf_orbit_closes),
      CASE(eccentric_orbit_keeps_its_energy),
  };
  return check_run(cases, (int)(sizeof cases / sizeof *cases));
}
