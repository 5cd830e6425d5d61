/* slave_derivative.h: partial derivatives of what an instance tells, where it stands.
 *
 * In:    references of unknowns and knowns, seeds. Out: sensitivities, or a sentence why not.
 * Never: changes what the instance does next.
 *
 * Knowns are parameters, inputs, coordinates and rates; unknowns are all that is calculated, and coordinates and rates
 * themselves. Accelerations by coordinates and rates are the model's own Jacobian; everything else is a central
 * difference over 6e-6 of the known, the cube root of round-off, with an error of some 1e-10 of the value; at the end of a
 * parameter's range, one of the same order to the inside.
 * Loops are taken as they are, without being closed again.
 */
#ifndef SLAVE_DERIVATIVE_H
#define SLAVE_DERIVATIVE_H

#include "slave_values.h"

/* The model with `value` for one known; values of everything then. */
static MODEL(status) slave_try(slave *self, unsigned known, double value, double *values) {
  MODEL(status) status = MODEL_CODE(OK);
  double given[SLAVE_ROOM(at_coordinates)];
  memcpy(given, self->now.given, sizeof given);
  self->trial = self->now.model;
  if (known >= at_rates) {
    self->trial.u[known - at_rates] = value;
  } else if (known >= at_coordinates) {
    self->trial.q[known - at_coordinates] = value;
  } else {
    given[known] = value;
    if (known >= at_inputs) {
      MODEL(inputs) inputs;
      slave_write_inputs(given, &inputs);
      status = MODEL(set_inputs)(&self->trial, &inputs);
    } else {
      MODEL(parameters) parameters;
      slave_write_parameters(given, &parameters);
      status = MODEL(set_parameters)(&self->trial, &parameters);
    }
  }
  return status == MODEL_CODE(OK) ? slave_evaluate(&self->trial, given, values) : status;
}

/* 1 where `reach` below `value` lies beyond the range of the known, -1 where it does above, else 0 */
static int slave_at_end(unsigned known, double value, double reach) {
  if (known >= at_coordinates) return 0;
  const model_range *range = &model_range_of[known];
  if (value - reach < range->least || (range->is_open && value - reach == range->least)) return 1;
  return value + reach > range->most ? -1 : 0;
}

/* Adds seed times the derivatives of all calculated variables by one known. */
static MODEL(status) slave_add_differences(slave *self, unsigned known, double seed, double *sums) {
  const double value = self->values[known];
  const double least = known >= at_inputs || value == 0.0 ? 1.0 : 0.0; /* parameters may be small by nature */
  const double reach = 6e-6 * fmax(fabs(value), least);
  const int inwards = slave_at_end(known, value, reach);
  const double first = inwards < 0 ? value - reach : value + reach;
  const double second = inwards == 0 ? value - reach : first + inwards * reach;
  const double span = inwards == 0 ? first - second : second - value;
  const double *moved = self->moved[0], *other = self->moved[1], *here = self->values;
  MODEL(status) status = slave_try(self, known, first, self->moved[0]);
  if (status == MODEL_CODE(OK)) status = slave_try(self, known, second, self->moved[1]);
  if (status != MODEL_CODE(OK)) return status;
  for (int i = at_slopes; i < slave_variable_count; ++i) {
    const int is_exact = known >= at_coordinates && i >= at_accelerations && i < at_poses;
    const double change =
        inwards == 0 ? moved[i] - other[i] : 4.0 * (moved[i] - here[i]) - (other[i] - here[i]);
    if (!is_exact) sums[i] += seed * (change / span);
  }
  return MODEL_CODE(OK);
}

