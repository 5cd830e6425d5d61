/* threads.c: many runs at once of one equation, whose records all threads share, end with the bits of a run alone. Built
 * under -fsanitize=thread by `make tsan`: anything that the runtime shares between runs is told there. */
#include "check.h"
#include "lamc.h"

#include <pthread.h>
#include <string.h>

enum { THREADS = 8, ROWS = 200, ROOM = 4096 };

static const double STIFFNESS = 40.0; /* 1/s^2 */

static void oscillator(const void *context, double t, const double *y, double *dydt) {
  (void)t;
  const double stiffness = *(const double *)context;
  dydt[0] = y[1];
  dydt[1] = -stiffness * y[0] * (1.0 + y[0] * y[0]);
}

static void derivatives(const void *context, double t, const double *y, double *by_q, double *by_u,
                        double *by_t, double *scratch) {
  (void)t, (void)scratch;
  by_q[0] = -*(const double *)context * (1.0 + 3.0 * y[0] * y[0]);
  by_u[0] = by_t[0] = 0.0;
}

static const lamc_ode ODE = {.n = 2, .rhs = oscillator, .context = &STIFFNESS, .jacobian = derivatives};
static const lamc_options OPTIONS = {1e-7, 1e-9, 0.0, 0.0, 100000};

typedef struct job {
  lamc_method method;
  lamc_status status;
  double y[2 * ROWS];
} job;

static void *run_job(void *given) {
  job *mine = (job *)given;
  static const double start[2] = {1.0, 0.0};
  double times[ROWS], t[ROWS], work[ROOM];
  lamc_run run;
  lamc_rows rows;
  for (int i = 0; i < ROWS; i++) times[i] = 0.01 * i;
  memset(&rows, 0, sizeof rows);
  rows.t = t;
  rows.y = mine->y;
  rows.capacity = ROWS;
  if (lamc_run_work_size(&ODE, mine->method) > ROOM) return NULL;
  mine->status =
      lamc_run_start(&run, &ODE, mine->method, &OPTIONS, 0.0, start, times[ROWS - 1], times, ROWS, work);
  if (mine->status == LAMC_OK) mine->status = lamc_run_advance(&run, &rows, 1000000, NULL);
  return NULL;
}

static void runs_at_once_end_with_the_bits_of_a_run_alone(check_counts *counts) {
  static const lamc_method METHODS[] = {LAMC_AUTO, LAMC_RK45, LAMC_DOP853, LAMC_RODAS5P, LAMC_RADAU5};
  static job alone, together[THREADS];
  for (int m = 0; m < 5; m++) {
    pthread_t threads[THREADS];
    memset(&alone, 0, sizeof alone);
    memset(together, 0, sizeof together);
    alone.method = METHODS[m];
    alone.status = LAMC_BAD_ARGUMENT;
    (void)run_job(&alone);
    CHECK(counts, alone.status == LAMC_OK);
    for (int k = 0; k < THREADS; k++) {
      together[k].method = METHODS[m];
      CHECK(counts, pthread_create(&threads[k], NULL, run_job, &together[k]) == 0);
    }
    for (int k = 0; k < THREADS; k++) {
      CHECK(counts, pthread_join(threads[k], NULL) == 0);
      CHECK(counts, memcmp(together[k].y, alone.y, sizeof alone.y) == 0);
    }
  }
}

int main(void) {
  const check_case cases[] = {CASE(runs_at_once_end_with_the_bits_of_a_run_alone)};
  return check_run(cases, 1);
}
