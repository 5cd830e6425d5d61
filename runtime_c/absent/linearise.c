/* linearise.c where no method is implicit and nobody asks for derivatives. Only lamc's amalgamation reads it. */
#include "linearise.h"

long long lamc_linearise_scratch(const lamc_model *model) {
  (void)model;
  return 0;
}

double lamc_linearise_cost(const lamc_motion *motion) {
  (void)motion;
  return 0.0;
}

void lamc_linearise(const void *motion, double t, const double *y, double *by_q, double *by_u, double *by_t,
                    double *scratch) {
  (void)motion, (void)t, (void)y, (void)by_q, (void)by_u, (void)by_t, (void)scratch;
}

void lamc_linearise_fully(const void *motion, double t, const double *y, double *by_y, double *by_t,
                          double *scratch) {
  (void)motion, (void)t, (void)y, (void)by_y, (void)by_t, (void)scratch;
}
