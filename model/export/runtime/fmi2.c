// A cell as FMI 2.0 sees it: co-simulation and model exchange. C99; the prototypes are those of the standard.

#include "fmu_cell.h"

typedef void *fmi2Component;
typedef unsigned fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef const char *fmi2String;
typedef char fmi2Byte;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;
typedef struct {
  void (*logger)(void *, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
  void *(*allocateMemory)(size_t, size_t);
  void (*freeMemory)(void *);
  void (*stepFinished)(void *, fmi2Status);
  void *componentEnvironment;
} fmi2CallbackFunctions;
typedef struct {
  fmi2Boolean newDiscreteStatesNeeded;
  fmi2Boolean terminateSimulation;
  fmi2Boolean nominalsOfContinuousStatesChanged;
  fmi2Boolean valuesOfContinuousStatesChanged;
  fmi2Boolean nextEventTimeDefined;
  fmi2Real nextEventTime;
} fmi2EventInfo;

// A prefix for whoever links the sources of several FMUs into one program.
#ifdef FMI2_FUNCTION_PREFIX
#define FMU_PASTE(a, b) a##b
#define FMU_PASTED(a, b) FMU_PASTE(a, b)
#define FMI2(name) FMU_PASTED(FMI2_FUNCTION_PREFIX, fmi2##name)
#else
#define FMI2(name) fmi2##name
#endif

typedef struct {
  fmu_cell *cell;
  const fmi2CallbackFunctions *callbacks;
  char *name;
} instance;

static fmi2Status say(const fmi2CallbackFunctions *callbacks, const char *name, fmi2Status status, const char *message) {
  if (callbacks != NULL && callbacks->logger != NULL) {
    callbacks->logger(callbacks->componentEnvironment, name, status, status == fmi2Discard ? "logStatusDiscard" : "logStatusError",
                      "%s", message);
  }
  return status;
}

static fmi2Status trouble(fmi2Component c, fmi2Status status, const char *message) {
  const instance *of = (const instance *)c;
  return of == NULL ? fmi2Error : say(of->callbacks, of->name, status, message);
}

static fmi2Status missing(fmi2Component c, const char *what) { return trouble(c, fmi2Error, what); }

FMU_PUBLIC const char *FMI2(GetTypesPlatform)(void) { return "default"; }

FMU_PUBLIC const char *FMI2(GetVersion)(void) { return "2.0"; }

FMU_PUBLIC fmi2Status FMI2(SetDebugLogging)(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
  (void)on;
  (void)n;
  (void)categories;
  return c == NULL ? fmi2Error : fmi2OK;
}

FMU_PUBLIC fmi2Component FMI2(Instantiate)(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                           const fmi2CallbackFunctions *callbacks, fmi2Boolean visible,
                                           fmi2Boolean logging) {
  const char *why = "there is not enough memory";
  instance *of = (instance *)calloc(1, sizeof(instance));
  (void)type;
  (void)visible;
  (void)logging;
  if (name == NULL) name = "";
  if (of != NULL) {
    of->callbacks = callbacks;
    of->name = (char *)malloc(strlen(name) + 1);
    if (of->name != NULL) {
      memcpy(of->name, name, strlen(name) + 1);
      of->cell = fmu_new(guid, resources, &why);
      if (of->cell != NULL) return of;
    }
    free(of->name);
    free(of);
  }
  (void)say(callbacks, name, fmi2Error, why);
  return NULL;
}

FMU_PUBLIC void FMI2(FreeInstance)(fmi2Component c) {
  instance *of = (instance *)c;
  if (of == NULL) return;
  fmu_free(of->cell);
  free(of->name);
  free(of);
}

static fmu_cell *cell_in(fmi2Component c) { return c == NULL ? NULL : ((instance *)c)->cell; }

static fmi2Status enter(fmi2Component c, int phase) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL) return fmi2Error;
  cell->saved[FMU_SAVED_PHASE] = phase;
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(SetupExperiment)(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                                            fmi2Real start_s, fmi2Boolean stop_defined, fmi2Real stop_s) {
  fmu_cell *cell = cell_in(c);
  (void)tolerance_defined;
  (void)tolerance;
  (void)stop_defined;
  (void)stop_s;
  if (cell == NULL) return fmi2Error;
  cell->saved[FMU_SAVED_TIME] = start_s;
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(EnterInitializationMode)(fmi2Component c) { return enter(c, FMU_INITIALIZING); }

FMU_PUBLIC fmi2Status FMI2(ExitInitializationMode)(fmi2Component c) { return enter(c, FMU_RUNNING); }

FMU_PUBLIC fmi2Status FMI2(Terminate)(fmi2Component c) { return enter(c, FMU_TERMINATED); }

FMU_PUBLIC fmi2Status FMI2(Reset)(fmi2Component c) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL) return fmi2Error;
  fmu_reset(cell);
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(GetReal)(fmi2Component c, const fmi2ValueReference references[], size_t n, fmi2Real values[]) {
  fmu_cell *cell = cell_in(c);
  fmi2Status status = fmi2OK;
  size_t k;
  if (cell == NULL) return fmi2Error;
  for (k = 0; k < n; ++k) {
    const int found = fmu_get(cell, references[k], &values[k]);
    if (found == 0) return missing(c, "there is no real variable of this value reference");
    if (found == 2) status = fmi2Discard;
  }
  return status == fmi2OK ? status : trouble(c, status, "power_W is more than the pack can give");
}

