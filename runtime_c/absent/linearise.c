/* linearise.c where no method is implicit and nobody asks for derivatives. Only lamc's amalgamation reads it. */
#include "linearise.h"

long long lamc_linearise_scratch(const lamc_model *model) {
  (void)model;
  return 0;
}

lamc_real lamc_linearise_cost(const lamc_motion *motion) {
  (void)motion;
  return 0;
}

void lamc_linearise(const void *motion, lamc_real t, const lamc_real *y, lamc_real *by_q, lamc_real *by_u,
                    lamc_real *by_t, lamc_real *scratch) {
  (void)motion, (void)t, (void)y, (void)by_q, (void)by_u, (void)by_t, (void)scratch;
}

void lamc_linearise_fully(const void *motion, lamc_real t, const lamc_real *y, lamc_real *by_y,
                          lamc_real *by_t, lamc_real *scratch) {
  (void)motion, (void)t, (void)y, (void)by_y, (void)by_t, (void)scratch;
}
