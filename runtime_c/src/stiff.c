/* stiff.c, of lamc: steps of a length that the caller chooses where hinges are stiff, for a bounded cost per step.
 *
 * In: a lamc_ode with its Jacobian, a state, a step. Out: the state at its end. Never: tries a step again, or looks at its
 * error.
 *
 * One step of Rodas5P: L-stable, so that no stiffness limits h, and without iterations, so that every step costs the same:
 * eight evaluations, one Jacobian, one factorisation. It is the step that an adaptive run takes, to the last bit. */
#include "fixed.h"

/* Numbers of the method */
static long long size_of_method(const lamc_ode *ode) {
  const long long extra = lamc_method_rodas5p.extra(ode);
  return extra == 0 ? 0 : (long long)(SLOT_OWN + lamc_method_rodas5p.slots) * padded(ode->n) + extra;
}

long long lamc_stiff_scratch(const lamc_ode *ode) {
  const long long size = size_of_method(ode);
  return size == 0 ? 0 : size + lamc_fixed_guards(ode);
}

lamc_status lamc_stiff_step(const lamc_ode *ode, lamc_real t, lamc_real h, lamc_real *y, lamc_real *scratch) {
  const long long size = size_of_method(ode);
  const size_t bytes = (size_t)ode->n * sizeof *y;
  lamc_run run;
  if (size == 0) return LAMC_BAD_ARGUMENT;
  memset(&run, 0, sizeof run);
  memset(scratch, 0, (size_t)size * sizeof *scratch);
  run.ode = *ode;
  run.options.rtol = run.options.atol = 1; /* of an error that is not looked at */
  run.stride = padded(ode->n);
  run.work = scratch;
  memcpy(y_here(&run), y, bytes);
  run.t = lamc_fixed_begin(ode, t, h);
  lamc_fixed_review(ode, run.t, y);
  evaluate(&run, run.t, y, slope_here(&run));
  if (!all_finite(&run, slope_here(&run))) return LAMC_NOT_FINITE;
  const lamc_real squared = lamc_method_rodas5p.attempt(&run, h);
  memcpy(y, y_there(&run), bytes);
  if (!is_finite(squared)) return LAMC_NOT_FINITE;
  return lamc_fixed_end(ode, t + h, y, scratch + size);
}
