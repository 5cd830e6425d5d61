/* test_methods.c: the orders of the other methods and of their dense outputs, and stiff equations. */
#include "check.h"
#include "lamc.h"
#include "problems.h"

#include <math.h>
#include <string.h>

enum { MOST_ROWS = 200, WORK = 400 };

static lamc_ode orbit(void) {
  lamc_ode ode = make_ode(4, kepler);
  ode.jacobian = kepler_jacobian;
  return ode;
}

static lamc_ode follow(const double *k_and_c) {
  lamc_ode ode = make_ode(2, follower);
  ode.context = k_and_c;
  ode.jacobian = follower_jacobian;
  return ode;
}

/* y at t_end, and the run; 0 on failure */
static int solve(const lamc_ode *ode, lamc_method method, const lamc_options *options, const double *y0,
                 double t_end, double *y, lamc_run *run) {
  double work[WORK], t;
  lamc_rows rows = make_rows(&t, y, 1);
  if (lamc_run_work_size(ode, method) > WORK) return 0;
  if (lamc_run_start(run, ode, method, options, 0.0, y0, t_end, &t_end, 1, work) != LAMC_OK) return 0;
  return lamc_run_advance(run, &rows, 0, NULL) == LAMC_OK;
}

/* slope between the errors of Van der Pol's equation, mu = 1, at t = 3, with `steps` steps and with twice as many */
static double observed_order(lamc_method method, int steps) {
  const double mu = 1.0, y0[2] = {2.0, 0.0};
  const double exact[2] = {-1.86607391106108, -1.02106034019586}; /* scipy's DOP853 at 3e-14 */
  lamc_ode ode = make_ode(2, van_der_pol);
  double error[2];
  ode.context = &mu;
  ode.jacobian = van_der_pol_jacobian;
  for (int i = 0; i < 2; i++) {
    lamc_options options = fixed_step(3.0 / (steps << i));
    lamc_run run;
    double y[2];
    /* Radau's Newton iteration goes by the tolerance, which has to be tight while steps stay equal */
    if (method == LAMC_RADAU5) options.rtol = options.atol = 1e-3;
    if (!solve(&ode, method, &options, y0, 3.0, y, &run) || run.rejected > 0) return NAN;
    error[i] = hypot(y[0] - exact[0], y[1] - exact[1]);
  }
  return log2(error[0] / error[1]);
}

static void fixed_steps_converge_with_the_order_of_the_method(check_counts *counts) {
  /* 0.3: the next term of the error expansion is still there at these steps */
  CHECK(counts, fabs(observed_order(LAMC_DOP853, 20) - 8.0) < 0.3);
  CHECK(counts, fabs(observed_order(LAMC_RODAS5P, 160) - 5.0) < 0.3);
  CHECK(counts, fabs(observed_order(LAMC_RADAU5, 80) - 5.0) < 0.3);
}

/* the largest error of the dense output over one step of length h from a moving start */
static double dense_error(lamc_method method, double h) {
  const double k_and_c[2] = {1.0, 0.0};
  const lamc_ode ode = follow(k_and_c); /* with k = 1 and c = 0: y'' = -y */
  lamc_options options = fixed_step(h);
  const double y0[2] = {1.0, 0.0};
  double work[WORK], times[99], t[99], y[2 * 99], most = 0.0;
  for (int i = 0; i < 99; i++) times[i] = h * (i + 1) / 100.0;
  lamc_run run;
  lamc_rows rows = make_rows(t, y, 99);
  if (method == LAMC_RADAU5) options.rtol = 1e-2, options.atol = 1e-2;
  if (lamc_run_start(&run, &ode, method, &options, 0.0, y0, h, times, 99, work) != LAMC_OK) return NAN;
  if (lamc_run_advance(&run, &rows, 0, NULL) != LAMC_OK || run.accepted != 1) return NAN;
  for (int i = 0; i < 99; i++) most = fmax(most, fabs(y[2 * i] - cos(t[i])));
  return most;
}

static void dense_outputs_have_their_orders(check_counts *counts) {
  /* local errors: 8 for the order 7 of DOP853, 4 for the collocation polynomial, 5 for the order 4 of Rodas5P, one
   * better on this linear equation; 0.8 and 0.4 for the next term */
  CHECK(counts, fabs(log2(dense_error(LAMC_DOP853, 1.0) / dense_error(LAMC_DOP853, 0.5)) - 8.0) < 0.8);
  CHECK(counts, log2(dense_error(LAMC_RODAS5P, 0.2) / dense_error(LAMC_RODAS5P, 0.1)) > 4.6);
  CHECK(counts, fabs(log2(dense_error(LAMC_RADAU5, 0.2) / dense_error(LAMC_RADAU5, 0.1)) - 4.0) < 0.4);
}

