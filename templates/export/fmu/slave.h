/* slave.h: an instance of the model for co-simulation, whatever the version of the standard.
 *
 * In:    values by reference, communication points, seeds of derivatives; model.h names the model.
 * Out:   values, derivatives, a status, and a sentence for the log where the status is not SLAVE_OK.
 * Never: allocates, prints, keeps anything outside its instance, knows a type of FMI.
 *
 * A call that is refused leaves the instance as it was. One that fails in the middle of a step leaves it at the last
 * good state. Everything is static, so that a program may link several such files.
 */
#ifndef SLAVE_H
#define SLAVE_H

#include "model.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define SLAVE_ROOM(count) ((count) > 0 ? (count) : 1) /* C has no empty arrays */

enum { slave_message_size = 400 };

typedef enum slave_status { /* numbers as those of FMI 2 and FMI 3 */
                            SLAVE_OK = 0,
                            SLAVE_DISCARD = 2, /* the step was not made to its end; shorter ones may be */
                            SLAVE_ERROR = 3
} slave_status;

typedef enum slave_phase {
  SLAVE_INSTANTIATED,
  SLAVE_INITIALISING,
  SLAVE_STEPPING,
  SLAVE_TERMINATED
} slave_phase;

/* References of the variables, kind by kind. */
enum {
  at_time = 0,
  at_parameters = 1,
  at_inputs = at_parameters + model_parameter_count,
  at_coordinates = at_inputs + model_input_count,
  at_rates = at_coordinates + MODEL(coordinate_count),
  at_slopes = at_rates + MODEL(rate_count), /* dq/dt, where that is not u */
  at_accelerations = at_slopes + (model_has_slopes ? MODEL(coordinate_count) : 0),
  at_poses = at_accelerations + MODEL(rate_count),
  at_energies = at_poses + 12 * MODEL(body_count),
  at_total = at_energies + MODEL(energy_count),
  at_gap = at_total + 1,
  slave_variable_count = at_gap + (MODEL(cut_count) > 0 ? 1 : 0),
  slave_state_size = MODEL(coordinate_count) + MODEL(rate_count)
};

/* Everything that a saved state holds: plain data without pointers. */
typedef struct slave_record {
  int phase;              /* slave_phase */
  int is_fresh;           /* 1: the model is yet to be put to its start */
  int is_placed;          /* 1: a start was set, in y */
  int has_new_parameters; /* 1: since the model was told last */
  int has_new_inputs;
  int is_driven;                            /* 1: an input was changed since the instance was new */
  double t_start;                           /* s */
  double t_stop;                            /* s, HUGE_VAL: none */
  double tolerance;                         /* relative; 0: the model's own */
  double y[SLAVE_ROOM(slave_state_size)];   /* the start: q, then u */
  double given[SLAVE_ROOM(at_coordinates)]; /* values of parameters and inputs, by reference */
  MODEL(t) model;
} slave_record;

typedef struct slave {
  slave_record now;
  MODEL(t) trial; /* room for a model that is moved a little */
  int has_values; /* 1: values are those of now */
  double values[slave_variable_count];
  double moved[2][slave_variable_count]; /* where a known is a little more and a little less */
  double sums[slave_variable_count];     /* derivatives of all variables */
  void (*say)(const struct slave *slave, slave_status status, const char *message);
} slave;

/* Tells why, and gives `status` back. */
static slave_status slave_refuse(const slave *self, slave_status status, const char *format, ...) {
  char message[slave_message_size];
  va_list arguments;
  va_start(arguments, format);
  (void)vsnprintf(message, sizeof message, format, arguments);
  va_end(arguments);
  self->say(self, status, message);
  return status;
}

/* ---- The model's structs by reference ------------------------------------------------------------------------ */

static void slave_write_parameters(const double *given, MODEL(parameters) * parameters) {
  MODEL(default_parameters)(parameters);
  for (int i = 0; i < model_parameter_count; ++i) {
    memcpy((char *)parameters + model_parameter_offset[i], &given[at_parameters + i], sizeof(double));
  }
}

