// A cell as FMI 3.0 sees it: co-simulation and model exchange. C99; the prototypes are those of the standard.

#include <stdbool.h>

#include "fmu_cell.h"

typedef void *fmi3Instance;
typedef void *fmi3InstanceEnvironment;
typedef void *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef double fmi3Float64;
typedef bool fmi3Boolean;
typedef const char *fmi3String;
typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment, fmi3Float64, fmi3Boolean, fmi3Boolean,
                                               fmi3Boolean, fmi3Boolean, fmi3Boolean *, fmi3Float64 *);
typedef void (*fmi3Plain)(void);

// A prefix for whoever links the sources of several FMUs into one program.
#ifdef FMI3_FUNCTION_PREFIX
#define FMU_PASTE(a, b) a##b
#define FMU_PASTED(a, b) FMU_PASTE(a, b)
#define FMI3(name) FMU_PASTED(FMI3_FUNCTION_PREFIX, fmi3##name)
#else
#define FMI3(name) fmi3##name
#endif

typedef struct {
  fmu_cell *cell;
  fmi3LogMessageCallback log;
  fmi3InstanceEnvironment environment;
} instance;

static fmi3Status trouble(fmi3Instance c, fmi3Status status, const char *message) {
  const instance *of = (const instance *)c;
  if (of != NULL && of->log != NULL) {
    of->log(of->environment, status, status == fmi3Discard ? "logStatusDiscard" : "logStatusError", message);
  }
  return of == NULL ? fmi3Error : status;
}

static fmi3Status missing(fmi3Instance c, const char *what) { return trouble(c, fmi3Error, what); }

static fmu_cell *cell_in(fmi3Instance c) { return c == NULL ? NULL : ((instance *)c)->cell; }

static fmi3Status enter(fmi3Instance c, int phase) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL) return fmi3Error;
  cell->saved[FMU_SAVED_PHASE] = phase;
  return fmi3OK;
}

static fmi3Instance instantiate(fmi3String token, fmi3String resources, fmi3InstanceEnvironment environment,
                                fmi3LogMessageCallback log) {
  const char *why = "there is not enough memory";
  instance *of = (instance *)calloc(1, sizeof(instance));
  if (of != NULL) {
    of->cell = fmu_new(token, resources, &why);
    of->log = log;
    of->environment = environment;
    if (of->cell != NULL) return of;
    free(of);
  }
  if (log != NULL) log(environment, fmi3Error, "logStatusError", why);
  return NULL;
}

FMU_PUBLIC const char *FMI3(GetVersion)(void) { return "3.0"; }

FMU_PUBLIC fmi3Status FMI3(SetDebugLogging)(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String categories[]) {
  (void)on;
  (void)n;
  (void)categories;
  return c == NULL ? fmi3Error : fmi3OK;
}

FMU_PUBLIC fmi3Instance FMI3(InstantiateModelExchange)(fmi3String name, fmi3String token, fmi3String resources,
                                                       fmi3Boolean visible, fmi3Boolean logging,
                                                       fmi3InstanceEnvironment environment,
                                                       fmi3LogMessageCallback log) {
  (void)name;
  (void)visible;
  (void)logging;
  return instantiate(token, resources, environment, log);
}

FMU_PUBLIC fmi3Instance FMI3(InstantiateCoSimulation)(fmi3String name, fmi3String token, fmi3String resources,
                                                      fmi3Boolean visible, fmi3Boolean logging,
                                                      fmi3Boolean event_mode, fmi3Boolean early_return,
                                                      const fmi3ValueReference required[], size_t n_required,
                                                      fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                                      fmi3IntermediateUpdateCallback update) {
  (void)name;
  (void)visible;
  (void)logging;
  (void)event_mode;
  (void)early_return;
  (void)required;
  (void)n_required;
  (void)update;
  return instantiate(token, resources, environment, log);
}

