/* integrals.c where nothing is summed up along a run. Only lamc's amalgamation reads it. */
#include "integrals.h"

const rule lamc_gauss_4 = {0, NULL, NULL};
const rule lamc_gauss_7 = {0, NULL, NULL};

long long lamc_integrals_size(const lamc_ode *ode) {
  (void)ode;
  return 0;
}

void lamc_integrals_start(lamc_run *run, lamc_real *memory) {
  run->integrals = memory;
}

void lamc_integrals_step(lamc_run *run) {
  (void)run;
}

void lamc_integrals_before(lamc_run *run) {
  (void)run;
}

void lamc_integrals_after(lamc_run *run) {
  (void)run;
}

void lamc_integrals_at(const lamc_run *run, lamc_real t, lamc_real *integrals) {
  (void)run, (void)t, (void)integrals;
}
