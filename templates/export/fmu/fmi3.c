/* fmi3.c: the functions of FMI 3.0 for co-simulation, over slave.h.
 *
 * In: calls of an importer. Out: what the standard says. Never: keeps anything outside its instance.
 * Memory comes from calloc, and from nowhere else in the FMU. There is no event mode, no early return and no clock.
 * Only refusals and failures are logged, whether or not debug logging is on: there is no debug logging.
 */
#include "slave.h"
#include "slave_derivative.h"
#include "slave_state.h"
#include "slave_values.h"

#include "fmi3Functions.h"

#include <stdlib.h>

typedef struct instance {
  slave core; /* first, so that a pointer to it is one to the instance */
  fmi3InstanceEnvironment environment;
  fmi3LogMessageCallback log;
} instance;

static void log_to(fmi3LogMessageCallback log, fmi3InstanceEnvironment environment, fmi3Status status,
                   const char *message) {
  if (log == NULL) return;
  log(environment, status, status == fmi3Discard ? "logStatusDiscard" : "logStatusError", message);
}

static void say(const slave *self, slave_status status, const char *message) {
  const instance *its = (const instance *)(const void *)self;
  log_to(its->log, its->environment, (fmi3Status)status, message);
}

/* The slave of an instance; NULL for none. */
static slave *slave_of(fmi3Instance c) {
  return c == NULL ? NULL : &((instance *)c)->core;
}

static fmi3Status refuse(fmi3Instance c, const char *call, const char *why) {
  slave *self = slave_of(c);
  if (self == NULL) return fmi3Error;
  return (fmi3Status)slave_refuse(self, SLAVE_ERROR, "%s: %s", call, why);
}

#include "fmi3_absent.h"

/* ---- Inquiries ----------------------------------------------------------------------------------------------- */

const char *fmi3GetVersion(void) {
  return fmi3Version;
}

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[]) {
  (void)loggingOn;
  if (c == NULL) return fmi3Error;
  for (size_t i = 0; i < nCategories; ++i) {
    if (categories == NULL || categories[i] == NULL ||
        (strcmp(categories[i], "logStatusError") != 0 && strcmp(categories[i], "logStatusDiscard") != 0)) {
      return refuse(c, "fmi3SetDebugLogging", "the categories are logStatusError and logStatusDiscard");
    }
  }
  return fmi3OK;
}

/* ---- Life ---------------------------------------------------------------------------------------------------- */

/* What speaks against an instance; NULL: nothing. */
static const char *objection(fmi3String instanceName, fmi3String instantiationToken,
                             fmi3Boolean eventModeUsed) {
  if (instanceName == NULL || instanceName[0] == '\0') return "an instance must have a name";
  if (instantiationToken == NULL || strcmp(instantiationToken, MODEL_TOKEN) != 0) {
    return "the token is not " MODEL_TOKEN ": binary and modelDescription.xml are of different FMUs";
  }
  if (eventModeUsed) return "this FMU has no event mode; events are handled within steps";
  return NULL;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken,
                                         fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                         fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference requiredIntermediateVariables[],
                                         size_t nRequiredIntermediateVariables,
                                         fmi3InstanceEnvironment instanceEnvironment,
                                         fmi3LogMessageCallback logMessage,
                                         fmi3IntermediateUpdateCallback intermediateUpdate) {
  const char *against = objection(instanceName, instantiationToken, eventModeUsed);
  (void)resourcePath;
  (void)visible;
  (void)loggingOn;
  (void)earlyReturnAllowed;
  (void)requiredIntermediateVariables;
  (void)nRequiredIntermediateVariables;
  (void)intermediateUpdate;
  if (against != NULL) {
    log_to(logMessage, instanceEnvironment, fmi3Error, against);
    return NULL;
  }
  instance *its = (instance *)calloc(1, sizeof(instance));
  if (its == NULL) {
    log_to(logMessage, instanceEnvironment, fmi3Error, "there is no memory for an instance");
    return NULL;
  }
  its->environment = instanceEnvironment;
  its->log = logMessage;
  its->core.say = say;
  if (slave_reset(&its->core) != SLAVE_OK) {
    free(its);
    return NULL;
  }
  return its;
}

void fmi3FreeInstance(fmi3Instance c) {
  free(c);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 startTime, fmi3Boolean stopTimeDefined,
                                       fmi3Float64 stopTime) {
  slave *self = slave_of(c);
  if (self == NULL) return fmi3Error;
  slave_status status = slave_in_phase(self, SLAVE_INSTANTIATED, "fmi3EnterInitializationMode");
  if (status == SLAVE_OK) {
    status = slave_experiment(self, startTime, stopTimeDefined ? stopTime : HUGE_VAL,
                              toleranceDefined ? tolerance : 0.0);
  }
  if (status == SLAVE_OK) status = slave_enter_initialisation(self, "fmi3EnterInitializationMode");
  return (fmi3Status)status;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
  slave *self = slave_of(c);
  return self == NULL ? fmi3Error : (fmi3Status)slave_exit_initialisation(self, "fmi3ExitInitializationMode");
}

fmi3Status fmi3Terminate(fmi3Instance c) {
  slave *self = slave_of(c);
  return self == NULL ? fmi3Error : (fmi3Status)slave_terminate(self, "fmi3Terminate");
}

fmi3Status fmi3Reset(fmi3Instance c) {
  slave *self = slave_of(c);
  return self == NULL ? fmi3Error : (fmi3Status)slave_reset(self);
}

