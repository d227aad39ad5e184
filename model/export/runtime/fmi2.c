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
#define FMI(name) FMU_PASTED(FMI2_FUNCTION_PREFIX, fmi2##name)
#else
#define FMI(name) fmi2##name
#endif

typedef struct {
  fmu_cell *cell;
  const fmi2CallbackFunctions *callbacks;
  char *name;
  fmi2Boolean spent;  // the last step asked for more than the pack can give, which no shorter one gets past
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

typedef fmi2Status fmi_status;
typedef fmi2Boolean fmi_boolean;
typedef fmi2String fmi_string;
typedef fmi2ValueReference fmi_reference;
typedef fmi2Integer fmi_integer;
#define FMI_OK fmi2OK
#define FMI_DISCARD fmi2Discard
#define FMI_ERROR fmi2Error
#include "fmu_functions.h"

FMU_PUBLIC const char *FMI(GetTypesPlatform)(void) { return "default"; }

FMU_PUBLIC const char *FMI(GetVersion)(void) { return "2.0"; }

FMU_PUBLIC fmi2Component FMI(Instantiate)(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
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

FMU_PUBLIC void FMI(FreeInstance)(fmi2Component c) {
  instance *of = (instance *)c;
  if (of == NULL) return;
  fmu_free(of->cell);
  free(of->name);
  free(of);
}

FMU_PUBLIC fmi2Status FMI(SetupExperiment)(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                                           fmi2Real start_s, fmi2Boolean stop_defined, fmi2Real stop_s) {
  (void)tolerance_defined;
  (void)tolerance;
  (void)stop_defined;
  (void)stop_s;
  return set_time(c, start_s);
}

FMU_PUBLIC fmi2Status FMI(EnterInitializationMode)(fmi2Component c) { return enter(c, FMU_INITIALIZING); }

FMU_PUBLIC fmi2Status FMI(GetReal)(fmi2Component c, const fmi2ValueReference references[], size_t n, fmi2Real values[]) {
  return get_reals(c, references, n, values, "there is no real variable of this value reference");
}

FMU_PUBLIC fmi2Status FMI(SetReal)(fmi2Component c, const fmi2ValueReference references[], size_t n,
                                   const fmi2Real values[]) {
  return set_reals(c, references, n, values);
}

FMU_PUBLIC fmi2Status FMI(GetInteger)(fmi2Component c, const fmi2ValueReference references[], size_t n,
                                      fmi2Integer values[]) {
  return get_counts(c, references, n, values, "there is no integer variable of this value reference");
}

FMU_PUBLIC fmi2Status FMI(SetInteger)(fmi2Component c, const fmi2ValueReference references[], size_t n,
                                      const fmi2Integer values[]) {
  return set_counts(c, references, n, values);
}

// The types of which the cell has no variable.
#define FMU_NO_VARIABLES(name, type, none)                                                                           \
  FMU_PUBLIC fmi2Status FMI(name)(fmi2Component c, const fmi2ValueReference references[], size_t n, type values[]) { \
    (void)references;                                                                                                \
    (void)values;                                                                                                    \
    return n == 0 && c != NULL ? fmi2OK : missing(c, none);                                                          \
  }
FMU_NO_VARIABLES(GetBoolean, fmi2Boolean, "there are no boolean variables")
FMU_NO_VARIABLES(SetBoolean, const fmi2Boolean, "there are no boolean variables")
FMU_NO_VARIABLES(GetString, fmi2String, "there are no string variables")
FMU_NO_VARIABLES(SetString, const fmi2String, "there are no string variables")

FMU_PUBLIC fmi2Status FMI(GetFMUstate)(fmi2Component c, void **state) { return get_state(c, state); }

FMU_PUBLIC fmi2Status FMI(SetFMUstate)(fmi2Component c, void *state) { return set_state(c, state); }

FMU_PUBLIC fmi2Status FMI(FreeFMUstate)(fmi2Component c, void **state) { return free_state(c, state); }

FMU_PUBLIC fmi2Status FMI(SerializedFMUstateSize)(fmi2Component c, void *state, size_t *size) {
  return state_size(c, state, size);
}

FMU_PUBLIC fmi2Status FMI(SerializeFMUstate)(fmi2Component c, void *state, fmi2Byte bytes[], size_t size) {
  return serialize_state(c, state, bytes, size);
}

FMU_PUBLIC fmi2Status FMI(DeSerializeFMUstate)(fmi2Component c, const fmi2Byte bytes[], size_t size, void **state) {
  return deserialize_state(c, bytes, size, state);
}

FMU_PUBLIC fmi2Status FMI(GetDirectionalDerivative)(fmi2Component c, const fmi2ValueReference unknown[], size_t unknowns,
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
FMU_PUBLIC fmi2Status FMI(NewDiscreteStates)(fmi2Component c, fmi2EventInfo *info) {
  if (c == NULL || info == NULL) return fmi2Error;
  memset(info, 0, sizeof *info);
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI(GetDerivatives)(fmi2Component c, fmi2Real derivatives[], size_t n) {
  return get_derivatives(c, derivatives, n);
}

// Co-simulation.
FMU_PUBLIC fmi2Status FMI(SetRealInputDerivatives)(fmi2Component c, const fmi2ValueReference references[], size_t n,
                                                   const fmi2Integer order[], const fmi2Real values[]) {
  (void)references;
  (void)n;
  (void)order;
  (void)values;
  return missing(c, "inputs are held over a step: their derivatives are not taken");
}

FMU_PUBLIC fmi2Status FMI(GetRealOutputDerivatives)(fmi2Component c, const fmi2ValueReference references[], size_t n,
                                                    const fmi2Integer order[], fmi2Real values[]) {
  (void)references;
  (void)n;
  (void)order;
  (void)values;
  return missing(c, "derivatives of outputs are not offered");
}

FMU_PUBLIC fmi2Status FMI(DoStep)(fmi2Component c, fmi2Real now_s, fmi2Real step_s, fmi2Boolean no_set_state) {
  const fmi2Status status = take_step(c, now_s, step_s);
  (void)no_set_state;
  if (c != NULL) ((instance *)c)->spent = status == fmi2Discard;
  return status;
}

FMU_PUBLIC fmi2Status FMI(CancelStep)(fmi2Component c) { return missing(c, "steps are never pending"); }

FMU_PUBLIC fmi2Status FMI(GetStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
  (void)kind;
  (void)value;
  return trouble(c, fmi2Discard, "steps are never pending");
}

FMU_PUBLIC fmi2Status FMI(GetRealStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || value == NULL) return fmi2Error;
  if (kind != fmi2LastSuccessfulTime) return trouble(c, fmi2Discard, "this status is not offered");
  *value = cell->saved[FMU_SAVED_TIME];
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI(GetIntegerStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
  (void)kind;
  (void)value;
  return trouble(c, fmi2Discard, "this status is not offered");
}

FMU_PUBLIC fmi2Status FMI(GetBooleanStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
  if (c == NULL || value == NULL) return fmi2Error;
  if (kind != fmi2Terminated) return trouble(c, fmi2Discard, "this status is not offered");
  *value = ((const instance *)c)->spent;
  return fmi2OK;
}

FMU_PUBLIC fmi2Status FMI(GetStringStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
  (void)kind;
  (void)value;
  return trouble(c, fmi2Discard, "this status is not offered");
}
