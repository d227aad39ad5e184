// The functions of both versions of FMI that differ in names alone. C99. Who includes it has named them: FMI(name), the
// types fmi_status (with FMI_OK, FMI_DISCARD and FMI_ERROR), fmi_boolean, fmi_string, fmi_reference and fmi_integer,
// and has an `instance` with its `cell` and trouble(), which logs a message and returns its status.

static fmi_status missing(void *c, const char *what) { return trouble(c, FMI_ERROR, what); }

static fmi_status too_much(void *c) { return trouble(c, FMI_DISCARD, "power_W is more than the pack can give"); }

static fmu_cell *cell_in(void *c) { return c == NULL ? NULL : ((instance *)c)->cell; }

static fmi_status there(const void *c) { return c == NULL ? FMI_ERROR : FMI_OK; }

static fmi_status enter(void *c, int phase) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL) return FMI_ERROR;
  cell->saved[FMU_SAVED_PHASE] = phase;
  return FMI_OK;
}

static fmi_status set_time(void *c, double time_s) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL) return FMI_ERROR;
  cell->saved[FMU_SAVED_TIME] = time_s;
  return FMI_OK;
}

FMU_PUBLIC fmi_status FMI(SetDebugLogging)(void *c, fmi_boolean on, size_t n, const fmi_string categories[]) {
  (void)on;
  (void)n;
  (void)categories;
  return there(c);
}

FMU_PUBLIC fmi_status FMI(ExitInitializationMode)(void *c) { return enter(c, FMU_RUNNING); }

FMU_PUBLIC fmi_status FMI(Terminate)(void *c) { return enter(c, FMU_TERMINATED); }

FMU_PUBLIC fmi_status FMI(Reset)(void *c) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL) return FMI_ERROR;
  fmu_reset(cell);
  return FMI_OK;
}

static fmi_status get_reals(void *c, const fmi_reference references[], size_t n, double values[], const char *none) {
  fmu_cell *cell = cell_in(c);
  int enough = 1;
  size_t k;
  if (cell == NULL) return FMI_ERROR;
  for (k = 0; k < n; ++k) {
    const int found = fmu_get(cell, references[k], &values[k]);
    if (found == 0) return missing(c, none);
    if (found == 2) enough = 0;
  }
  return enough ? FMI_OK : too_much(c);
}

static fmi_status set_reals(void *c, const fmi_reference references[], size_t n, const double values[]) {
  fmu_cell *cell = cell_in(c);
  size_t k;
  if (cell == NULL) return FMI_ERROR;
  for (k = 0; k < n; ++k) {
    if (!fmu_set(cell, references[k], values[k])) {
      return missing(c, "this variable cannot be set, not now, or not to this value");
    }
  }
  return FMI_OK;
}

static fmi_status get_counts(void *c, const fmi_reference references[], size_t n, fmi_integer values[],
                             const char *none) {
  fmu_cell *cell = cell_in(c);
  size_t k;
  if (cell == NULL) return FMI_ERROR;
  for (k = 0; k < n; ++k) {
    int value;
    if (!fmu_get_count(cell, references[k], &value)) return missing(c, none);
    values[k] = value;
  }
  return FMI_OK;
}

static fmi_status set_counts(void *c, const fmi_reference references[], size_t n, const fmi_integer values[]) {
  fmu_cell *cell = cell_in(c);
  size_t k;
  if (cell == NULL) return FMI_ERROR;
  for (k = 0; k < n; ++k) {
    if (!fmu_set_count(cell, references[k], values[k])) {
      return missing(c, "series and parallel are at least 1 and are set before the initialization ends");
    }
  }
  return FMI_OK;
}

// A saved state is a list of numbers, which is also what is serialized.
static fmi_status get_state(void *c, void **state) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || state == NULL) return FMI_ERROR;
  if (*state == NULL) *state = calloc(fmu_saved_numbers(cell), sizeof(double));
  if (*state == NULL) return missing(c, "there is not enough memory");
  fmu_save(cell, (double *)*state);
  return FMI_OK;
}

static fmi_status set_state(void *c, void *state) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || state == NULL) return FMI_ERROR;
  fmu_restore(cell, (const double *)state);
  return FMI_OK;
}

static fmi_status free_state(void *c, void **state) {
  if (c == NULL) return FMI_ERROR;
  if (state == NULL) return FMI_OK;
  free(*state);
  *state = NULL;
  return FMI_OK;
}

