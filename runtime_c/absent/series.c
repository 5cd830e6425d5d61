/* series.c where no input of a model follows a table. Only lamc's amalgamation reads it. */
#include "series.h"

#include <stddef.h>

long long lamc_series_work(const lamc_model *model) {
  (void)model;
  return 0;
}

const lamc_recording *lamc_series_recording(const lamc_motion *motion) {
  (void)motion;
  return NULL;
}

void lamc_series_write(const lamc_motion *motion, lamc_real t) {
  (void)motion, (void)t;
}

void lamc_series_pass(const void *motion, long long next) {
  (void)motion, (void)next;
}
