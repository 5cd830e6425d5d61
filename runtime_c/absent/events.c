/* events.c where an equation has no guards and no integrals. Only lamc's amalgamation reads it. */
#include "events.h"

long long lamc_events_size(const lamc_ode *ode) {
  (void)ode;
  return 0;
}

void lamc_events_start(lamc_run *run, lamc_real *memory) {
  run->guards = memory;
}

int lamc_events_due(const lamc_run *run) {
  (void)run;
  return 0;
}

lamc_status lamc_events_after_step(lamc_run *run) {
  (void)run;
  return LAMC_OK;
}

lamc_status lamc_events_at_break(lamc_run *run) {
  (void)run;
  return LAMC_OK;
}
