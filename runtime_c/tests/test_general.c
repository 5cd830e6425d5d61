/* test_general.c: motions that are no tree of hinges: a floating rigid body with a quaternion, by every method, with
 * events and with the work of its forces. */
#include "check.h"
#include "free_body.h"
#include "problems.h"

#include <stdlib.h>

enum { WORK = 4000, MOTION_WORK = 256 };

static const lamc_method METHODS[] = {LAMC_AUTO, LAMC_RK45, LAMC_DOP853, LAMC_RODAS5P, LAMC_RADAU5};
enum { METHOD_COUNT = sizeof METHODS / sizeof *METHODS };

static double norm(const double *v) {
  return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* A run of the body from y0 to t_end; its last row, and integrals if they are wanted */
static lamc_status drive(const lamc_model *model, const double *parameters, lamc_method method, double rtol,
                         const double *y0, double t_end, double *y, double *integrals, lamc_run *run) {
  static double work[WORK], motion_work[MOTION_WORK], constants[6];
  model->setup(parameters, constants);
  const lamc_motion motion = {model, constants, motion_work, 0.0, NULL};
  const lamc_ode ode = lamc_motion_ode(&motion);
  if (lamc_motion_work_size(model) > MOTION_WORK || lamc_run_work_size(&ode, method) > WORK) abort();
  const lamc_options options = tolerance(rtol);
  double t;
  lamc_rows rows = {&t, y, 1, 0, NULL, NULL, 0, 0, integrals};
  const lamc_status status = lamc_run_start(run, &ode, method, &options, 0.0, y0, t_end, &t_end, 1, work);
  return status != LAMC_OK ? status : lamc_run_advance(run, &rows, 0, NULL);
}

/* A torque-free body with moments (A, A, C): its axis goes around the angular momentum L, which stays, at |L| / A */
static void a_symmetric_top_precesses_at_its_rate(check_counts *counts) {
  const double p[6] = {2.0, 0.3, 0.3, 0.5, 0.0, 0.0}, t_end = 3.0;
  const double y0[SIZE] = {1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0, 0.1, -0.2, 0.3, 0.4, 0.0, 2.0};
  const double momentum[3] = {0.3 * 0.4, 0.0, 0.5 * 2.0}; /* world axes are the body's at first */
  const double angle = norm(momentum) / 0.3 * t_end, l = norm(momentum);
  const double e[3] = {momentum[0] / l, 0.0, momentum[2] / l};
  /* Rodrigues: (0, 0, 1) turned about e by the angle */
  const double axis[3] = {e[2] * e[0] * (1.0 - cos(angle)), -e[0] * sin(angle),
                          cos(angle) + e[2] * e[2] * (1.0 - cos(angle))};
  for (int analytic = 0; analytic < 2; analytic++) {
    const lamc_model model = free_body(analytic, 0);
    for (int m = 0; m < METHOD_COUNT; m++) {
      double y[SIZE], pose[12], energies[3];
      lamc_run run;
      CHECK(counts, drive(&model, p, METHODS[m], 1e-9, y0, t_end, y, NULL, &run) == LAMC_OK);
      body_poses(p, t_end, y, pose);
      body_energy(p, t_end, y, y + NQ, energies);
      /* some 100 to 1000 steps of 1e-9 each, which add up at worst */
      for (int i = 0; i < 3; i++) CHECK(counts, fabs(pose[3 + 3 * i + 2] - axis[i]) < 1e-6);
      for (int i = 0; i < 3; i++) {
        const double *row = pose + 3 + 3 * i;
        const double now = row[0] * p[1] * y[10] + row[1] * p[2] * y[11] + row[2] * p[3] * y[12];
        CHECK(counts, fabs(now - momentum[i]) < 1e-6);
        CHECK(counts,
              fabs(y[i] - (y0[i] + t_end * y0[NQ + i])) < 1e-9); /* straight on: exact but for rounding */
      }
      CHECK(counts, fabs(energies[0] - 0.5 * (2.0 * 0.14 + 0.3 * 0.16 + 0.5 * 4.0)) < 1e-7);
      CHECK(counts, fabs(sqrt(y[3] * y[3] + y[4] * y[4] + y[5] * y[5] + y[6] * y[6]) - 1.0) < 1e-6);
    }
  }
}

/* The Jacobian by residuals against the one by differences, and what it costs */
static void both_jacobians_agree(check_counts *counts) {
  const double p[6] = {2.0, 0.3, 0.4, 0.5, 9.81, 7.0};
  const double y[SIZE] = {0.1, -0.2, 0.3, 0.9, 0.1, -0.3, 0.4, 0.5, -0.6, 0.7, 1.1, -1.2, 1.3};
  double full[2][SIZE * SIZE], late[2][SIZE], constants[6], motion_work[MOTION_WORK], scratch[1000];
  for (int analytic = 0; analytic < 2; analytic++) {
    const lamc_model model = free_body(analytic, 0);
    model.setup(p, constants);
    const lamc_motion motion = {&model, constants, motion_work, 0.0, NULL};
    const lamc_ode ode = lamc_motion_ode(&motion);
    CHECK(counts, ode.jacobian == NULL && ode.full_jacobian != NULL && ode.scratch_size <= 1000);
    ode.full_jacobian(ode.context, 0.0, y, full[analytic], late[analytic], scratch);
  }
  for (int i = 0; i < SIZE * SIZE; i++)
    CHECK(counts,
          fabs(full[0][i] - full[1][i]) < 1e-6); /* forward differences: half the digits of numbers to 4 */
  for (int i = 0; i < SIZE; i++) CHECK(counts, fabs(late[0][i]) < 1e-6 && late[1][i] == 0.0);
}

/* A stiff spring under the body: implicit methods step over its period, and LAMC_AUTO finds them */
static void a_stiff_spring_is_stepped_over(check_counts *counts) {
  const double p[6] = {1.0, 0.3, 0.4, 0.5, 0.0, 1e10}; /* 1e5 rad/s */
  const double y0[SIZE] = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.1, 0.2, 0.3};
  const lamc_model model = free_body(1, 0);
  double truth[SIZE], y[SIZE];
  lamc_run run;
  const double soft[6] = {1.0, 0.3, 0.4, 0.5, 0.0, 0.0};
  CHECK(counts, drive(&model, soft, LAMC_DOP853, 1e-12, y0, 2.0, truth, NULL, &run) == LAMC_OK);
  const lamc_method implicit[] = {LAMC_RODAS5P, LAMC_RADAU5};
  for (int m = 0; m < 2; m++) {
    CHECK(counts, drive(&model, p, implicit[m], 1e-8, y0, 2.0, y, NULL, &run) == LAMC_OK);
    CHECK(counts, run.steps < 2000); /* an explicit method would need 1e5 */
    for (int i = 0; i < SIZE; i++) CHECK(counts, fabs(y[i] - truth[i]) < 1e-6);
  }
  double trembling[SIZE];
  memcpy(trembling, y0, sizeof y0);
  trembling[2] = 1e-9; /* too little to matter, and fast */
  CHECK(counts, drive(&model, p, LAMC_AUTO, 1e-6, trembling, 2.0, y, NULL, &run) == LAMC_OK);
  CHECK(counts, run.switches > 0 && run.steps < 5000);
  for (int i = 3; i < NQ; i++) CHECK(counts, fabs(y[i] - truth[i]) < 1e-4);
}

