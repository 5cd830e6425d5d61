/* slave_values.h: values of an instance's variables, set and told.
 *
 * In:    references and values. Out: the same, or a sentence why not.
 * Never: takes a part of what is set in one call: all of it is looked at first.
 */
#ifndef SLAVE_VALUES_H
#define SLAVE_VALUES_H

#include "slave.h"

/* Whether `value` may be given to the variable now. */
static slave_status slave_check(const slave *self, unsigned reference, double value) {
  const int phase = self->now.phase;
  if (reference >= slave_variable_count) {
    return slave_refuse(self, SLAVE_ERROR, "no real variable has the reference %u; they are 0 to %d",
                        reference, slave_variable_count - 1);
  }
  const char *name = model_variable_name[reference];
  if (!isfinite(value))
    return slave_refuse(self, SLAVE_ERROR, "%s is set to %g; it must be finite", name, value);
  if (reference < at_parameters || reference >= at_slopes) {
    return slave_refuse(self, SLAVE_ERROR, "%s is set, but it is calculated", name);
  }
  if (phase == SLAVE_TERMINATED) return slave_refuse(self, SLAVE_ERROR, "%s is set after the end", name);
  if (reference >= at_coordinates) {
    if (phase == SLAVE_STEPPING) {
      return slave_refuse(self, SLAVE_ERROR,
                          "%s is set while it moves; a start is set before initialisation ends", name);
    }
    return SLAVE_OK;
  }
  const model_range *range = &model_range_of[reference];
  if (range->is_fixed && phase == SLAVE_STEPPING) {
    return slave_refuse(self, SLAVE_ERROR, "%s is set while it moves, but it is fixed by initialisation",
                        name);
  }
  if (value < range->least || value > range->most || (range->is_open && value == range->least)) {
    return slave_refuse(self, SLAVE_ERROR, "%s is set to %.17g; it must be %s %g and at most %g", name, value,
                        range->is_open ? "above" : "at least", range->least, range->most);
  }
  return SLAVE_OK;
}

static slave_status slave_set(slave *self, const unsigned *references, size_t count, const double *values) {
  slave_record *now = &self->now;
  if (count > 0 && (references == NULL || values == NULL)) {
    return slave_refuse(self, SLAVE_ERROR, "values are set, but there are none: the pointer is null");
  }
  for (size_t i = 0; i < count; ++i) {
    const slave_status status = slave_check(self, references[i], values[i]);
    if (status != SLAVE_OK) return status;
  }
  for (size_t i = 0; i < count; ++i) {
    const unsigned k = references[i];
    double *place = k >= at_coordinates ? &now->y[k - at_coordinates] : &now->given[k];
    const int is_new = *place != values[i];
    *place = values[i];
    if (k >= at_coordinates) {
      now->is_placed = 1;
    } else if (is_new && k >= at_inputs) {
      now->has_new_inputs = now->is_driven = 1;
    } else if (is_new) {
      now->has_new_parameters = 1;
    }
    if (now->phase != SLAVE_STEPPING) now->is_fresh = 1;
    self->has_values = 0;
  }
  return SLAVE_OK;
}

/* All variables of a model as it stands. */
static MODEL(status) slave_evaluate(const MODEL(t) * model, const double *given, double *values) {
  enum { nq = MODEL(coordinate_count), nu = MODEL(rate_count) };
  double y[SLAVE_ROOM(nq + nu)], slope[SLAVE_ROOM(nq + nu)];
  MODEL(outputs) outputs;
  values[at_time] = model->t;
  for (int i = at_parameters; i < at_coordinates; ++i) values[i] = given[i];
  for (int i = 0; i < nq; ++i) y[i] = values[at_coordinates + i] = model->q[i];
  for (int i = 0; i < nu; ++i) y[nq + i] = values[at_rates + i] = model->u[i];
  MODEL(status) status = MODEL(rhs)(model, model->t, y, slope);
  if (status == MODEL_CODE(OK)) status = MODEL(get_outputs)(model, &outputs);
  if (status != MODEL_CODE(OK)) return status;
  for (int i = 0; i < at_accelerations - at_slopes; ++i) values[at_slopes + i] = slope[i];
  for (int i = 0; i < nu; ++i) values[at_accelerations + i] = slope[nq + i];
  for (int i = 0; i < at_energies - at_poses; ++i) values[at_poses + i] = outputs.pose[i / 12][i % 12];
  for (int i = 0; i < at_total - at_energies; ++i) values[at_energies + i] = outputs.energy[i];
  values[at_total] = outputs.total_energy;
  if (MODEL(cut_count) > 0) values[slave_variable_count - 1] = outputs.closure;
  return MODEL_CODE(OK);
}

/* Brings values up to date. */
static slave_status slave_refresh(slave *self) {
  const slave_status status = slave_prepare(self);
  if (status != SLAVE_OK || self->has_values) return status;
  const MODEL(status) came_to = slave_evaluate(&self->now.model, self->now.given, self->values);
  if (came_to != MODEL_CODE(OK)) {
    return slave_refuse(self, SLAVE_ERROR, "at %.17g s there are no outputs: %s", self->now.model.t,
                        MODEL(status_message)(came_to));
  }
  self->has_values = 1;
  return SLAVE_OK;
}

static slave_status slave_get(slave *self, const unsigned *references, size_t count, double *values) {
  const slave_record *now = &self->now;
  int is_start = now->phase == SLAVE_INSTANTIATED;
  if (count > 0 && (references == NULL || values == NULL)) {
    return slave_refuse(self, SLAVE_ERROR, "values are asked for, but a pointer is null");
  }
  for (size_t i = 0; i < count; ++i) {
    if (references[i] >= slave_variable_count) {
      return slave_refuse(self, SLAVE_ERROR, "no real variable has the reference %u; they are 0 to %d",
                          references[i], slave_variable_count - 1);
    }
    if (references[i] == at_time || references[i] >= at_slopes) is_start = 0;
  }
  if (is_start) { /* what was set is told, whether or not the model can start there */
    for (size_t i = 0; i < count; ++i) {
      const unsigned k = references[i];
      values[i] = k >= at_coordinates ? now->y[k - at_coordinates] : now->given[k];
    }
    return SLAVE_OK;
  }
  const slave_status status = slave_refresh(self);
  if (status != SLAVE_OK) return status;
  for (size_t i = 0; i < count; ++i) values[i] = self->values[references[i]];
  return SLAVE_OK;
}

#endif /* SLAVE_VALUES_H */