FMU_PUBLIC fmi2Status FMI2(GetInteger)(fmi2Component c, const fmi2ValueReference references[], size_t n,
                                       fmi2Integer values[]) {
  fmu_cell *cell = cell_in(c);
  size_t k;
  if (cell == NULL) return fmi2Error;
  for (k = 0; k < n; ++k) {
    if (!fmu_get_count(cell, references[k], &values[k])) {
      return missing(c, "there is no integer variable of this value reference");
    }
  }
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(GetBoolean)(fmi2Component c, const fmi2ValueReference references[], size_t n,
                                       fmi2Boolean values[]) {
  (void)references;
  (void)values;
  return n == 0 && c != NULL ? fmi2OK : missing(c, "there are no boolean variables");
}

FMU_PUBLIC fmi2Status FMI2(GetString)(fmi2Component c, const fmi2ValueReference references[], size_t n,
                                      fmi2String values[]) {
  (void)references;
  (void)values;
  return n == 0 && c != NULL ? fmi2OK : missing(c, "there are no string variables");
}

FMU_PUBLIC fmi2Status FMI2(SetReal)(fmi2Component c, const fmi2ValueReference references[], size_t n,
                                    const fmi2Real values[]) {
  fmu_cell *cell = cell_in(c);
  size_t k;
  if (cell == NULL) return fmi2Error;
  for (k = 0; k < n; ++k) {
    if (!fmu_set(cell, references[k], values[k])) {
      return missing(c, "this variable cannot be set, not now, or not to this value");
    }
  }
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(SetInteger)(fmi2Component c, const fmi2ValueReference references[], size_t n,
                                       const fmi2Integer values[]) {
  fmu_cell *cell = cell_in(c);
  size_t k;
  if (cell == NULL) return fmi2Error;
  for (k = 0; k < n; ++k) {
    if (!fmu_set_count(cell, references[k], values[k])) {
      return missing(c, "series and parallel are at least 1 and are set before the initialization ends");
    }
  }
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(SetBoolean)(fmi2Component c, const fmi2ValueReference references[], size_t n,
                                       const fmi2Boolean values[]) {
  (void)references;
  (void)values;
  return n == 0 && c != NULL ? fmi2OK : missing(c, "there are no boolean variables");
}

FMU_PUBLIC fmi2Status FMI2(SetString)(fmi2Component c, const fmi2ValueReference references[], size_t n,
                                      const fmi2String values[]) {
  (void)references;
  (void)values;
  return n == 0 && c != NULL ? fmi2OK : missing(c, "there are no string variables");
}

// A saved state is a list of numbers, which is also what is serialized.
FMU_PUBLIC fmi2Status FMI2(GetFMUstate)(fmi2Component c, void **state) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || state == NULL) return fmi2Error;
  if (*state == NULL) *state = calloc(fmu_saved_numbers(cell), sizeof(double));
  if (*state == NULL) return missing(c, "there is not enough memory");
  fmu_save(cell, (double *)*state);
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(SetFMUstate)(fmi2Component c, void *state) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || state == NULL) return fmi2Error;
  fmu_restore(cell, (const double *)state);
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(FreeFMUstate)(fmi2Component c, void **state) {
  if (c == NULL) return fmi2Error;
  if (state == NULL) return fmi2OK;
  free(*state);
  *state = NULL;
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(SerializedFMUstateSize)(fmi2Component c, void *state, size_t *size) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || state == NULL || size == NULL) return fmi2Error;
  *size = fmu_saved_numbers(cell) * sizeof(double);
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(SerializeFMUstate)(fmi2Component c, void *state, fmi2Byte bytes[], size_t size) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || state == NULL || bytes == NULL) return fmi2Error;
  if (size != fmu_saved_numbers(cell) * sizeof(double)) return missing(c, "the buffer has another size than the state");
  memcpy(bytes, state, size);
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(DeSerializeFMUstate)(fmi2Component c, const fmi2Byte bytes[], size_t size, void **state) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || state == NULL || bytes == NULL) return fmi2Error;
  if (size != fmu_saved_numbers(cell) * sizeof(double)) return missing(c, "the buffer has another size than the state");
  if (*state == NULL) *state = malloc(size);
  if (*state == NULL) return missing(c, "there is not enough memory");
  memcpy(*state, bytes, size);
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(GetDirectionalDerivative)(fmi2Component c, const fmi2ValueReference unknown[], size_t unknowns,
                                                     const fmi2ValueReference known[], size_t knowns,
                                                     const fmi2Real seed[], fmi2Real sensitivity[]) {
  (void)unknown;
  (void)unknowns;
  (void)known;
  (void)knowns;
  (void)seed;
  (void)sensitivity;
  return missing(c, "directional derivatives are not offered");
}