/* An equation in full form gives what it gives in halves */
static void follower_fully(const void *context, double t, const double *y, double *by_y, double *by_t,
                           double *scratch) {
  follower_jacobian(context, t, y, by_y + 2, by_y + 3, by_t + 1, scratch);
  by_y[0] = by_t[0] = 0.0;
  by_y[1] = 1.0;
}

static void halves_and_whole_take_the_same_steps(check_counts *counts) {
  const double context[2] = {1e6, 10.0}, y0[2] = {1.0, 0.0}, t_end = 3.0;
  const lamc_method implicit[] = {LAMC_RODAS5P, LAMC_RADAU5};
  for (int m = 0; m < 2; m++) {
    long long steps[2];
    double last[2][2];
    for (int full = 0; full < 2; full++) {
      double t, work[400];
      lamc_ode ode = make_ode(2, follower);
      lamc_run run;
      lamc_rows rows = make_rows(&t, last[full], 1);
      const lamc_options options = tolerance(1e-7);
      ode.context = context;
      if (full) {
        ode.full_jacobian = follower_fully;
      } else {
        ode.jacobian = follower_jacobian;
      }
      CHECK(counts, lamc_run_work_size(&ode, implicit[m]) <= 400);
      CHECK(counts,
            lamc_run_start(&run, &ode, implicit[m], &options, 0.0, y0, t_end, &t_end, 1, work) == LAMC_OK);
      CHECK(counts, lamc_run_advance(&run, &rows, 0, NULL) == LAMC_OK);
      steps[full] = run.steps;
    }
    CHECK(counts, llabs(steps[0] - steps[1]) <= steps[0] / 20); /* rounding turns some choices */
    CHECK(counts, fabs(last[0][0] - cos(t_end)) < 1e-6 && fabs(last[1][0] - cos(t_end)) < 1e-6);
  }
}