/* Adds the derivatives of accelerations by states along their seeds, which stand in `sums` at the states. */
static MODEL(status) slave_add_jacobian(const slave *self, double *sums) {
  enum { nq = MODEL(coordinate_count), nu = MODEL(rate_count) };
  double by_q[SLAVE_ROOM(nu * nq)], by_u[SLAVE_ROOM(nu * nu)];
  const MODEL(status) status = MODEL(jacobian)(&self->now.model, by_q, by_u, NULL);
  if (status != MODEL_CODE(OK)) return status;
  for (int i = 0; i < nu; ++i) {
    double sum = 0.0;
    for (int k = 0; k < nq; ++k) sum += by_q[i * nq + k] * sums[at_coordinates + k];
    for (int k = 0; k < nu; ++k) sum += by_u[i * nu + k] * sums[at_rates + k];
    sums[at_accelerations + i] += sum;
  }
  return MODEL_CODE(OK);
}

static slave_status slave_check_derivative(const slave *self, const unsigned *unknowns, size_t unknown_count,
                                           const unsigned *knowns, size_t known_count, const double *seeds,
                                           size_t seed_count, const double *results) {
  if (self->now.phase == SLAVE_INSTANTIATED) {
    return slave_refuse(self, SLAVE_ERROR, "derivatives are asked for before initialisation");
  }
  if ((unknown_count > 0 && unknowns == NULL) || (known_count > 0 && knowns == NULL) || seeds == NULL ||
      results == NULL) {
    return slave_refuse(self, SLAVE_ERROR, "derivatives are asked for, but a pointer is null");
  }
  for (size_t i = 0; i < unknown_count; ++i) {
    if (unknowns[i] < at_coordinates || unknowns[i] >= slave_variable_count) {
      return slave_refuse(self, SLAVE_ERROR, "the reference %u is of no unknown; they are %d to %d",
                          unknowns[i], at_coordinates, slave_variable_count - 1);
    }
  }
  for (size_t i = 0; i < known_count; ++i) {
    if (knowns[i] < at_parameters || knowns[i] >= at_slopes) {
      return slave_refuse(self, SLAVE_ERROR, "the reference %u is of no known; they are %d to %d", knowns[i],
                          at_parameters, at_slopes - 1);
    }
  }
  for (size_t i = 0; i < seed_count; ++i) {
    if (!isfinite(seeds[i]))
      return slave_refuse(self, SLAVE_ERROR, "a seed is %g; it must be finite", seeds[i]);
  }
  return SLAVE_OK;
}

/* Derivatives of everything along seeds of knowns, into self->sums. */
static slave_status slave_differentiate(slave *self, const unsigned *knowns, size_t known_count,
                                        const double *seeds) {
  MODEL(status) status = MODEL_CODE(OK);
  int has_states = 0;
  double *sums = self->sums;
  memset(sums, 0, sizeof self->sums);
  for (size_t k = 0; k < known_count && status == MODEL_CODE(OK); ++k) {
    if (seeds[k] == 0.0) continue;
    sums[knowns[k]] += seeds[k];
    if (knowns[k] >= at_coordinates) has_states = 1;
    status = slave_add_differences(self, knowns[k], seeds[k], sums);
  }
  if (status == MODEL_CODE(OK) && has_states) status = slave_add_jacobian(self, sums);
  if (status == MODEL_CODE(OK)) return SLAVE_OK;
  return slave_refuse(self, SLAVE_ERROR, "at %.17g s there are no derivatives: %s", self->now.model.t,
                      MODEL(status_message)(status));
}

/* results (unknowns,) = d unknowns / d knowns times seeds (knowns,) */
static slave_status slave_derivative(slave *self, const unsigned *unknowns, size_t unknown_count,
                                     const unsigned *knowns, size_t known_count, const double *seeds,
                                     double *results) {
  slave_status status =
      slave_check_derivative(self, unknowns, unknown_count, knowns, known_count, seeds, known_count, results);
  if (status == SLAVE_OK) status = slave_refresh(self);
  if (status == SLAVE_OK) status = slave_differentiate(self, knowns, known_count, seeds);
  if (status != SLAVE_OK) return status;
  for (size_t i = 0; i < unknown_count; ++i) results[i] = self->sums[unknowns[i]];
  return SLAVE_OK;
}

#endif /* SLAVE_DERIVATIVE_H */