// Model exchange.
FMU_PUBLIC fmi2Status FMI2(EnterEventMode)(fmi2Component c) { return c == NULL ? fmi2Error : fmi2OK; }

FMU_PUBLIC fmi2Status FMI2(NewDiscreteStates)(fmi2Component c, fmi2EventInfo *info) {
  if (c == NULL || info == NULL) return fmi2Error;
  memset(info, 0, sizeof *info);
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(EnterContinuousTimeMode)(fmi2Component c) { return c == NULL ? fmi2Error : fmi2OK; }

FMU_PUBLIC fmi2Status FMI2(CompletedIntegratorStep)(fmi2Component c, fmi2Boolean no_set_state, fmi2Boolean *enter_event,
                                                    fmi2Boolean *terminate) {
  (void)no_set_state;
  if (c == NULL || enter_event == NULL || terminate == NULL) return fmi2Error;
  *enter_event = 0;
  *terminate = 0;
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(SetTime)(fmi2Component c, fmi2Real time_s) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL) return fmi2Error;
  cell->saved[FMU_SAVED_TIME] = time_s;
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(SetContinuousStates)(fmi2Component c, const fmi2Real x[], size_t n) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || n != (size_t)cell->states) return missing(c, "another number of states than the cell has");
  memcpy(cell->x, x, n * sizeof(double));
  memset(cell->carry, 0, n * sizeof(double));
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(GetDerivatives)(fmi2Component c, fmi2Real derivatives[], size_t n) {
  fmu_cell *cell = cell_in(c);
  size_t k;
  if (cell == NULL || n != (size_t)cell->states) return missing(c, "another number of states than the cell has");
  for (k = 0; k < n; ++k) {
    if (fmu_get(cell, FMU_DERIVATIVE + (unsigned)k, &derivatives[k]) == 2) {
      return trouble(c, fmi2Discard, "power_W is more than the pack can give");
    }
  }
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(GetEventIndicators)(fmi2Component c, fmi2Real indicators[], size_t n) {
  (void)indicators;
  return n == 0 && c != NULL ? fmi2OK : missing(c, "there are no event indicators");
}

FMU_PUBLIC fmi2Status FMI2(GetContinuousStates)(fmi2Component c, fmi2Real x[], size_t n) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || n != (size_t)cell->states) return missing(c, "another number of states than the cell has");
  memcpy(x, cell->x, n * sizeof(double));
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(GetNominalsOfContinuousStates)(fmi2Component c, fmi2Real nominals[], size_t n) {
  fmu_cell *cell = cell_in(c);
  size_t k;
  if (cell == NULL || n != (size_t)cell->states) return missing(c, "another number of states than the cell has");
  for (k = 0; k < n; ++k) nominals[k] = fmu_nominal(cell, (int)k);
  return fmi2OK;
}