FMU_PUBLIC fmi3Instance FMI3(InstantiateScheduledExecution)(fmi3String name, fmi3String token, fmi3String resources,
                                                            fmi3Boolean visible, fmi3Boolean logging,
                                                            fmi3InstanceEnvironment environment,
                                                            fmi3LogMessageCallback log, fmi3Plain clock_update,
                                                            fmi3Plain lock, fmi3Plain unlock) {
  (void)name;
  (void)token;
  (void)resources;
  (void)visible;
  (void)logging;
  (void)clock_update;
  (void)lock;
  (void)unlock;
  if (log != NULL) log(environment, fmi3Error, "logStatusError", "scheduled execution is not offered");
  return NULL;
}

FMU_PUBLIC void FMI3(FreeInstance)(fmi3Instance c) {
  instance *of = (instance *)c;
  if (of == NULL) return;
  fmu_free(of->cell);
  free(of);
}

FMU_PUBLIC fmi3Status FMI3(EnterInitializationMode)(fmi3Instance c, fmi3Boolean tolerance_defined,
                                                    fmi3Float64 tolerance, fmi3Float64 start_s,
                                                    fmi3Boolean stop_defined, fmi3Float64 stop_s) {
  fmu_cell *cell = cell_in(c);
  (void)tolerance_defined;
  (void)tolerance;
  (void)stop_defined;
  (void)stop_s;
  if (cell == NULL) return fmi3Error;
  cell->saved[FMU_SAVED_TIME] = start_s;
  return enter(c, FMU_INITIALIZING);
}

FMU_PUBLIC fmi3Status FMI3(ExitInitializationMode)(fmi3Instance c) { return enter(c, FMU_RUNNING); }

FMU_PUBLIC fmi3Status FMI3(EnterEventMode)(fmi3Instance c) { return c == NULL ? fmi3Error : fmi3OK; }

FMU_PUBLIC fmi3Status FMI3(Terminate)(fmi3Instance c) { return enter(c, FMU_TERMINATED); }

FMU_PUBLIC fmi3Status FMI3(Reset)(fmi3Instance c) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL) return fmi3Error;
  fmu_reset(cell);
  return fmi3OK;
}

FMU_PUBLIC fmi3Status FMI3(GetFloat64)(fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                       fmi3Float64 values[], size_t n_values) {
  fmu_cell *cell = cell_in(c);
  fmi3Status status = fmi3OK;
  size_t k;
  if (cell == NULL || n != n_values) return missing(c, "as many values as value references");
  for (k = 0; k < n; ++k) {
    const int found = fmu_get(cell, references[k], &values[k]);
    if (found == 0) return missing(c, "there is no Float64 variable of this value reference");
    if (found == 2) status = fmi3Discard;
  }
  return status == fmi3OK ? status : trouble(c, status, "power_W is more than the pack can give");
}

FMU_PUBLIC fmi3Status FMI3(SetFloat64)(fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                       const fmi3Float64 values[], size_t n_values) {
  fmu_cell *cell = cell_in(c);
  size_t k;
  if (cell == NULL || n != n_values) return missing(c, "as many values as value references");
  for (k = 0; k < n; ++k) {
    if (!fmu_set(cell, references[k], values[k])) {
      return missing(c, "this variable cannot be set, not now, or not to this value");
    }
  }
  return fmi3OK;
}

FMU_PUBLIC fmi3Status FMI3(GetInt32)(fmi3Instance c, const fmi3ValueReference references[], size_t n, int32_t values[],
                                     size_t n_values) {
  fmu_cell *cell = cell_in(c);
  size_t k;
  if (cell == NULL || n != n_values) return missing(c, "as many values as value references");
  for (k = 0; k < n; ++k) {
    int value;
    if (!fmu_get_count(cell, references[k], &value)) {
      return missing(c, "there is no Int32 variable of this value reference");
    }
    values[k] = value;
  }
  return fmi3OK;
}

