/* powers.c where a model tells no powers. Only lamc's amalgamation reads it. */
#include "powers.h"

long long lamc_powers_work(const lamc_model *model) {
  (void)model;
  return 0;
}

void lamc_powers(const lamc_motion *motion, lamc_real t, const lamc_real *y, lamc_real *power) {
  (void)motion, (void)t, (void)y, (void)power;
}

void lamc_powers_integrands(const void *motion, lamc_real t, const lamc_real *y, lamc_real *values) {
  (void)motion, (void)t, (void)y, (void)values;
}

void lamc_powers_jump(const void *motion, lamc_real t, const lamc_real *before, const lamc_real *after,
                      lamc_real *integrals) {
  (void)motion, (void)t, (void)before, (void)after, (void)integrals;
}
