/* system.c where the model solves M udot = f, or has loops. Only lamc's amalgamation reads it. */
#include "system.h"

int lamc_is_system(const lamc_model *model) {
  (void)model;
  return 0;
}

long long lamc_system_work(const lamc_model *model) {
  (void)model;
  return 0;
}

void lamc_system_acceleration(const lamc_motion *motion, lamc_real t, const lamc_real *q, const lamc_real *u,
                              lamc_real *udot) {
  (void)motion, (void)t, (void)q, (void)u, (void)udot;
}

void lamc_system_response(const lamc_motion *motion, lamc_real *x) {
  (void)motion, (void)x;
}