FMU_PUBLIC fmi3Status FMI3(SetInt32)(fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                     const int32_t values[], size_t n_values) {
  fmu_cell *cell = cell_in(c);
  size_t k;
  if (cell == NULL || n != n_values) return missing(c, "as many values as value references");
  for (k = 0; k < n; ++k) {
    if (!fmu_set_count(cell, references[k], values[k])) {
      return missing(c, "series and parallel are at least 1 and are set before the initialization ends");
    }
  }
  return fmi3OK;
}

// The types of which the cell has no variable.
#define FMU_NO_VARIABLES(name, type)                                                                              \
  FMU_PUBLIC fmi3Status FMI3(Get##name)(fmi3Instance c, const fmi3ValueReference references[], size_t n,          \
                                        type values[], size_t n_values) {                                         \
    (void)references;                                                                                             \
    (void)values;                                                                                                 \
    (void)n_values;                                                                                               \
    return n == 0 && c != NULL ? fmi3OK : missing(c, "there are no variables of this type");                      \
  }                                                                                                               \
  FMU_PUBLIC fmi3Status FMI3(Set##name)(fmi3Instance c, const fmi3ValueReference references[], size_t n,          \
                                        const type values[], size_t n_values) {                                   \
    (void)references;                                                                                             \
    (void)values;                                                                                                 \
    (void)n_values;                                                                                               \
    return n == 0 && c != NULL ? fmi3OK : missing(c, "there are no variables of this type");                      \
  }
FMU_NO_VARIABLES(Float32, float)
FMU_NO_VARIABLES(Int8, int8_t)
FMU_NO_VARIABLES(UInt8, uint8_t)
FMU_NO_VARIABLES(Int16, int16_t)
FMU_NO_VARIABLES(UInt16, uint16_t)
FMU_NO_VARIABLES(UInt32, uint32_t)
FMU_NO_VARIABLES(Int64, int64_t)
FMU_NO_VARIABLES(UInt64, uint64_t)
FMU_NO_VARIABLES(Boolean, fmi3Boolean)
FMU_NO_VARIABLES(String, fmi3String)

typedef const uint8_t *fmi3Binary;

FMU_PUBLIC fmi3Status FMI3(GetBinary)(fmi3Instance c, const fmi3ValueReference references[], size_t n, size_t sizes[],
                                      fmi3Binary values[], size_t n_values) {
  (void)references;
  (void)sizes;
  (void)values;
  (void)n_values;
  return n == 0 && c != NULL ? fmi3OK : missing(c, "there are no variables of this type");
}

FMU_PUBLIC fmi3Status FMI3(SetBinary)(fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                      const size_t sizes[], const fmi3Binary values[], size_t n_values) {
  (void)references;
  (void)sizes;
  (void)values;
  (void)n_values;
  return n == 0 && c != NULL ? fmi3OK : missing(c, "there are no variables of this type");
}

// Clocks: there are none.
#define FMU_NO_CLOCK(name, parameters)                                        \
  FMU_PUBLIC fmi3Status FMI3(name) parameters {                               \
    (void)references;                                                         \
    (void)a;                                                                  \
    return n == 0 && c != NULL ? fmi3OK : missing(c, "there are no clocks");  \
  }
#define FMU_NO_CLOCK_OF_TWO(name, parameters)                                 \
  FMU_PUBLIC fmi3Status FMI3(name) parameters {                               \
    (void)references;                                                         \
    (void)a;                                                                  \
    (void)b;                                                                  \
    return n == 0 && c != NULL ? fmi3OK : missing(c, "there are no clocks");  \
  }
FMU_NO_CLOCK(GetClock, (fmi3Instance c, const fmi3ValueReference references[], size_t n, fmi3Boolean a[]))
FMU_NO_CLOCK(SetClock, (fmi3Instance c, const fmi3ValueReference references[], size_t n, const fmi3Boolean a[]))
FMU_NO_CLOCK_OF_TWO(GetIntervalDecimal,
                    (fmi3Instance c, const fmi3ValueReference references[], size_t n, double a[], int b[]))
