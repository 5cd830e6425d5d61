/* test_fixed.c: steps of a length that the caller chooses, explicit and for stiff equations. */
#include "check.h"
#include "lamc.h"
#include "problems.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { SCRATCH = 1000 };

/* Error of the oscillator at t = 1 by so many steps of one length */
static double error_of(int steps) {
  const lamc_ode ode = make_ode(2, oscillator);
  double y[2] = {0.0, 1.0}, scratch[7];
  for (int i = 0; i < steps; i++) (void)lamc_fixed_step(&ode, (double)i / steps, 1.0 / steps, y, scratch);
  return hypot(y[0] - sin(1.0), y[1] - cos(1.0));
}

static void steps_of_one_length_are_of_order_four(check_counts *counts) {
  const lamc_ode ode = make_ode(2, oscillator);
  CHECK(counts, lamc_fixed_scratch(&ode) <= 7);
  const double order = log2(error_of(20) / error_of(40));
  CHECK(counts, fabs(order - 4.0) < 0.1); /* the next term is a twentieth of h of the first */
}

static void a_step_of_one_length_gets_the_times_of_its_stages(check_counts *counts) {
  const lamc_ode ode = make_ode(1, driven);
  double y[1] = {1.0}, scratch[4];
  for (int i = 0; i < 1000; i++) (void)lamc_fixed_step(&ode, 1e-3 * i, 1e-3, y, scratch);
  CHECK(counts, fabs(y[0] - exp(sin(1.0))) < 1e-12); /* h^4, and a thousand roundings */
}

static void a_step_into_nothing_says_so(check_counts *counts) {
  const lamc_ode ode = make_ode(1, ends_at_one);
  double y[1] = {0.0}, scratch[4];
  CHECK(counts, lamc_fixed_step(&ode, 0.9, 0.05, y, scratch) == LAMC_OK);
  CHECK(counts, lamc_fixed_step(&ode, 0.95, 0.5, y, scratch) == LAMC_NOT_FINITE);
}

/* y'' = -k (y - cos t) - c (y' + sin t) - cos t */
static lamc_ode follow(const double *k_and_c) {
  lamc_ode ode = make_ode(2, follower);
  ode.context = k_and_c;
  ode.jacobian = follower_jacobian;
  return ode;
}

/* Error of Van der Pol's equation, mu = 1, at t = 3 by so many stiff steps of one length */
static double stiff_error_of(int steps) {
  const double mu = 1.0, exact[2] = {-1.86607391106108, -1.02106034019586}; /* scipy's DOP853 at 3e-14 */
  double y[2] = {2.0, 0.0}, scratch[SCRATCH];
  lamc_ode ode = make_ode(2, van_der_pol);
  ode.context = &mu;
  ode.jacobian = van_der_pol_jacobian;
  for (int i = 0; i < steps; i++) (void)lamc_stiff_step(&ode, 3.0 * i / steps, 3.0 / steps, y, scratch);
  return hypot(y[0] - exact[0], y[1] - exact[1]);
}

static void stiff_steps_of_one_length_are_of_order_five(check_counts *counts) {
  const double order = log2(stiff_error_of(160) / stiff_error_of(320));
  CHECK(counts, fabs(order - 5.0) < 0.3); /* the next term of the error expansion is still there */
}

static void a_stiff_step_is_that_of_a_run_to_the_last_bit(check_counts *counts) {
  const double k_and_c[2] = {1e4, 3.0}, y0[2] = {0.9, 0.1}, h = 0.0625;
  const lamc_ode ode = follow(k_and_c);
  const lamc_options options = fixed_step(h);
  double work[SCRATCH], scratch[SCRATCH], y[2] = {0.9, 0.1};
  lamc_run run;
  CHECK(counts, lamc_stiff_scratch(&ode) > 0 && lamc_stiff_scratch(&ode) <= SCRATCH);
  CHECK(counts, lamc_run_start(&run, &ode, LAMC_RODAS5P, &options, 0.0, y0, 1.0, NULL, 0, work) == LAMC_OK);
  for (int i = 0; i < 16; i++) {
    CHECK(counts, lamc_run_step(&run) == LAMC_OK && run.t == h * (i + 1));
    CHECK(counts, lamc_stiff_step(&ode, h * i, h, y, scratch) == LAMC_OK);
    CHECK(counts, memcmp(y, lamc_run_state(&run), sizeof y) == 0);
  }
}

static void no_stiffness_limits_a_stiff_step(check_counts *counts) {
  const double h = 0.01;
  for (double k = 1e2; k < 1e17; k *= 1e3) {
    const double k_and_c[2] = {k, 0.0};
    const lamc_ode ode = follow(k_and_c);
    double y[2] = {1.0, 0.0}, scratch[SCRATCH];
    for (int i = 0; i < 1000; i++) CHECK(counts, lamc_stiff_step(&ode, h * i, h, y, scratch) == LAMC_OK);
    CHECK(counts, fabs(y[0] - cos(10.0)) < 1e-9); /* h^5, over ten seconds */
  }
}

static void a_stiff_step_without_a_jacobian_is_refused(check_counts *counts) {
  const lamc_ode ode = make_ode(2, oscillator);
  double y[2] = {0.0, 1.0}, scratch[1];
  CHECK(counts, lamc_stiff_scratch(&ode) == 0);
  CHECK(counts, lamc_stiff_step(&ode, 0.0, 0.1, y, scratch) == LAMC_BAD_ARGUMENT);
  CHECK(counts, y[0] == 0.0 && y[1] == 1.0);
}

static void a_stiff_step_into_nothing_says_so(check_counts *counts) {
  const double k_and_c[2] = {NAN, 0.0};
  const lamc_ode ode = follow(k_and_c);
  double y[2] = {1.0, 0.0}, scratch[SCRATCH];
  CHECK(counts, lamc_stiff_step(&ode, 0.0, 0.1, y, scratch) == LAMC_NOT_FINITE);
}

int main(void) {
  const check_case cases[] = {
      CASE(steps_of_one_length_are_of_order_four),
      CASE(a_step_of_one_length_gets_the_times_of_its_stages),
      CASE(a_step_into_nothing_says_so),
      CASE(stiff_steps_of_one_length_are_of_order_five),
      CASE(a_stiff_step_is_that_of_a_run_to_the_last_bit),
      CASE(no_stiffness_limits_a_stiff_step),
      CASE(a_stiff_step_without_a_jacobian_is_refused),
      CASE(a_stiff_step_into_nothing_says_so),
  };
  return check_run(cases, sizeof cases / sizeof *cases);
}
