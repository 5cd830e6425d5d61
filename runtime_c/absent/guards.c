/* guards.c where a model has no guards. Only lamc's amalgamation reads it. */
#include "guards.h"

long long lamc_guards_work(const lamc_model *model) {
  (void)model;
  return 0;
}

void lamc_guards_sense(const void *motion, double t, const double *y) {
  (void)motion, (void)t, (void)y;
}

void lamc_guards_values(const void *motion, double t, const double *y, double *guards) {
  (void)motion, (void)t, (void)y, (void)guards;
}

lamc_status lamc_guards_event(const void *motion, double t, double *y, const double *struck) {
  (void)motion, (void)t, (void)y, (void)struck;
  return LAMC_OK;
}