FMU_PUBLIC fmi3Status FMI3(GetIntervalFraction)(fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                                uint64_t counters[], uint64_t resolutions[], int qualifiers[]) {
  (void)references;
  (void)counters;
  (void)resolutions;
  (void)qualifiers;
  return n == 0 && c != NULL ? fmi3OK : missing(c, "there are no clocks");
}
FMU_NO_CLOCK(GetShiftDecimal, (fmi3Instance c, const fmi3ValueReference references[], size_t n, double a[]))
FMU_NO_CLOCK_OF_TWO(GetShiftFraction,
                    (fmi3Instance c, const fmi3ValueReference references[], size_t n, uint64_t a[], uint64_t b[]))
FMU_NO_CLOCK(SetIntervalDecimal, (fmi3Instance c, const fmi3ValueReference references[], size_t n, const double a[]))
FMU_NO_CLOCK_OF_TWO(SetIntervalFraction, (fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                          const uint64_t a[], const uint64_t b[]))
FMU_NO_CLOCK(SetShiftDecimal, (fmi3Instance c, const fmi3ValueReference references[], size_t n, const double a[]))
FMU_NO_CLOCK_OF_TWO(SetShiftFraction, (fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                       const uint64_t a[], const uint64_t b[]))

FMU_PUBLIC fmi3Status FMI3(GetNumberOfVariableDependencies)(fmi3Instance c, fmi3ValueReference reference, size_t *n) {
  (void)reference;
  (void)n;
  return missing(c, "dependencies are those of modelDescription.xml");
}

FMU_PUBLIC fmi3Status FMI3(GetVariableDependencies)(fmi3Instance c, fmi3ValueReference dependent, size_t elements[],
                                                    fmi3ValueReference independents[], size_t independent_elements[],
                                                    int kinds[], size_t n) {
  (void)dependent;
  (void)elements;
  (void)independents;
  (void)independent_elements;
  (void)kinds;
  (void)n;
  return missing(c, "dependencies are those of modelDescription.xml");
}

// A saved state is a list of numbers, which is also what is serialized.
FMU_PUBLIC fmi3Status FMI3(GetFMUState)(fmi3Instance c, fmi3FMUState *state) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || state == NULL) return fmi3Error;
  if (*state == NULL) *state = calloc(fmu_saved_numbers(cell), sizeof(double));
  if (*state == NULL) return missing(c, "there is not enough memory");
  fmu_save(cell, (double *)*state);
  return fmi3OK;
}

FMU_PUBLIC fmi3Status FMI3(SetFMUState)(fmi3Instance c, fmi3FMUState state) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || state == NULL) return fmi3Error;
  fmu_restore(cell, (const double *)state);
  return fmi3OK;
}

FMU_PUBLIC fmi3Status FMI3(FreeFMUState)(fmi3Instance c, fmi3FMUState *state) {
  if (c == NULL) return fmi3Error;
  if (state == NULL) return fmi3OK;
  free(*state);
  *state = NULL;
  return fmi3OK;
}

FMU_PUBLIC fmi3Status FMI3(SerializedFMUStateSize)(fmi3Instance c, fmi3FMUState state, size_t *size) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || state == NULL || size == NULL) return fmi3Error;
  *size = fmu_saved_numbers(cell) * sizeof(double);
  return fmi3OK;
}

FMU_PUBLIC fmi3Status FMI3(SerializeFMUState)(fmi3Instance c, fmi3FMUState state, uint8_t bytes[], size_t size) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || state == NULL || bytes == NULL) return fmi3Error;
  if (size != fmu_saved_numbers(cell) * sizeof(double)) return missing(c, "the buffer has another size than the state");
  memcpy(bytes, state, size);
  return fmi3OK;
}