/* Dropped from h, bouncing with restitution 1/2: impacts at sqrt(2 h / g) and twice that, each taking 3/4 of
 * the kinetic energy there is */
static void a_ball_bounces_and_its_books_close(check_counts *counts) {
  const double h = 1.0, g = 9.81, p[6] = {2.0, 0.3, 0.4, 0.5, g, 0.0};
  const double y0[SIZE] = {0.0, 0.0, h, 1.0, 0.0, 0.0, 0.0, 0.3, 0.0, 0.0, 1.0, 2.0, 3.0};
  const double fall = sqrt(2.0 * h / g), t_end = 2.2 * fall; /* on the second rise */
  for (int m = 0; m < METHOD_COUNT; m++) {
    const lamc_model model = free_body(1, 1);
    double y[SIZE], work[3], start[3], end[3];
    lamc_run run;
    CHECK(counts, drive(&model, p, METHODS[m], 1e-10, y0, t_end, y, work, &run) == LAMC_OK);
    CHECK(counts, run.events == 2 && fabs(run.t_event - 2.0 * fall) < 1e-8);
    const double tau = 0.2 * fall, speed = 0.25 * sqrt(2.0 * g * h);
    CHECK(counts, fabs(y[2] - (speed * tau - 0.5 * g * tau * tau)) < 1e-8);
    body_energy(p, 0.0, y0, y0 + NQ, start);
    body_energy(p, t_end, y, y + NQ, end);
    CHECK(counts,
          fabs(work[0] + end[1] - start[1]) < 1e-8 * 2.0 * g * h); /* gravity: minus the change of m g z */
    CHECK(counts, work[1] == 0.0);
    const double lost = -0.75 * 2.0 * g * h * (1.0 + 0.25);
    CHECK(counts, fabs(work[2] - lost) < 1e-8 * 2.0 * g * h);
    CHECK(counts, fabs(end[0] - start[0] - work[0] - work[1] - work[2]) < 1e-8 * 2.0 * g * h);
  }
}

/* ---- Integrals ---------------------------------------------------------------------------------------------- */

/* Of the oscillator (sin t, cos t): of y0^2, t/2 - sin 2t / 4, and of t y1, t sin t + cos t - 1 */
static void integrands(const void *context, double t, const double *y, double *values) {
  (void)context;
  values[0] = y[0] * y[0];
  values[1] = t * y[1];
}

static void oscillator_jacobian(const void *context, double t, const double *y, double *by_q, double *by_u,
                                double *by_t, double *scratch) {
  (void)context, (void)t, (void)y, (void)scratch;
  by_q[0] = -1.0;
  by_u[0] = by_t[0] = 0.0;
}

enum { TIMES = 37 };

