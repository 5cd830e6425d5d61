/* system.c, of lamc: M udot = f by Cholesky's method, for a motion without loops whose model does not solve it.
 *
 * In: M and f from a model. Out: accelerations, and responses to other right-hand sides with the same factors.
 * Never: goes on with a mass matrix that is not positive: all that follows from it is NaN. */
#include "system.h"

#include "cholesky.h"

#include <string.h>

int lamc_is_system(const lamc_model *model) {
  return model->acceleration == NULL && model->cut_count == 0;
}

/* work: L (nu, nu), then what the model writes */
long long lamc_system_work(const lamc_model *model) {
  const long long n = model->rate_count;
  return lamc_is_system(model) ? n * n + n * (n + 1) / 2 + n : 0;
}

void lamc_system_acceleration(const lamc_motion *motion, lamc_real t, const lamc_real *q, const lamc_real *u,
                              lamc_real *udot) {
  const int n = motion->model->rate_count;
  lamc_real *l = motion->work, *raw = l + (ptrdiff_t)n * n;
  motion->model->system(motion->constants, t, q, u, raw);
  lamc_cholesky(n, raw, l);
  memcpy(udot, raw + (ptrdiff_t)n * (n + 1) / 2, (size_t)n * sizeof *udot);
  lamc_system_response(motion, udot);
}

void lamc_system_response(const lamc_motion *motion, lamc_real *x) {
  lamc_solve_lower(motion->model->rate_count, motion->work, x);
  lamc_solve_upper(motion->model->rate_count, motion->work, x);
}
