/* fmi3_absent.h: what FMI 3.0 has and this FMU has not; a part of fmi3.c.
 *
 * In: calls of an importer. Out: the standard's refusal, and a sentence for the log.
 */
static const char not_scalar[] = "all variables are scalars, so that there is one value for each reference";

/* ---- Values of other types ----------------------------------------------------------------------------------- */

/* All variables are Float64; no values of another type is a call that asks for nothing. */
static fmi3Status of_other_type(fmi3Instance c, size_t count, const char *call) {
  if (c != NULL && count == 0) return fmi3OK;
  return refuse(c, call, "all variables of this FMU are of type Float64");
}

#define OTHER_TYPE(Type)                                                                                     \
  fmi3Status fmi3Get##Type(fmi3Instance c, const fmi3ValueReference valueReferences[],                       \
                           size_t nValueReferences, fmi3##Type values[], size_t nValues) {                   \
    (void)valueReferences;                                                                                   \
    (void)values;                                                                                            \
    (void)nValues;                                                                                           \
    return of_other_type(c, nValueReferences, "fmi3Get" #Type);                                              \
  }                                                                                                          \
  fmi3Status fmi3Set##Type(fmi3Instance c, const fmi3ValueReference valueReferences[],                       \
                           size_t nValueReferences, const fmi3##Type values[], size_t nValues) {             \
    (void)valueReferences;                                                                                   \
    (void)values;                                                                                            \
    (void)nValues;                                                                                           \
    return of_other_type(c, nValueReferences, "fmi3Set" #Type);                                              \
  }

OTHER_TYPE(Float32)
OTHER_TYPE(Int8)
OTHER_TYPE(UInt8)
OTHER_TYPE(Int16)
OTHER_TYPE(UInt16)
OTHER_TYPE(Int32)
OTHER_TYPE(UInt32)
OTHER_TYPE(Int64)
OTHER_TYPE(UInt64)
OTHER_TYPE(Boolean)
OTHER_TYPE(String)

fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         size_t valueSizes[], fmi3Binary values[], size_t nValues) {
  (void)valueReferences;
  (void)valueSizes;
  (void)values;
  (void)nValues;
  return of_other_type(c, nValueReferences, "fmi3GetBinary");
}

fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         const size_t valueSizes[], const fmi3Binary values[], size_t nValues) {
  (void)valueReferences;
  (void)valueSizes;
  (void)values;
  (void)nValues;
  return of_other_type(c, nValueReferences, "fmi3SetBinary");
}

fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Clock values[]) {
  (void)valueReferences;
  (void)values;
  return of_other_type(c, nValueReferences, "fmi3GetClock");
}

fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Clock values[]) {
  (void)valueReferences;
  (void)values;
  return of_other_type(c, nValueReferences, "fmi3SetClock");
}

/* ---- Other kinds of FMU -------------------------------------------------------------------------------------- */

static const char other_kind[] = "this FMU is one for co-simulation, and for nothing else";

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage) {
  (void)instanceName;
  (void)instantiationToken;
  (void)resourcePath;
  (void)visible;
  (void)loggingOn;
  log_to(logMessage, instanceEnvironment, fmi3Error, other_kind);
  return NULL;
}

fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath, fmi3Boolean visible,
    fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
    fmi3ClockUpdateCallback clockUpdate, fmi3LockPreemptionCallback lockPreemption,
    fmi3UnlockPreemptionCallback unlockPreemption) {
  (void)instanceName;
  (void)instantiationToken;
  (void)resourcePath;
  (void)visible;
  (void)loggingOn;
  (void)clockUpdate;
  (void)lockPreemption;
  (void)unlockPreemption;
  log_to(logMessage, instanceEnvironment, fmi3Error, other_kind);
  return NULL;
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference clockReference,
                                      fmi3Float64 activationTime) {
  (void)clockReference;
  (void)activationTime;
  return refuse(c, "fmi3ActivateModelPartition", other_kind);
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) {
  return refuse(c, "fmi3EnterContinuousTimeMode", other_kind);
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi3Boolean *enterEventMode, fmi3Boolean *terminateSimulation) {
  (void)noSetFMUStatePriorToCurrentPoint;
  (void)enterEventMode;
  (void)terminateSimulation;
  return refuse(c, "fmi3CompletedIntegratorStep", other_kind);
}

fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 time) {
  (void)time;
  return refuse(c, "fmi3SetTime", other_kind);
}

fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 continuousStates[],
                                   size_t nContinuousStates) {
  (void)continuousStates;
  (void)nContinuousStates;
  return refuse(c, "fmi3SetContinuousStates", other_kind);
}

#define OF_STATES(Name)                                                                                      \
  fmi3Status Name(fmi3Instance c, fmi3Float64 values[], size_t nValues) {                                    \
    (void)values;                                                                                            \
    (void)nValues;                                                                                           \
    return refuse(c, "ContinuousStates", other_kind);                                                        \
  }

