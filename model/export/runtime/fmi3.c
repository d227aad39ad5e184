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
#define FMI(name) FMU_PASTED(FMI3_FUNCTION_PREFIX, fmi3##name)
#else
#define FMI(name) fmi3##name
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

typedef fmi3Status fmi_status;
typedef fmi3Boolean fmi_boolean;
typedef fmi3String fmi_string;
typedef fmi3ValueReference fmi_reference;
typedef int32_t fmi_integer;
#define FMI_OK fmi3OK
#define FMI_DISCARD fmi3Discard
#define FMI_ERROR fmi3Error
#include "fmu_functions.h"

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

FMU_PUBLIC const char *FMI(GetVersion)(void) { return "3.0"; }

FMU_PUBLIC fmi3Instance FMI(InstantiateModelExchange)(fmi3String name, fmi3String token, fmi3String resources,
                                                      fmi3Boolean visible, fmi3Boolean logging,
                                                      fmi3InstanceEnvironment environment,
                                                      fmi3LogMessageCallback log) {
  (void)name;
  (void)visible;
  (void)logging;
  return instantiate(token, resources, environment, log);
}

FMU_PUBLIC fmi3Instance FMI(InstantiateCoSimulation)(fmi3String name, fmi3String token, fmi3String resources,
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

FMU_PUBLIC fmi3Instance FMI(InstantiateScheduledExecution)(fmi3String name, fmi3String token, fmi3String resources,
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

FMU_PUBLIC void FMI(FreeInstance)(fmi3Instance c) {
  instance *of = (instance *)c;
  if (of == NULL) return;
  fmu_free(of->cell);
  free(of);
}

FMU_PUBLIC fmi3Status FMI(EnterInitializationMode)(fmi3Instance c, fmi3Boolean tolerance_defined,
                                                   fmi3Float64 tolerance, fmi3Float64 start_s,
                                                   fmi3Boolean stop_defined, fmi3Float64 stop_s) {
  (void)tolerance_defined;
  (void)tolerance;
  (void)stop_defined;
  (void)stop_s;
  (void)set_time(c, start_s);
  return enter(c, FMU_INITIALIZING);
}

FMU_PUBLIC fmi3Status FMI(GetFloat64)(fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                      fmi3Float64 values[], size_t n_values) {
  if (n != n_values) return missing(c, "as many values as value references");
  return get_reals(c, references, n, values, "there is no Float64 variable of this value reference");
}

FMU_PUBLIC fmi3Status FMI(SetFloat64)(fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                      const fmi3Float64 values[], size_t n_values) {
  if (n != n_values) return missing(c, "as many values as value references");
  return set_reals(c, references, n, values);
}

FMU_PUBLIC fmi3Status FMI(GetInt32)(fmi3Instance c, const fmi3ValueReference references[], size_t n, int32_t values[],
                                    size_t n_values) {
  if (n != n_values) return missing(c, "as many values as value references");
  return get_counts(c, references, n, values, "there is no Int32 variable of this value reference");
}

FMU_PUBLIC fmi3Status FMI(SetInt32)(fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                    const int32_t values[], size_t n_values) {
  if (n != n_values) return missing(c, "as many values as value references");
  return set_counts(c, references, n, values);
}

// The types of which the cell has no variable.
#define FMU_NO_VARIABLES(name, type)                                                                    \
  FMU_PUBLIC fmi3Status FMI(Get##name)(fmi3Instance c, const fmi3ValueReference references[], size_t n, \
                                       type values[], size_t n_values) {                                \
    (void)references;                                                                                   \
    (void)values;                                                                                       \
    (void)n_values;                                                                                     \
    return n == 0 && c != NULL ? fmi3OK : missing(c, "there are no variables of this type");            \
  }                                                                                                     \
  FMU_PUBLIC fmi3Status FMI(Set##name)(fmi3Instance c, const fmi3ValueReference references[], size_t n, \
                                       const type values[], size_t n_values) {                          \
    (void)references;                                                                                   \
    (void)values;                                                                                       \
    (void)n_values;                                                                                     \
    return n == 0 && c != NULL ? fmi3OK : missing(c, "there are no variables of this type");            \
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

FMU_PUBLIC fmi3Status FMI(GetBinary)(fmi3Instance c, const fmi3ValueReference references[], size_t n, size_t sizes[],
                                     fmi3Binary values[], size_t n_values) {
  (void)references;
  (void)sizes;
  (void)values;
  (void)n_values;
  return n == 0 && c != NULL ? fmi3OK : missing(c, "there are no variables of this type");
}

FMU_PUBLIC fmi3Status FMI(SetBinary)(fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                     const size_t sizes[], const fmi3Binary values[], size_t n_values) {
  (void)references;
  (void)sizes;
  (void)values;
  (void)n_values;
  return n == 0 && c != NULL ? fmi3OK : missing(c, "there are no variables of this type");
}

// Clocks: there are none.
#define FMU_NO_CLOCK(name, parameters)                                       \
  FMU_PUBLIC fmi3Status FMI(name) parameters {                               \
    (void)references;                                                        \
    (void)a;                                                                 \
    return n == 0 && c != NULL ? fmi3OK : missing(c, "there are no clocks"); \
  }
#define FMU_NO_CLOCK_OF_TWO(name, parameters)                                \
  FMU_PUBLIC fmi3Status FMI(name) parameters {                               \
    (void)references;                                                        \
    (void)a;                                                                 \
    (void)b;                                                                 \
    return n == 0 && c != NULL ? fmi3OK : missing(c, "there are no clocks"); \
  }
FMU_NO_CLOCK(GetClock, (fmi3Instance c, const fmi3ValueReference references[], size_t n, fmi3Boolean a[]))
FMU_NO_CLOCK(SetClock, (fmi3Instance c, const fmi3ValueReference references[], size_t n, const fmi3Boolean a[]))
FMU_NO_CLOCK_OF_TWO(GetIntervalDecimal,
                    (fmi3Instance c, const fmi3ValueReference references[], size_t n, double a[], int b[]))
FMU_PUBLIC fmi3Status FMI(GetIntervalFraction)(fmi3Instance c, const fmi3ValueReference references[], size_t n,
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

FMU_PUBLIC fmi3Status FMI(GetNumberOfVariableDependencies)(fmi3Instance c, fmi3ValueReference reference, size_t *n) {
  (void)reference;
  (void)n;
  return missing(c, "dependencies are those of modelDescription.xml");
}

FMU_PUBLIC fmi3Status FMI(GetVariableDependencies)(fmi3Instance c, fmi3ValueReference dependent, size_t elements[],
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

FMU_PUBLIC fmi3Status FMI(GetFMUState)(fmi3Instance c, fmi3FMUState *state) { return get_state(c, state); }

FMU_PUBLIC fmi3Status FMI(SetFMUState)(fmi3Instance c, fmi3FMUState state) { return set_state(c, state); }

FMU_PUBLIC fmi3Status FMI(FreeFMUState)(fmi3Instance c, fmi3FMUState *state) { return free_state(c, state); }

FMU_PUBLIC fmi3Status FMI(SerializedFMUStateSize)(fmi3Instance c, fmi3FMUState state, size_t *size) {
  return state_size(c, state, size);
}

FMU_PUBLIC fmi3Status FMI(SerializeFMUState)(fmi3Instance c, fmi3FMUState state, uint8_t bytes[], size_t size) {
  return serialize_state(c, state, bytes, size);
}

FMU_PUBLIC fmi3Status FMI(DeserializeFMUState)(fmi3Instance c, const uint8_t bytes[], size_t size,
                                               fmi3FMUState *state) {
  return deserialize_state(c, bytes, size, state);
}

#define FMU_NO_DERIVATIVE(name)                                                                                 \
  FMU_PUBLIC fmi3Status FMI(name)(fmi3Instance c, const fmi3ValueReference unknowns[], size_t n_unknowns,       \
                                  const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[], \
                                  size_t n_seed, fmi3Float64 sensitivity[], size_t n_sensitivity) {             \
    (void)unknowns;                                                                                             \
    (void)n_unknowns;                                                                                           \
    (void)knowns;                                                                                               \
    (void)n_knowns;                                                                                             \
    (void)seed;                                                                                                 \
    (void)n_seed;                                                                                               \
    (void)sensitivity;                                                                                          \
    (void)n_sensitivity;                                                                                        \
    return missing(c, "directional and adjoint derivatives are not offered");                                   \
  }
FMU_NO_DERIVATIVE(GetDirectionalDerivative)
FMU_NO_DERIVATIVE(GetAdjointDerivative)

FMU_PUBLIC fmi3Status FMI(EnterConfigurationMode)(fmi3Instance c) { return there(c); }

FMU_PUBLIC fmi3Status FMI(ExitConfigurationMode)(fmi3Instance c) { return there(c); }

FMU_PUBLIC fmi3Status FMI(EvaluateDiscreteStates)(fmi3Instance c) { return there(c); }

FMU_PUBLIC fmi3Status FMI(UpdateDiscreteStates)(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *terminate,
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
FMU_PUBLIC fmi3Status FMI(GetContinuousStateDerivatives)(fmi3Instance c, fmi3Float64 derivatives[], size_t n) {
  return get_derivatives(c, derivatives, n);
}

FMU_PUBLIC fmi3Status FMI(GetNumberOfEventIndicators)(fmi3Instance c, size_t *n) {
  if (c == NULL || n == NULL) return fmi3Error;
  *n = 0;
  return fmi3OK;
}

FMU_PUBLIC fmi3Status FMI(GetNumberOfContinuousStates)(fmi3Instance c, size_t *n) {
  if (c == NULL || n == NULL) return fmi3Error;
  *n = (size_t)cell_in(c)->states;
  return fmi3OK;
}

// Co-simulation.
FMU_PUBLIC fmi3Status FMI(EnterStepMode)(fmi3Instance c) { return there(c); }

FMU_PUBLIC fmi3Status FMI(GetOutputDerivatives)(fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                                const int32_t orders[], fmi3Float64 values[], size_t n_values) {
  (void)references;
  (void)n;
  (void)orders;
  (void)values;
  (void)n_values;
  return missing(c, "derivatives of outputs are not offered");
}

FMU_PUBLIC fmi3Status FMI(DoStep)(fmi3Instance c, fmi3Float64 now_s, fmi3Float64 step_s, fmi3Boolean no_set_state,
                                  fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early,
                                  fmi3Float64 *last_s) {
  fmi3Status status;
  (void)no_set_state;
  if (c == NULL) return fmi3Error;
  if (event != NULL) *event = false;
  if (terminate != NULL) *terminate = false;
  if (early != NULL) *early = false;
  status = take_step(c, now_s, step_s);
  if (last_s != NULL && status != fmi3Error) *last_s = cell_in(c)->saved[FMU_SAVED_TIME];
  return status;
}

FMU_PUBLIC fmi3Status FMI(ActivateModelPartition)(fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time_s) {
  (void)clock;
  (void)time_s;
  return missing(c, "scheduled execution is not offered");
}
