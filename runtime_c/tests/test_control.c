/* test_control.c: how long steps are: logarithm and power of step control, and limits that a caller sets. */
#include "../src/control.h"
#include "check.h"
#include "lamc.h"
#include "problems.h"

#include <math.h>

enum { WORK = 16 * 4, MOST_ROWS = 5000 };

static const double AT_ZERO[2] = {0.0, 1.0};

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

int main(void) {
  const check_case cases[] = {
      CASE(logarithms_and_powers_of_control_have_their_digits),
      CASE(the_longest_and_the_first_step_are_obeyed),
  };
  return check_run(cases, (int)(sizeof cases / sizeof *cases));
}