FMU_PUBLIC fmi3Status FMI3(DeserializeFMUState)(fmi3Instance c, const uint8_t bytes[], size_t size,
                                                fmi3FMUState *state) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || state == NULL || bytes == NULL) return fmi3Error;
  if (size != fmu_saved_numbers(cell) * sizeof(double)) return missing(c, "the buffer has another size than the state");
  if (*state == NULL) *state = malloc(size);
  if (*state == NULL) return missing(c, "there is not enough memory");
  memcpy(*state, bytes, size);
  return fmi3OK;
}

#define FMU_NO_DERIVATIVE(name)                                                                                      \
  FMU_PUBLIC fmi3Status FMI3(name)(fmi3Instance c, const fmi3ValueReference unknowns[], size_t n_unknowns,           \
                                   const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[],     \
                                   size_t n_seed, fmi3Float64 sensitivity[], size_t n_sensitivity) {                 \
    (void)unknowns;                                                                                                  \
    (void)n_unknowns;                                                                                                \
    (void)knowns;                                                                                                    \
    (void)n_knowns;                                                                                                  \
    (void)seed;                                                                                                      \
    (void)n_seed;                                                                                                    \
    (void)sensitivity;                                                                                               \
    (void)n_sensitivity;                                                                                             \
    return missing(c, "directional and adjoint derivatives are not offered");                                        \
  }
FMU_NO_DERIVATIVE(GetDirectionalDerivative)
FMU_NO_DERIVATIVE(GetAdjointDerivative)

FMU_PUBLIC fmi3Status FMI3(EnterConfigurationMode)(fmi3Instance c) { return c == NULL ? fmi3Error : fmi3OK; }

FMU_PUBLIC fmi3Status FMI3(ExitConfigurationMode)(fmi3Instance c) { return c == NULL ? fmi3Error : fmi3OK; }

FMU_PUBLIC fmi3Status FMI3(EvaluateDiscreteStates)(fmi3Instance c) { return c == NULL ? fmi3Error : fmi3OK; }

FMU_PUBLIC fmi3Status FMI3(UpdateDiscreteStates)(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *terminate,
                                                 fmi3Boolean *nominals_changed, fmi3Boolean *values_changed,
                                                 fmi3Boolean *next_event, fmi3Float64 *next_event_s) {
  if (c == NULL) return fmi3Error;
  if (again != NULL) *again = false;
  if (terminate != NULL) *terminate = false;
  if (nominals_changed != NULL) *nominals_changed = false;
  if (values_changed != NULL) *values_changed = false;
  if (next_event != NULL) *next_event = false;
  if (next_event_s != NULL) *next_event_s = 0.0;
  return fmi3OK;
}

// Model exchange.
FMU_PUBLIC fmi3Status FMI3(EnterContinuousTimeMode)(fmi3Instance c) { return c == NULL ? fmi3Error : fmi3OK; }

FMU_PUBLIC fmi3Status FMI3(CompletedIntegratorStep)(fmi3Instance c, fmi3Boolean no_set_state, fmi3Boolean *enter_event,
                                                    fmi3Boolean *terminate) {
  (void)no_set_state;
  if (c == NULL || enter_event == NULL || terminate == NULL) return fmi3Error;
  *enter_event = false;
  *terminate = false;
  return fmi3OK;
}

FMU_PUBLIC fmi3Status FMI3(SetTime)(fmi3Instance c, fmi3Float64 time_s) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL) return fmi3Error;
  cell->saved[FMU_SAVED_TIME] = time_s;
  return fmi3OK;
}

FMU_PUBLIC fmi3Status FMI3(SetContinuousStates)(fmi3Instance c, const fmi3Float64 x[], size_t n) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || n != (size_t)cell->states) return missing(c, "another number of states than the cell has");
  memcpy(cell->x, x, n * sizeof(double));
  memset(cell->carry, 0, n * sizeof(double));
  return fmi3OK;
}