static void slave_write_inputs(const double *given, MODEL(inputs) * inputs) {
  MODEL(default_inputs)(inputs);
  for (int i = 0; i < model_input_count; ++i) {
    memcpy((char *)inputs + model_input_offset[i], &given[at_inputs + i], sizeof(double));
  }
}

static void slave_read_defaults(double *given) {
  MODEL(parameters) parameters;
  MODEL(inputs) inputs;
  MODEL(default_parameters)(&parameters);
  MODEL(default_inputs)(&inputs);
  for (int i = 0; i < model_parameter_count; ++i) {
    memcpy(&given[at_parameters + i], (const char *)&parameters + model_parameter_offset[i], sizeof(double));
  }
  for (int i = 0; i < model_input_count; ++i) {
    memcpy(&given[at_inputs + i], (const char *)&inputs + model_input_offset[i], sizeof(double));
  }
}

/* ---- Life ---------------------------------------------------------------------------------------------------- */

/* A new instance, or one as new; `self` may hold anything but `say`. */
static slave_status slave_reset(slave *self) {
  slave_record *now = &self->now;
  memset(now, 0, sizeof *now);
  self->has_values = 0;
  now->phase = SLAVE_INSTANTIATED;
  now->is_fresh = 1;
  now->t_stop = HUGE_VAL;
  slave_read_defaults(now->given);
  const MODEL(status) status = MODEL(init)(&now->model, NULL, NULL);
  if (status != MODEL_CODE(OK)) {
    return slave_refuse(self, SLAVE_ERROR, "the model has no start: %s", MODEL(status_message)(status));
  }
  memcpy(now->y, now->model.q, MODEL(coordinate_count) * sizeof(double));
  memcpy(now->y + MODEL(coordinate_count), now->model.u, MODEL(rate_count) * sizeof(double));
  return SLAVE_OK;
}

static slave_status slave_in_phase(const slave *self, slave_phase phase, const char *call) {
  static const char *const told[] = {"before initialisation", "during initialisation", "while it steps",
                                     "after its end"};
  if (self->now.phase == (int)phase) return SLAVE_OK;
  return slave_refuse(self, SLAVE_ERROR, "%s is a call for an instance %s; this one is %s", call, told[phase],
                      told[self->now.phase]);
}

/* Span and tolerance of what follows. Infinite t_stop: none; tolerance 0: the model's own. */
static slave_status slave_experiment(slave *self, double t_start, double t_stop, double tolerance) {
  if (!isfinite(t_start) || !(t_stop >= t_start)) {
    return slave_refuse(self, SLAVE_ERROR,
                        "the run is from %.17g s to %.17g s; it must not end before its start", t_start,
                        t_stop);
  }
  if (tolerance != 0.0 && !(tolerance >= 1e-13 && tolerance <= 1.0)) {
    return slave_refuse(self, SLAVE_ERROR, "the tolerance is %.17g; it must be 1e-13 to 1", tolerance);
  }
  self->now.t_start = t_start;
  self->now.t_stop = t_stop;
  self->now.tolerance = tolerance;
  self->now.is_fresh = 1;
  self->has_values = 0;
  return SLAVE_OK;
}

static slave_status slave_enter_initialisation(slave *self, const char *call) {
  const slave_status status = slave_in_phase(self, SLAVE_INSTANTIATED, call);
  if (status == SLAVE_OK) self->now.phase = SLAVE_INITIALISING;
  return status;
}

/* Puts a model to its start, with what was given so far. */
static MODEL(status) slave_place(const slave_record *now, MODEL(t) * model) {
  MODEL(settings) settings;
  MODEL(parameters) parameters;
  MODEL(inputs) inputs;
  MODEL(default_settings)(&settings);
  if (now->tolerance > 0.0) {
    settings.atol *= now->tolerance / settings.rtol; /* in the same proportion */
    settings.rtol = now->tolerance;
  }
  settings.t_stop = now->t_stop;
  slave_write_parameters(now->given, &parameters);
  slave_write_inputs(now->given, &inputs);
  MODEL(status) status = MODEL(init)(model, &parameters, &settings);
  if (status == MODEL_CODE(OK) && now->is_driven) status = MODEL(set_inputs)(model, &inputs);
  if (status == MODEL_CODE(OK) && (now->is_placed || now->t_start != 0.0)) {
    status = MODEL(start)(model, now->t_start, now->y, now->y + MODEL(coordinate_count));
  }
  return status;
}

