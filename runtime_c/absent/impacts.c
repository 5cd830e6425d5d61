/* impacts.c where a model has no guards. Only lamc's amalgamation reads it. */
#include "impacts.h"

long long lamc_impacts_work(const lamc_model *model) {
  (void)model;
  return 0;
}

void lamc_impacts(const lamc_motion *motion, lamc_real t, lamc_real *y, const lamc_real *struck) {
  (void)motion, (void)t, (void)y, (void)struck;
}
