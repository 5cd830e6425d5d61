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

void lamc_system_acceleration(const lamc_motion *motion, double t, const double *q, const double *u,
                              double *udot) {
  (void)motion, (void)t, (void)q, (void)u, (void)udot;
}

void lamc_system_response(const lamc_motion *motion, double *x) {
  (void)motion, (void)x;
}