OF_STATES(fmi3GetContinuousStateDerivatives)
OF_STATES(fmi3GetEventIndicators)
OF_STATES(fmi3GetContinuousStates)
OF_STATES(fmi3GetNominalsOfContinuousStates)

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *nEventIndicators) {
  (void)nEventIndicators;
  return refuse(c, "fmi3GetNumberOfEventIndicators", other_kind);
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *nContinuousStates) {
  (void)nContinuousStates;
  return refuse(c, "fmi3GetNumberOfContinuousStates", other_kind);
}

/* ---- Modes, clocks, dependencies and derivatives by time ------------------------------------------------------ */

static const char no_events[] = "this FMU has no event mode and no clocks; events are handled within steps";

fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) {
  return refuse(c, "fmi3EnterConfigurationMode", "this FMU has no structural parameters");
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) {
  return refuse(c, "fmi3ExitConfigurationMode", "this FMU has no structural parameters");
}

fmi3Status fmi3EnterEventMode(fmi3Instance c) {
  return refuse(c, "fmi3EnterEventMode", no_events);
}

fmi3Status fmi3EnterStepMode(fmi3Instance c) {
  return refuse(c, "fmi3EnterStepMode", no_events);
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c) {
  return refuse(c, "fmi3EvaluateDiscreteStates", no_events);
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation,
                                    fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged,
                                    fmi3Boolean *nextEventTimeDefined, fmi3Float64 *nextEventTime) {
  (void)discreteStatesNeedUpdate;
  (void)terminateSimulation;
  (void)nominalsOfContinuousStatesChanged;
  (void)valuesOfContinuousStatesChanged;
  (void)nextEventTimeDefined;
  (void)nextEventTime;
  return refuse(c, "fmi3UpdateDiscreteStates", no_events);
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                  size_t nValueReferences, fmi3Float64 intervals[],
                                  fmi3IntervalQualifier qualifiers[]) {
  (void)valueReferences;
  (void)nValueReferences;
  (void)intervals;
  (void)qualifiers;
  return refuse(c, "fmi3GetIntervalDecimal", no_events);
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                   size_t nValueReferences, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
                                   fmi3IntervalQualifier qualifiers[]) {
  (void)valueReferences;
  (void)nValueReferences;
  (void)counters;
  (void)resolutions;
  (void)qualifiers;
  return refuse(c, "fmi3GetIntervalFraction", no_events);
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance c, const fmi3ValueReference valueReferences[],
                               size_t nValueReferences, fmi3Float64 shifts[]) {
  (void)valueReferences;
  (void)nValueReferences;
  (void)shifts;
  return refuse(c, "fmi3GetShiftDecimal", no_events);
}

fmi3Status fmi3GetShiftFraction(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                size_t nValueReferences, fmi3UInt64 counters[], fmi3UInt64 resolutions[]) {
  (void)valueReferences;
  (void)nValueReferences;
  (void)counters;
  (void)resolutions;
  return refuse(c, "fmi3GetShiftFraction", no_events);
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                  size_t nValueReferences, const fmi3Float64 intervals[]) {
  (void)valueReferences;
  (void)nValueReferences;
  (void)intervals;
  return refuse(c, "fmi3SetIntervalDecimal", no_events);
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                   size_t nValueReferences, const fmi3UInt64 counters[],
                                   const fmi3UInt64 resolutions[]) {
  (void)valueReferences;
  (void)nValueReferences;
  (void)counters;
  (void)resolutions;
  return refuse(c, "fmi3SetIntervalFraction", no_events);
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance c, const fmi3ValueReference valueReferences[],
                               size_t nValueReferences, const fmi3Float64 shifts[]) {
  (void)valueReferences;
  (void)nValueReferences;
  (void)shifts;
  return refuse(c, "fmi3SetShiftDecimal", no_events);
}

fmi3Status fmi3SetShiftFraction(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                size_t nValueReferences, const fmi3UInt64 counters[],
                                const fmi3UInt64 resolutions[]) {
  (void)valueReferences;
  (void)nValueReferences;
  (void)counters;
  (void)resolutions;
  return refuse(c, "fmi3SetShiftFraction", no_events);
}

static const char in_description[] = "dependencies are told by modelDescription.xml";

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference valueReference,
                                               size_t *nDependencies) {
  (void)valueReference;
  (void)nDependencies;
  return refuse(c, "fmi3GetNumberOfVariableDependencies", in_description);
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference dependent,
                                       size_t elementIndicesOfDependent[], fmi3ValueReference independents[],
                                       size_t elementIndicesOfIndependents[],
                                       fmi3DependencyKind dependencyKinds[], size_t nDependencies) {
  (void)dependent;
  (void)elementIndicesOfDependent;
  (void)independents;
  (void)elementIndicesOfIndependents;
  (void)dependencyKinds;
  (void)nDependencies;
  return refuse(c, "fmi3GetVariableDependencies", in_description);
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                    size_t nValueReferences, const fmi3Int32 orders[], fmi3Float64 values[],
                                    size_t nValues) {
  (void)valueReferences;
  (void)nValueReferences;
  (void)orders;
  (void)values;
  (void)nValues;
  return refuse(c, "fmi3GetOutputDerivatives", "derivatives by time are outputs of their own, der(...)");
}