FMU_PUBLIC fmi3Status FMI3(GetContinuousStateDerivatives)(fmi3Instance c, fmi3Float64 derivatives[], size_t n) {
  fmu_cell *cell = cell_in(c);
  size_t k;
  if (cell == NULL || n != (size_t)cell->states) return missing(c, "another number of states than the cell has");
  for (k = 0; k < n; ++k) {
    if (fmu_get(cell, FMU_DERIVATIVE + (unsigned)k, &derivatives[k]) == 2) {
      return trouble(c, fmi3Discard, "power_W is more than the pack can give");
    }
  }
  return fmi3OK;
}

FMU_PUBLIC fmi3Status FMI3(GetEventIndicators)(fmi3Instance c, fmi3Float64 indicators[], size_t n) {
  (void)indicators;
  return n == 0 && c != NULL ? fmi3OK : missing(c, "there are no event indicators");
}

FMU_PUBLIC fmi3Status FMI3(GetContinuousStates)(fmi3Instance c, fmi3Float64 x[], size_t n) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || n != (size_t)cell->states) return missing(c, "another number of states than the cell has");
  memcpy(x, cell->x, n * sizeof(double));
  return fmi3OK;
}

FMU_PUBLIC fmi3Status FMI3(GetNominalsOfContinuousStates)(fmi3Instance c, fmi3Float64 nominals[], size_t n) {
  fmu_cell *cell = cell_in(c);
  size_t k;
  if (cell == NULL || n != (size_t)cell->states) return missing(c, "another number of states than the cell has");
  for (k = 0; k < n; ++k) nominals[k] = fmu_nominal(cell, (int)k);
  return fmi3OK;
}

FMU_PUBLIC fmi3Status FMI3(GetNumberOfEventIndicators)(fmi3Instance c, size_t *n) {
  if (c == NULL || n == NULL) return fmi3Error;
  *n = 0;
  return fmi3OK;
}

FMU_PUBLIC fmi3Status FMI3(GetNumberOfContinuousStates)(fmi3Instance c, size_t *n) {
  if (c == NULL || n == NULL) return fmi3Error;
  *n = (size_t)cell_in(c)->states;
  return fmi3OK;
}

// Co-simulation.
FMU_PUBLIC fmi3Status FMI3(EnterStepMode)(fmi3Instance c) { return c == NULL ? fmi3Error : fmi3OK; }

FMU_PUBLIC fmi3Status FMI3(GetOutputDerivatives)(fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                                 const int32_t orders[], fmi3Float64 values[], size_t n_values) {
  (void)references;
  (void)n;
  (void)orders;
  (void)values;
  (void)n_values;
  return missing(c, "derivatives of outputs are not offered");
}

FMU_PUBLIC fmi3Status FMI3(DoStep)(fmi3Instance c, fmi3Float64 now_s, fmi3Float64 step_s, fmi3Boolean no_set_state,
                                   fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early,
                                   fmi3Float64 *last_s) {
  fmu_cell *cell = cell_in(c);
  int stepped;
  (void)no_set_state;
  if (cell == NULL) return fmi3Error;
  if (event != NULL) *event = false;
  if (terminate != NULL) *terminate = false;
  if (early != NULL) *early = false;
  if (!(step_s >= 0.0) || !isfinite(step_s)) return missing(c, "a step has a positive length");
  cell->saved[FMU_SAVED_TIME] = now_s;
  stepped = fmu_step(cell, step_s);
  if (stepped) cell->saved[FMU_SAVED_TIME] = now_s + step_s;
  if (last_s != NULL) *last_s = cell->saved[FMU_SAVED_TIME];
  return stepped ? fmi3OK : trouble(c, fmi3Discard, "power_W is more than the pack can give");
}

FMU_PUBLIC fmi3Status FMI3(ActivateModelPartition)(fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time_s) {
  (void)clock;
  (void)time_s;
  return missing(c, "scheduled execution is not offered");
}