/* ---- Values -------------------------------------------------------------------------------------------------- */

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Float64 values[], size_t nValues) {
  slave *self = slave_of(c);
  if (self == NULL) return fmi3Error;
  if (nValues != nValueReferences) return refuse(c, "fmi3GetFloat64", not_scalar);
  return (fmi3Status)slave_get(self, valueReferences, nValueReferences, values);
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Float64 values[], size_t nValues) {
  slave *self = slave_of(c);
  if (self == NULL) return fmi3Error;
  if (nValues != nValueReferences) return refuse(c, "fmi3SetFloat64", not_scalar);
  return (fmi3Status)slave_set(self, valueReferences, nValueReferences, values);
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                        const fmi3ValueReference knowns[], size_t nKnowns,
                                        const fmi3Float64 seed[], size_t nSeed, fmi3Float64 sensitivity[],
                                        size_t nSensitivity) {
  slave *self = slave_of(c);
  if (self == NULL) return fmi3Error;
  if (nSeed != nKnowns || nSensitivity != nUnknowns) {
    return refuse(c, "fmi3GetDirectionalDerivative", not_scalar);
  }
  return (fmi3Status)slave_derivative(self, unknowns, nUnknowns, knowns, nKnowns, seed, sensitivity);
}

/* One derivative along each known: a row of the matrix at a time. */
fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                    const fmi3ValueReference knowns[], size_t nKnowns,
                                    const fmi3Float64 seed[], size_t nSeed, fmi3Float64 sensitivity[],
                                    size_t nSensitivity) {
  slave *self = slave_of(c);
  if (self == NULL) return fmi3Error;
  if (nSeed != nUnknowns || nSensitivity != nKnowns) {
    return refuse(c, "fmi3GetAdjointDerivative", not_scalar);
  }
  slave_status status =
      slave_check_derivative(self, unknowns, nUnknowns, knowns, nKnowns, seed, nSeed, sensitivity);
  if (status == SLAVE_OK) status = slave_refresh(self);
  for (size_t k = 0; k < nKnowns && status == SLAVE_OK; ++k) {
    const double one = 1.0;
    double sum = 0.0;
    status = slave_differentiate(self, &knowns[k], 1, &one);
    for (size_t i = 0; i < nUnknowns; ++i) sum += seed[i] * self->sums[unknowns[i]];
    if (status == SLAVE_OK) sensitivity[k] = sum;
  }
  return (fmi3Status)status;
}

/* ---- Saved states -------------------------------------------------------------------------------------------- */

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *FMUState) {
  slave *self = slave_of(c);
  if (self == NULL) return fmi3Error;
  if (FMUState == NULL) return refuse(c, "fmi3GetFMUState", "the pointer to the state is null");
  if (*FMUState == NULL) *FMUState = calloc(1, sizeof(slave_record));
  if (*FMUState == NULL) return refuse(c, "fmi3GetFMUState", "there is no memory for a state");
  *(slave_record *)*FMUState = self->now;
  return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState FMUState) {
  slave *self = slave_of(c);
  return self == NULL ? fmi3Error : (fmi3Status)slave_restore(self, (const slave_record *)FMUState);
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *FMUState) {
  if (c == NULL) return fmi3Error;
  if (FMUState == NULL) return fmi3OK;
  free(*FMUState);
  *FMUState = NULL;
  return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState FMUState, size_t *size) {
  if (c == NULL) return fmi3Error;
  if (FMUState == NULL || size == NULL) return refuse(c, "fmi3SerializedFMUStateSize", "a pointer is null");
  *size = sizeof(slave_bytes);
  return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState FMUState, fmi3Byte serializedState[],
                                 size_t size) {
  slave *self = slave_of(c);
  if (self == NULL) return fmi3Error;
  return (fmi3Status)slave_serialise(self, (const slave_record *)FMUState, serializedState, size);
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte serializedState[], size_t size,
                                   fmi3FMUState *FMUState) {
  slave *self = slave_of(c);
  if (self == NULL) return fmi3Error;
  if (FMUState == NULL) return refuse(c, "fmi3DeserializeFMUState", "the pointer to the state is null");
  const slave_status status = slave_check_bytes(self, serializedState, size);
  if (status != SLAVE_OK) return (fmi3Status)status;
  if (*FMUState == NULL) *FMUState = calloc(1, sizeof(slave_record));
  if (*FMUState == NULL) return refuse(c, "fmi3DeserializeFMUState", "there is no memory for a state");
  slave_deserialise(serializedState, (slave_record *)*FMUState);
  return fmi3OK;
}

/* ---- Co-simulation ------------------------------------------------------------------------------------------- */

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 currentCommunicationPoint,
                      fmi3Float64 communicationStepSize, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                      fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminateSimulation,
                      fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime) {
  slave *self = slave_of(c);
  (void)noSetFMUStatePriorToCurrentPoint;
  if (self == NULL) return fmi3Error;
  if (eventHandlingNeeded == NULL || terminateSimulation == NULL || earlyReturn == NULL ||
      lastSuccessfulTime == NULL) {
    return refuse(c, "fmi3DoStep", "a pointer to a result is null");
  }
  const slave_status status =
      slave_step(self, currentCommunicationPoint, communicationStepSize, "fmi3DoStep");
  *eventHandlingNeeded = fmi3False;
  *terminateSimulation = fmi3False;
  *earlyReturn = fmi3False;
  *lastSuccessfulTime = self->now.model.t;
  return (fmi3Status)status;
}
