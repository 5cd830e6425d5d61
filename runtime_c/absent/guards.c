/* guards.c where a model has no guards. Only lamc's amalgamation reads it. */
#include "guards.h"

long long lamc_guards_work(const lamc_model *model) {
  (void)model;
  return 0;
}

void lamc_guards_sense(const void *motion, lamc_real t, const lamc_real *y) {
  (void)motion, (void)t, (void)y;
}

void lamc_guards_review(const void *motion, lamc_real t, const lamc_real *y) {
  (void)motion, (void)t, (void)y;
}

void lamc_guards_values(const void *motion, lamc_real t, const lamc_real *y, lamc_real *guards) {
  (void)motion, (void)t, (void)y, (void)guards;
}

lamc_status lamc_guards_event(const void *motion, lamc_real t, lamc_real *y, const lamc_real *struck) {
  (void)motion, (void)t, (void)y, (void)struck;
  return LAMC_OK;
}