static void tolerances_are_met(check_counts *counts) {
  /* over 20 rad the error of a step adds up to some hundred times the tolerance at most */
  const lamc_ode ode = orbit();
  const double ellipse[4] = {0.7, 0.0, 0.0, sqrt(1.3 / 0.7)}, turn = 2.0 * acos(-1.0);
  for (int method = LAMC_AUTO; method <= LAMC_RADAU5; method++) {
    for (int digits = 4; digits <= 10; digits += 3) {
      const lamc_options options = tolerance(pow(10.0, -digits));
      lamc_run run;
      double y[4], error = 0.0;
      CHECK(counts, solve(&ode, (lamc_method)method, &options, ellipse, turn, y, &run));
      for (int j = 0; j < 4; j++) error = hypot(error, y[j] - ellipse[j]);
      CHECK(counts, error < 300.0 * options.rtol);
    }
  }
}

static void stiff_equations_take_few_steps(check_counts *counts) {
  /* k and c far beyond what an explicit method can step over in 1 s: stable steps are near 3 / c and 3 / sqrt(k). */
  const double pairs[3][2] = {{1e10, 0.0}, {1e10, 1e6}, {1e4, 1e8}};
  const double y0[2] = {1.0, 0.0};
  const lamc_method methods[] = {LAMC_RODAS5P, LAMC_RADAU5, LAMC_AUTO};
  for (int p = 0; p < 3; p++) {
    const lamc_ode ode = follow(pairs[p]);
    for (int m = 0; m < 3; m++) {
      const lamc_options options = tolerance(1e-6);
      lamc_run run;
      double y[2];
      CHECK(counts, solve(&ode, methods[m], &options, y0, 10.0, y, &run));
      CHECK(counts, hypot(y[0] - cos(10.0), y[1] + sin(10.0)) < 1e-4); /* a hundred times the tolerance */
      CHECK(counts, run.steps < 2500); /* an explicit method takes 300 000 at least */
    }
  }
}

static void van_der_pol_is_solved_to_the_published_digits(check_counts *counts) {
  /* mu = 1000 to t = 2000 from (2, 0): scipy.integrate.Radau gives these digits at 1e-11 and at 1e-12; the IVP test set has 1.706167732170483 */
  const double mu = 1000.0, y0[2] = {2.0, 0.0};
  const double expected[2] = {1.70616773217043, -0.00089280970102486};
  lamc_ode ode = make_ode(2, van_der_pol);
  ode.context = &mu;
  ode.jacobian = van_der_pol_jacobian;
  const lamc_method methods[] = {LAMC_RODAS5P, LAMC_RADAU5, LAMC_AUTO};
  for (int m = 0; m < 3; m++) {
    const lamc_options options = tolerance(1e-8);
    lamc_run run;
    double y[2];
    CHECK(counts, solve(&ode, methods[m], &options, y0, 2000.0, y, &run));
    CHECK(counts,
          fabs(y[0] - expected[0]) < 1e-5 && fabs(y[1] - expected[1]) < 1e-7); /* jumps amplify errors */
    CHECK(counts, run.steps < 10000); /* an explicit method takes a million */
  }
}

static void auto_says_that_it_switched(check_counts *counts) {
  const double stiff[2] = {1e10, 1e6}, soft[2] = {1.0, 0.1}, y0[2] = {1.0, 0.0};
  const lamc_options options = tolerance(1e-6);
  lamc_run run;
  double y[2];
  lamc_ode ode = follow(stiff);
  CHECK(counts, solve(&ode, LAMC_AUTO, &options, y0, 10.0, y, &run));
  CHECK(counts, run.switches >= 1 && run.switch_method[0] == LAMC_RODAS5P && run.method >= LAMC_RODAS5P);
  CHECK(counts, run.switch_t[0] > 0.0 && run.switch_t[0] < 1e-2);
  ode = follow(soft);
  CHECK(counts, solve(&ode, LAMC_AUTO, &options, y0, 10.0, y, &run));
  CHECK(counts, run.switches == 0);
}

static void implicit_methods_need_a_jacobian(check_counts *counts) {
  const lamc_ode plain = make_ode(2, oscillator), odd = make_ode(1, driven);
  CHECK(counts, lamc_run_work_size(&plain, LAMC_RODAS5P) == 0);
  CHECK(counts, lamc_run_work_size(&odd, LAMC_RADAU5) == 0);
  CHECK(counts, lamc_run_work_size(&plain, LAMC_AUTO) > 0);
}

int main(void) {
  const check_case cases[] = {
      CASE(fixed_steps_converge_with_the_order_of_the_method),
      CASE(dense_outputs_have_their_orders),
      CASE(tolerances_are_met),
      CASE(stiff_equations_take_few_steps),
      CASE(van_der_pol_is_solved_to_the_published_digits),
      CASE(auto_says_that_it_switched),
      CASE(implicit_methods_need_a_jacobian),
  };
  return check_run(cases, (int)(sizeof cases / sizeof *cases));
}
