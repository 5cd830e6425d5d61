/* fmi2.c: the functions of FMI 2.0 for co-simulation, over slave.h.
 *
 * In: calls of an importer. Out: what the standard says. Never: keeps anything outside its instance.
 * Memory comes from the importer's callbacks. Functions of model exchange, asynchronous steps and input derivatives are
 * there and refuse, as the model description says. Only refusals and failures are logged, whether or not debug logging
 * is on: there is no debug logging.
 */
#include "slave.h"
#include "slave_derivative.h"
#include "slave_state.h"
#include "slave_values.h"

#include "fmi2Functions.h"

#include <stdlib.h>

typedef struct instance {
  slave core; /* first, so that a pointer to it is one to the instance */
  fmi2CallbackFunctions callbacks;
  char *name;
} instance;

/* The message is a format to the logger, and '#' in it begins a reference to a variable. */
static void log_to(const fmi2CallbackFunctions *callbacks, const char *name, fmi2Status status,
                   const char *message) {
  char text[2 * slave_message_size];
  size_t end = 0;
  if (callbacks->logger == NULL) return;
  for (const char *c = message; *c != '\0'; ++c) {
    if (*c == '%' || *c == '#') text[end++] = *c;
    text[end++] = *c;
  }
  text[end] = '\0';
  callbacks->logger(callbacks->componentEnvironment, name, status,
                    status == fmi2Discard ? "logStatusDiscard" : "logStatusError", text);
}

static void say(const slave *self, slave_status status, const char *message) {
  const instance *its = (const instance *)(const void *)self;
  log_to(&its->callbacks, its->name, (fmi2Status)status, message);
}

/* The slave of a component; NULL for none. */
static slave *slave_of(fmi2Component c) {
  return c == NULL ? NULL : &((instance *)c)->core;
}

static fmi2Status refuse(fmi2Component c, const char *call, const char *why) {
  slave *self = slave_of(c);
  if (self == NULL) return fmi2Error;
  return (fmi2Status)slave_refuse(self, SLAVE_ERROR, "%s: %s", call, why);
}

#include "fmi2_absent.h"

/* ---- Inquiries ----------------------------------------------------------------------------------------------- */

const char *fmi2GetTypesPlatform(void) {
  return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void) {
  return fmi2Version;
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[]) {
  (void)loggingOn;
  if (c == NULL) return fmi2Error;
  for (size_t i = 0; i < nCategories; ++i) {
    if (categories == NULL || categories[i] == NULL ||
        (strcmp(categories[i], "logStatusError") != 0 && strcmp(categories[i], "logStatusDiscard") != 0)) {
      return refuse(c, "fmi2SetDebugLogging", "the categories are logStatusError and logStatusDiscard");
    }
  }
  return fmi2OK;
}

/* ---- Life ---------------------------------------------------------------------------------------------------- */

static void *reserve(const fmi2CallbackFunctions *callbacks, size_t size) {
  return callbacks->allocateMemory != NULL ? callbacks->allocateMemory(1, size) : calloc(1, size);
}

static void release(const fmi2CallbackFunctions *callbacks, void *memory) {
  if (memory == NULL) return;
  if (callbacks->allocateMemory != NULL) {
    if (callbacks->freeMemory != NULL) callbacks->freeMemory(memory);
  } else {
    free(memory);
  }
}

/* What speaks against an instance; NULL: nothing. */
static const char *objection(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID) {
  if (instanceName == NULL || instanceName[0] == '\0') return "an instance must have a name";
  if (fmuType != fmi2CoSimulation) return "this FMU is one for co-simulation, not for model exchange";
  if (fmuGUID == NULL || strcmp(fmuGUID, MODEL_TOKEN) != 0) {
    return "the GUID is not " MODEL_TOKEN ": binary and modelDescription.xml are of different FMUs";
  }
  return NULL;
}

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn) {
  const char *against = objection(instanceName, fmuType, fmuGUID);
  (void)fmuResourceLocation;
  (void)visible;
  (void)loggingOn;
  if (functions == NULL) return NULL;
  if (against != NULL) {
    log_to(functions, instanceName != NULL ? instanceName : "", fmi2Error, against);
    return NULL;
  }
  const size_t length = strlen(instanceName) + 1;
  instance *its = (instance *)reserve(functions, sizeof(instance));
  char *name = (char *)reserve(functions, length);
  if (its == NULL || name == NULL) {
    log_to(functions, instanceName, fmi2Error, "there is no memory for an instance");
    release(functions, name);
    release(functions, its);
    return NULL;
  }
  memcpy(name, instanceName, length);
  its->callbacks = *functions;
  its->name = name;
  its->core.say = say;
  if (slave_reset(&its->core) != SLAVE_OK) {
    fmi2FreeInstance(its);
    return NULL;
  }
  return its;
}