static lamc_status oscillate(lamc_method method, double rtol, int count, double *y, double *integrals,
                             lamc_run *run) {
  static double work[1000], t[TIMES], times[TIMES];
  lamc_ode ode = make_ode(2, oscillator);
  const double y0[2] = {0.0, 1.0};
  const lamc_options options = tolerance(rtol);
  lamc_rows rows = {t, y, TIMES, 0, NULL, NULL, 0, 0, integrals};
  for (int i = 0; i < TIMES; i++) times[i] = 12.0 * i / (TIMES - 1);
  ode.jacobian = oscillator_jacobian;
  ode.integral_count = count;
  ode.integrands = integrands;
  if (lamc_run_work_size(&ode, method) > 1000) abort();
  const lamc_status status = lamc_run_start(run, &ode, method, &options, 0.0, y0, 12.0, times, TIMES, work);
  return status != LAMC_OK ? status : lamc_run_advance(run, &rows, 0, NULL);
}

static void integrals_are_as_accurate_as_states(check_counts *counts) {
  for (int m = 1; m < METHOD_COUNT; m++) {
    for (double rtol = 1e-5; rtol > 1e-12; rtol *= 1e-3) {
      double y[2 * TIMES], integrals[2 * TIMES], worst = 0.0, state = 0.0;
      lamc_run run;
      CHECK(counts, oscillate(METHODS[m], rtol, 2, y, integrals, &run) == LAMC_OK);
      for (int i = 0; i < TIMES; i++) {
        const double t = 12.0 * i / (TIMES - 1);
        state = fmax(state, fabs(y[2 * i] - sin(t)));
        worst = fmax(worst, fabs(integrals[2 * i] - (0.5 * t - 0.25 * sin(2.0 * t))));
        worst = fmax(worst, fabs(integrals[2 * i + 1] - (t * sin(t) + cos(t) - 1.0)));
      }
      /* t times the error of a state, over 12 s; and round-off of numbers up to 12 */
      CHECK(counts, worst < 12.0 * state + 1e-13);
    }
  }
}

/* LAMC_AUTO goes by the stages of a step, which integrals must leave to it */
static void integrals_leave_the_choice_of_method_alone(check_counts *counts) {
  const double context[2] = {1e8, 1.0}, y0[2] = {1.0, 0.0};
  double last[2][2];
  lamc_run runs[2];
  for (int with = 0; with < 2; with++) {
    static double work[1000];
    double t, t_end = 20.0;
    lamc_ode ode = make_ode(2, follower);
    lamc_rows rows = make_rows(&t, last[with], 1);
    const lamc_options options = tolerance(1e-6);
    ode.context = context;
    ode.jacobian = follower_jacobian;
    ode.integral_count = with ? 2 : 0;
    ode.integrands = integrands;
    CHECK(counts, lamc_run_work_size(&ode, LAMC_AUTO) <= 1000);
    CHECK(counts,
          lamc_run_start(&runs[with], &ode, LAMC_AUTO, &options, 0.0, y0, t_end, &t_end, 1, work) == LAMC_OK);
    CHECK(counts, lamc_run_advance(&runs[with], &rows, 0, NULL) == LAMC_OK);
  }
  CHECK(counts, runs[0].switches > 0 && runs[0].switches == runs[1].switches);
  CHECK(counts, memcmp(last[0], last[1], sizeof last[0]) == 0 && runs[0].steps == runs[1].steps);
}

static void integrals_leave_the_states_alone(check_counts *counts) {
  for (int m = 0; m < METHOD_COUNT; m++) {
    double with[2 * TIMES], without[2 * TIMES], integrals[2 * TIMES];
    lamc_run first, second;
    CHECK(counts, oscillate(METHODS[m], 1e-7, 2, with, integrals, &first) == LAMC_OK);
    CHECK(counts, oscillate(METHODS[m], 1e-7, 0, without, NULL, &second) == LAMC_OK);
    CHECK(counts, memcmp(with, without, sizeof with) == 0 && first.steps == second.steps);
  }
}

int main(void) {
  const check_case cases[] = {
      CASE(a_symmetric_top_precesses_at_its_rate), CASE(both_jacobians_agree),
      CASE(a_stiff_spring_is_stepped_over),        CASE(halves_and_whole_take_the_same_steps),
      CASE(a_ball_bounces_and_its_books_close),    CASE(integrals_are_as_accurate_as_states),
      CASE(integrals_leave_the_states_alone),      CASE(integrals_leave_the_choice_of_method_alone),
  };
  return check_run(cases, (int)(sizeof cases / sizeof *cases));
}