// Co-simulation.
FMU_PUBLIC fmi2Status FMI2(SetRealInputDerivatives)(fmi2Component c, const fmi2ValueReference references[], size_t n,
                                                    const fmi2Integer order[], const fmi2Real values[]) {
  (void)references;
  (void)n;
  (void)order;
  (void)values;
  return missing(c, "inputs are held over a step: their derivatives are not taken");
}

FMU_PUBLIC fmi2Status FMI2(GetRealOutputDerivatives)(fmi2Component c, const fmi2ValueReference references[], size_t n,
                                                     const fmi2Integer order[], fmi2Real values[]) {
  (void)references;
  (void)n;
  (void)order;
  (void)values;
  return missing(c, "derivatives of outputs are not offered");
}

FMU_PUBLIC fmi2Status FMI2(DoStep)(fmi2Component c, fmi2Real now_s, fmi2Real step_s, fmi2Boolean no_set_state) {
  fmu_cell *cell = cell_in(c);
  (void)no_set_state;
  if (cell == NULL) return fmi2Error;
  if (!(step_s >= 0.0) || !isfinite(step_s)) return missing(c, "a step has a positive length");
  cell->saved[FMU_SAVED_TIME] = now_s;
  if (!fmu_step(cell, step_s)) return trouble(c, fmi2Discard, "power_W is more than the pack can give");
  cell->saved[FMU_SAVED_TIME] = now_s + step_s;
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(CancelStep)(fmi2Component c) { return missing(c, "steps are never pending"); }

FMU_PUBLIC fmi2Status FMI2(GetStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
  (void)kind;
  (void)value;
  return trouble(c, fmi2Discard, "steps are never pending");
}

FMU_PUBLIC fmi2Status FMI2(GetRealStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || value == NULL) return fmi2Error;
  if (kind != fmi2LastSuccessfulTime) return trouble(c, fmi2Discard, "this status is not offered");
  *value = cell->saved[FMU_SAVED_TIME];
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(GetIntegerStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
  (void)kind;
  (void)value;
  return trouble(c, fmi2Discard, "this status is not offered");
}

FMU_PUBLIC fmi2Status FMI2(GetBooleanStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
  if (c == NULL || value == NULL) return fmi2Error;
  if (kind != fmi2Terminated) return trouble(c, fmi2Discard, "this status is not offered");
  *value = 0;
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI2(GetStringStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
  (void)kind;
  (void)value;
  return trouble(c, fmi2Discard, "this status is not offered");
}