/* Tells the model what was set since it was told last. */
static slave_status slave_prepare(slave *self) {
  slave_record *now = &self->now;
  MODEL(status) status = MODEL_CODE(OK);
  const char *what = "start";
  if (!now->is_fresh && !now->has_new_parameters && !now->has_new_inputs) return SLAVE_OK;
  self->trial = now->model;
  if (now->is_fresh) {
    status = slave_place(now, &self->trial);
  } else {
    if (now->has_new_parameters) {
      MODEL(parameters) parameters;
      what = "parameters";
      slave_write_parameters(now->given, &parameters);
      status = MODEL(set_parameters)(&self->trial, &parameters);
    }
    if (status == MODEL_CODE(OK) && now->has_new_inputs) {
      MODEL(inputs) inputs;
      what = "inputs";
      slave_write_inputs(now->given, &inputs);
      status = MODEL(set_inputs)(&self->trial, &inputs);
    }
  }
  if (status != MODEL_CODE(OK)) {
    return slave_refuse(self, SLAVE_ERROR, "these %s cannot be had: %s", what, MODEL(status_message)(status));
  }
  now->model = self->trial;
  now->is_fresh = now->has_new_parameters = now->has_new_inputs = 0;
  self->has_values = 0;
  return SLAVE_OK;
}

static slave_status slave_exit_initialisation(slave *self, const char *call) {
  slave_status status = slave_in_phase(self, SLAVE_INITIALISING, call);
  if (status == SLAVE_OK) status = slave_prepare(self);
  if (status == SLAVE_OK) self->now.phase = SLAVE_STEPPING;
  return status;
}

static slave_status slave_terminate(slave *self, const char *call) {
  const slave_status status = slave_in_phase(self, SLAVE_STEPPING, call);
  if (status == SLAVE_OK) self->now.phase = SLAVE_TERMINATED;
  return status;
}

/* From `t`, where it has to stand, by `h` > 0, both s. */
static slave_status slave_step(slave *self, double t, double h, const char *call) {
  slave_record *now = &self->now;
  slave_status status = slave_in_phase(self, SLAVE_STEPPING, call);
  if (status != SLAVE_OK) return status;
  if (!isfinite(t) || !isfinite(h) || !(h > 0.0)) {
    return slave_refuse(self, SLAVE_ERROR, "a step of %.17g s from %.17g s; it must be finite and above zero",
                        h, t);
  }
  /* Times that a caller sums up differ from ours by round-off; a step's billionth is far above that, and too little
   * to hide a step that was left out or made twice. */
  const double slack = 1e-9 * h + 4.0 * DBL_EPSILON * (fabs(t) + h);
  if (fabs(t - now->model.t) > slack) {
    return slave_refuse(
        self, SLAVE_ERROR,
        "a step from %.17g s, but the instance stands at %.17g s; to go back, set a saved state", t,
        now->model.t);
  }
  double target = t + h;
  if (target > now->t_stop + slack) {
    return slave_refuse(self, SLAVE_ERROR, "a step to %.17g s, beyond the stop time %.17g s", target,
                        now->t_stop);
  }
  if (target > now->t_stop) target = now->t_stop;
  if (target < now->model.t) target = now->model.t;
  status = slave_prepare(self);
  if (status != SLAVE_OK) return status;
  self->has_values = 0;
  const MODEL(status) came_to = MODEL(step)(&now->model, target);
  if (came_to == MODEL_CODE(OK)) return SLAVE_OK;
  return slave_refuse(self, came_to == MODEL_CODE(STEP_LIMIT) ? SLAVE_DISCARD : SLAVE_ERROR,
                      "the step to %.17g s ended at %.17g s: %s", target, now->model.t,
                      MODEL(status_message)(came_to));
}

#endif /* SLAVE_H */