static fmi_status state_size(void *c, void *state, size_t *size) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || state == NULL || size == NULL) return FMI_ERROR;
  *size = fmu_saved_numbers(cell) * sizeof(double);
  return FMI_OK;
}

static fmi_status serialize_state(void *c, void *state, void *bytes, size_t size) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || state == NULL || bytes == NULL) return FMI_ERROR;
  if (size != fmu_saved_numbers(cell) * sizeof(double)) return missing(c, "the buffer has another size than the state");
  memcpy(bytes, state, size);
  return FMI_OK;
}

static fmi_status deserialize_state(void *c, const void *bytes, size_t size, void **state) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL || state == NULL || bytes == NULL) return FMI_ERROR;
  if (size != fmu_saved_numbers(cell) * sizeof(double)) return missing(c, "the buffer has another size than the state");
  if (*state == NULL) *state = malloc(size);
  if (*state == NULL) return missing(c, "there is not enough memory");
  memcpy(*state, bytes, size);
  return FMI_OK;
}

// Model exchange.
FMU_PUBLIC fmi_status FMI(EnterEventMode)(void *c) { return there(c); }

FMU_PUBLIC fmi_status FMI(EnterContinuousTimeMode)(void *c) { return there(c); }

FMU_PUBLIC fmi_status FMI(CompletedIntegratorStep)(void *c, fmi_boolean no_set_state, fmi_boolean *enter_event,
                                                   fmi_boolean *terminate) {
  (void)no_set_state;
  if (c == NULL || enter_event == NULL || terminate == NULL) return FMI_ERROR;
  *enter_event = 0;
  *terminate = 0;
  return FMI_OK;
}

FMU_PUBLIC fmi_status FMI(SetTime)(void *c, double time_s) { return set_time(c, time_s); }

// The cell of an instance that has so many states; NULL where it has another number.
static fmu_cell *cell_of_states(void *c, size_t n) {
  fmu_cell *cell = cell_in(c);
  if (cell != NULL && n == (size_t)cell->states) return cell;
  (void)missing(c, "another number of states than the cell has");
  return NULL;
}

FMU_PUBLIC fmi_status FMI(SetContinuousStates)(void *c, const double x[], size_t n) {
  fmu_cell *cell = cell_of_states(c, n);
  if (cell == NULL) return FMI_ERROR;
  memcpy(cell->x, x, n * sizeof(double));
  memset(cell->carry, 0, n * sizeof(double));
  return FMI_OK;
}

FMU_PUBLIC fmi_status FMI(GetContinuousStates)(void *c, double x[], size_t n) {
  fmu_cell *cell = cell_of_states(c, n);
  if (cell == NULL) return FMI_ERROR;
  memcpy(x, cell->x, n * sizeof(double));
  return FMI_OK;
}

FMU_PUBLIC fmi_status FMI(GetNominalsOfContinuousStates)(void *c, double nominals[], size_t n) {
  fmu_cell *cell = cell_of_states(c, n);
  size_t k;
  if (cell == NULL) return FMI_ERROR;
  for (k = 0; k < n; ++k) nominals[k] = fmu_nominal(cell, (int)k);
  return FMI_OK;
}

static fmi_status get_derivatives(void *c, double derivatives[], size_t n) {
  fmu_cell *cell = cell_of_states(c, n);
  size_t k;
  if (cell == NULL) return FMI_ERROR;
  for (k = 0; k < n; ++k) {
    if (fmu_get(cell, FMU_DERIVATIVE + (unsigned)k, &derivatives[k]) == 2) return too_much(c);
  }
  return FMI_OK;
}

FMU_PUBLIC fmi_status FMI(GetEventIndicators)(void *c, double indicators[], size_t n) {
  (void)indicators;
  return n == 0 && c != NULL ? FMI_OK : missing(c, "there are no event indicators");
}

// Co-simulation.
static fmi_status take_step(void *c, double now_s, double step_s) {
  fmu_cell *cell = cell_in(c);
  if (cell == NULL) return FMI_ERROR;
  if (!(step_s >= 0.0) || !isfinite(step_s)) return missing(c, "a step has a positive length");
  cell->saved[FMU_SAVED_TIME] = now_s;
  if (!fmu_step(cell, step_s)) return too_much(c);
  cell->saved[FMU_SAVED_TIME] = now_s + step_s;
  return FMI_OK;
}