void fmi2FreeInstance(fmi2Component c) {
  if (c == NULL) return;
  instance *its = (instance *)c;
  const fmi2CallbackFunctions callbacks = its->callbacks;
  release(&callbacks, its->name);
  release(&callbacks, its);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance,
                               fmi2Real startTime, fmi2Boolean stopTimeDefined, fmi2Real stopTime) {
  slave *self = slave_of(c);
  if (self == NULL) return fmi2Error;
  slave_status status = slave_in_phase(self, SLAVE_INSTANTIATED, "fmi2SetupExperiment");
  if (status == SLAVE_OK) {
    status = slave_experiment(self, startTime, stopTimeDefined ? stopTime : HUGE_VAL,
                              toleranceDefined ? tolerance : 0.0);
  }
  return (fmi2Status)status;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  slave *self = slave_of(c);
  return self == NULL ? fmi2Error
                      : (fmi2Status)slave_enter_initialisation(self, "fmi2EnterInitializationMode");
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  slave *self = slave_of(c);
  return self == NULL ? fmi2Error : (fmi2Status)slave_exit_initialisation(self, "fmi2ExitInitializationMode");
}

fmi2Status fmi2Terminate(fmi2Component c) {
  slave *self = slave_of(c);
  return self == NULL ? fmi2Error : (fmi2Status)slave_terminate(self, "fmi2Terminate");
}

fmi2Status fmi2Reset(fmi2Component c) {
  slave *self = slave_of(c);
  return self == NULL ? fmi2Error : (fmi2Status)slave_reset(self);
}

/* ---- Values -------------------------------------------------------------------------------------------------- */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[]) {
  slave *self = slave_of(c);
  return self == NULL ? fmi2Error : (fmi2Status)slave_get(self, vr, nvr, value);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[]) {
  slave *self = slave_of(c);
  return self == NULL ? fmi2Error : (fmi2Status)slave_set(self, vr, nvr, value);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown_ref[],
                                        size_t nUnknown, const fmi2ValueReference vKnown_ref[], size_t nKnown,
                                        const fmi2Real dvKnown[], fmi2Real dvUnknown[]) {
  slave *self = slave_of(c);
  if (self == NULL) return fmi2Error;
  return (fmi2Status)slave_derivative(self, vUnknown_ref, nUnknown, vKnown_ref, nKnown, dvKnown, dvUnknown);
}

/* ---- Saved states -------------------------------------------------------------------------------------------- */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
  instance *its = (instance *)c;
  if (its == NULL) return fmi2Error;
  if (FMUstate == NULL) return refuse(c, "fmi2GetFMUstate", "the pointer to the state is null");
  if (*FMUstate == NULL) *FMUstate = reserve(&its->callbacks, sizeof(slave_record));
  if (*FMUstate == NULL) return refuse(c, "fmi2GetFMUstate", "there is no memory for a state");
  *(slave_record *)*FMUstate = its->core.now;
  return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate) {
  slave *self = slave_of(c);
  return self == NULL ? fmi2Error : (fmi2Status)slave_restore(self, (const slave_record *)FMUstate);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
  instance *its = (instance *)c;
  if (its == NULL) return fmi2Error;
  if (FMUstate == NULL || *FMUstate == NULL) return fmi2OK;
  release(&its->callbacks, *FMUstate);
  *FMUstate = NULL;
  return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size) {
  if (c == NULL) return fmi2Error;
  if (FMUstate == NULL || size == NULL) return refuse(c, "fmi2SerializedFMUstateSize", "a pointer is null");
  *size = sizeof(slave_bytes);
  return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[],
                                 size_t size) {
  slave *self = slave_of(c);
  if (self == NULL) return fmi2Error;
  return (fmi2Status)slave_serialise(self, (const slave_record *)FMUstate, serializedState, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate *FMUstate) {
  instance *its = (instance *)c;
  if (its == NULL) return fmi2Error;
  if (FMUstate == NULL) return refuse(c, "fmi2DeSerializeFMUstate", "the pointer to the state is null");
  const slave_status status = slave_check_bytes(&its->core, serializedState, size);
  if (status != SLAVE_OK) return (fmi2Status)status;
  if (*FMUstate == NULL) *FMUstate = reserve(&its->callbacks, sizeof(slave_record));
  if (*FMUstate == NULL) return refuse(c, "fmi2DeSerializeFMUstate", "there is no memory for a state");
  slave_deserialise(serializedState, (slave_record *)*FMUstate);
  return fmi2OK;
}

/* ---- Co-simulation ------------------------------------------------------------------------------------------- */

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint) {
  slave *self = slave_of(c);
  (void)noSetFMUStatePriorToCurrentPoint;
  if (self == NULL) return fmi2Error;
  return (fmi2Status)slave_step(self, currentCommunicationPoint, communicationStepSize, "fmi2DoStep");
}

/* Steps are over when fmi2DoStep returns, so that only the time reached is ever to be asked for. */
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value) {
  slave *self = slave_of(c);
  if (self == NULL) return fmi2Error;
  if (value == NULL) return refuse(c, "fmi2GetRealStatus", "the pointer to the value is null");
  if (s != fmi2LastSuccessfulTime) {
    (void)refuse(c, "fmi2GetRealStatus", "the kind must be fmi2LastSuccessfulTime");
    return fmi2Discard;
  }
  *value = self->now.model.t;
  return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value) {
  if (c == NULL) return fmi2Error;
  if (value == NULL) return refuse(c, "fmi2GetBooleanStatus", "the pointer to the value is null");
  if (s != fmi2Terminated) {
    (void)refuse(c, "fmi2GetBooleanStatus", "the kind must be fmi2Terminated");
    return fmi2Discard;
  }
  *value = fmi2False; /* the FMU never ends a run by itself */
  return fmi2OK;
}
