// What both versions of FMI share: an instance of a cell with its inputs, parameters and states. C99.
//
// The sources in an FMU hold the cell's numbers (cell_numbers.h). The library that lipoid puts into an FMU is
// the same code with FMU_READS_NUMBERS: it reads them from resources/cell.bin when it is instantiated.

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CELL_FLOAT 0
#define CELL_NUMBER(number) number
#include "cell_law.h"
#ifndef FMU_READS_NUMBERS
#include "cell_numbers.h"
#endif

#if defined(_WIN32)
#define FMU_PUBLIC __declspec(dllexport)
#elif defined(__GNUC__)
#define FMU_PUBLIC __attribute__((visibility("default")))
#else
#define FMU_PUBLIC
#endif

// Value references.
enum {
  FMU_TIME = 0,
  FMU_CURRENT = 1,
  FMU_POWER = 2,
  FMU_VOLTAGE = 3,
  FMU_SOC = 4,
  FMU_OPEN_CIRCUIT = 5,
  FMU_DRAWN = 6,
  FMU_SERIES = 7,
  FMU_PARALLEL = 8,
  FMU_INITIAL_SOC = 9,
  FMU_RESISTANCE_SCALE = 10,
  FMU_STATE = 1000,
  FMU_DERIVATIVE = 200000
};

enum { FMU_INSTANTIATED, FMU_INITIALIZING, FMU_RUNNING, FMU_TERMINATED };

// Under power the current changes within a step: it is looked up anew at least so often.
#define FMU_POWER_STEP_S 0.05

// The numbers that make the state of an instance, before the states of the cell and what they carry.
enum {
  FMU_SAVED_TIME,
  FMU_SAVED_CURRENT,
  FMU_SAVED_POWER,
  FMU_SAVED_SERIES,
  FMU_SAVED_PARALLEL,
  FMU_SAVED_INITIAL_SOC,
  FMU_SAVED_SCALE,
  FMU_SAVED_PHASE,
  FMU_SAVED
};

typedef struct {
  const cell_numbers *numbers;
  double *read;            // the bytes of resources/cell.bin as numbers, to which `own` points
  cell_resistance *branch;
  cell_numbers own;
  double default_series;
  double default_parallel;
  int states;
  double *work;  // owns the six lists below
  double *x;
  double *carry;
  double *loss;
  double *gain;
  double *trial;
  double *trial_carry;
  double prepared_s;
  double saved[FMU_SAVED];
} fmu_cell;

// Cells in series or in parallel.
static int fmu_is_count(double value) { return value >= 1.0 && value <= 1e9; }

#ifdef FMU_READS_NUMBERS
// The bytes of the resource, read in their order; `bad` once anything is not what it should be.
typedef struct {
  double *at;
  double *end;
  int bad;
} fmu_reader;

static double fmu_next(fmu_reader *reader) {
  if (reader->at == reader->end || !isfinite(*reader->at)) {
    reader->bad = 1;
    return 0.0;
  }
  return *reader->at++;
}

static int fmu_count(fmu_reader *reader) {
  const double count = fmu_next(reader);
  if (!(count >= 0.0) || count > (double)(reader->end - reader->at) || floor(count) < count) {
    reader->bad = 1;
    return 0;
  }
  return (int)count;
}

static const double *fmu_list(fmu_reader *reader, int count) {
  const double *list = reader->at;
  int k;
  for (k = 0; k < count; ++k) (void)fmu_next(reader);
  return list;
}

static const double *fmu_increasing(fmu_reader *reader, int count) {
  const double *list = fmu_list(reader, count);
  int k;
  for (k = 1; !reader->bad && k < count; ++k) {
    if (!(list[k] > list[k - 1])) reader->bad = 1;
  }
  return list;
}

static cell_resistance fmu_ohms(fmu_reader *reader) {
  cell_resistance ohms = {0, NULL, NULL};
  ohms.nodes = fmu_count(reader);
  if (ohms.nodes < 1) reader->bad = 1;
  ohms.resistance_Ohm = fmu_list(reader, ohms.nodes);
  if (ohms.nodes > 1) ohms.soc = fmu_increasing(reader, ohms.nodes);
  return ohms;
}

// The mark, the instantiation token and then numbers, little-endian; 0 where that is not what is there.
static int fmu_read_numbers(fmu_cell *cell, const char *file, const char *token) {
  enum { MARK = 8, TOKEN = 40 };
  const long most_bytes = 64L * 1024L * 1024L;
  FILE *in = fopen(file, "rb");
  unsigned char head[MARK + TOKEN];
  unsigned char byte[8];
  fmu_reader reader = {NULL, NULL, 0};
  cell_numbers *own = &cell->own;
  double kind;
  long bytes;
  size_t count;
  size_t k;
  int j;
  if (in == NULL) return 0;
  if (fseek(in, 0, SEEK_END) != 0 || (bytes = ftell(in)) < MARK + TOKEN || bytes > most_bytes ||
      fseek(in, 0, SEEK_SET) != 0 || fread(head, 1, sizeof head, in) != sizeof head ||
      memcmp(head, "lipoid.c", MARK) != 0 || strlen(token) > TOKEN ||
      strncmp((const char *)head + MARK, token, TOKEN) != 0) {
    fclose(in);
    return 0;
  }
  count = (size_t)(bytes - MARK - TOKEN) / 8;
  cell->read = (double *)calloc(count + 1, sizeof(double));
  if (cell->read == NULL) {
    fclose(in);
    return 0;
  }
  for (k = 0; k < count; ++k) {
    uint64_t bits = 0;
    if (fread(byte, 1, 8, in) != 8) break;
    for (j = 7; j >= 0; --j) bits = bits << 8 | byte[j];
    memcpy(&cell->read[k], &bits, 8);
  }
  fclose(in);
  reader.at = cell->read;
  reader.end = cell->read + k;
  cell->default_series = fmu_next(&reader);
  cell->default_parallel = fmu_next(&reader);
  if (!fmu_is_count(cell->default_series) || !fmu_is_count(cell->default_parallel)) reader.bad = 1;
  own->alpha_C = fmu_next(&reader);
  own->tail_s = fmu_next(&reader);
  own->modes = fmu_count(&reader);
  own->rate_per_s = fmu_increasing(&reader, own->modes);
  own->branches = fmu_count(&reader);
  own->time_constant_s = fmu_list(&reader, own->branches);
  cell->branch = (cell_resistance *)calloc((size_t)own->branches + 1, sizeof(cell_resistance));
  if (cell->branch == NULL) return 0;
  for (j = 0; !reader.bad && j < own->branches; ++j) {
    cell->branch[j] = fmu_ohms(&reader);
    if (!(own->time_constant_s[j] > 0.0)) reader.bad = 1;
  }
  own->branch = cell->branch;
  own->series = fmu_ohms(&reader);
  own->warms = fmu_next(&reader) > 0.0;
  own->thermal_s = fmu_next(&reader);
  own->drop_Ohm_per_A2 = fmu_next(&reader);
  own->least_share = fmu_next(&reader);
  own->transfers = fmu_next(&reader) > 0.0;
  own->transfer_A = fmu_next(&reader);
  own->transfer = fmu_ohms(&reader);
  kind = fmu_next(&reader);
  if (!(kind >= (double)CELL_CURVE_PIECES) || kind > (double)CELL_CURVE_FOURIER) {
    reader.bad = 1;
    kind = 0.0;
  }
  own->curve = (int)kind;
  own->nodes = fmu_count(&reader);
  own->soc = fmu_increasing(&reader, own->nodes);
  j = fmu_count(&reader);
  own->piece_V = fmu_list(&reader, j);
  if (own->nodes < 2 || (own->curve == CELL_CURVE_PIECES && j != 4 * (own->nodes - 1))) reader.bad = 1;
  own->coefficients = fmu_count(&reader);
  own->cosine_V = fmu_list(&reader, own->coefficients);
  j = fmu_count(&reader);
  own->sine_V = fmu_list(&reader, j);
  if (own->curve != CELL_CURVE_PIECES && own->coefficients < 1) reader.bad = 1;
  if (own->curve == CELL_CURVE_FOURIER && j != own->coefficients - 1) reader.bad = 1;
  own->frequency_rad = fmu_next(&reader);
  for (j = 0; j < 2; ++j) own->end_V[j] = fmu_next(&reader);
  for (j = 0; j < 2; ++j) own->end_slope_V[j] = fmu_next(&reader);
  if (reader.at != reader.end || !(own->alpha_C > 0.0) || (own->modes > 0 && !(own->rate_per_s[0] > 0.0)) ||
      (own->warms && !(own->thermal_s > 0.0)) || (own->transfers && !(own->transfer_A > 0.0))) {
    reader.bad = 1;
  }
  cell->numbers = own;
  return !reader.bad;
}

// The folder of the resources, as FMI 2 (a file: address) or FMI 3 (a path) has it, with the file's name
// behind it; to be freed. NULL where there is no memory or no folder.
static char *fmu_resource(const char *folder, const char *file) {
  char *path;
  size_t n = 0;
  if (folder == NULL) return NULL;
  path = (char *)malloc(strlen(folder) + strlen(file) + 2);
  if (path == NULL) return NULL;
  if (strncmp(folder, "file:", 5) == 0) {
    folder += 5;
    if (strncmp(folder, "//localhost/", 12) == 0) {
      folder += 11;
    } else if (strncmp(folder, "///", 3) == 0) {
      folder += 2;
    }
    while (*folder != '\0') {
      unsigned value;
      if (*folder == '%' && strspn(folder + 1, "0123456789abcdefABCDEF") >= 2 && sscanf(folder + 1, "%2x", &value) == 1) {
        path[n++] = (char)value;
        folder += 3;
      } else {
        path[n++] = *folder++;
      }
    }
  } else {
    n = strlen(folder);
    memcpy(path, folder, n);
  }
  if (n > 0 && path[n - 1] != '/') path[n++] = '/';
  memcpy(path + n, file, strlen(file) + 1);
  return path;
}
#endif

static void fmu_free(fmu_cell *cell) {
  if (cell == NULL) return;
  free(cell->read);
  free(cell->branch);
  free(cell->work);
  free(cell);
}

static void fmu_start(fmu_cell *cell) {
  cell_relax(cell->numbers, cell->x, cell->carry, cell->saved[FMU_SAVED_INITIAL_SOC]);
}

static void fmu_reset(fmu_cell *cell) {
  memset(cell->saved, 0, sizeof cell->saved);
  cell->saved[FMU_SAVED_SERIES] = cell->default_series;
  cell->saved[FMU_SAVED_PARALLEL] = cell->default_parallel;
  cell->saved[FMU_SAVED_INITIAL_SOC] = 1.0;
  cell->saved[FMU_SAVED_SCALE] = 1.0;
  cell->saved[FMU_SAVED_PHASE] = FMU_INSTANTIATED;
  fmu_start(cell);
}

// NULL, and why, where the instance cannot be.
static fmu_cell *fmu_new(const char *token, const char *resources, const char **why) {
  fmu_cell *cell = (fmu_cell *)calloc(1, sizeof(fmu_cell));
  size_t n;
  *why = "there is not enough memory";
  if (cell == NULL) return NULL;
  if (token == NULL) token = "";
#ifdef FMU_READS_NUMBERS
  {
    char *file = fmu_resource(resources, "cell.bin");
    const int read = file != NULL && fmu_read_numbers(cell, file, token);
    free(file);
    if (!read) {
      *why = "resources/cell.bin is not there, is damaged, or belongs to another modelDescription.xml (its guid or "
             "instantiationToken differs)";
      fmu_free(cell);
      return NULL;
    }
  }
#else
  (void)resources;
  if (strcmp(token, FMU_TOKEN) != 0) {
    *why = "the guid or instantiationToken is not that of modelDescription.xml";
    fmu_free(cell);
    return NULL;
  }
  cell->numbers = &cell_of_file;
  cell->default_series = FMU_SERIES_OF_FILE;
  cell->default_parallel = FMU_PARALLEL_OF_FILE;
#endif
  cell->states = cell_states(cell->numbers);
  n = (size_t)cell->states;
  cell->work = (double *)calloc(6 * n, sizeof(double));
  if (cell->work == NULL) {
    fmu_free(cell);
    return NULL;
  }
  cell->x = cell->work;
  cell->carry = cell->work + n;
  cell->loss = cell->work + 2 * n;
  cell->gain = cell->work + 3 * n;
  cell->trial = cell->work + 4 * n;
  cell->trial_carry = cell->work + 5 * n;
  cell->prepared_s = -1.0;
  fmu_reset(cell);
  return cell;
}

static int fmu_adjustable(const fmu_cell *cell) { return cell->saved[FMU_SAVED_PHASE] < (double)FMU_RUNNING; }

// Sets an input or a parameter; 0 where there is none, the value makes no sense, or it comes too late.
static int fmu_set(fmu_cell *cell, unsigned reference, double value) {
  double *saved = cell->saved;
  if (!isfinite(value)) return 0;
  switch (reference) {
    case FMU_CURRENT:
      saved[FMU_SAVED_CURRENT] = value;
      return 1;
    case FMU_POWER:
      saved[FMU_SAVED_POWER] = value;
      return 1;
    case FMU_RESISTANCE_SCALE:
      if (value < 0.0) return 0;
      saved[FMU_SAVED_SCALE] = value;
      return 1;
    case FMU_INITIAL_SOC:
      // As lipoid's --initial-soc; 80 is a share in per cent.
      if (!fmu_adjustable(cell) || value < -0.5 || value > 1.5) return 0;
      saved[FMU_SAVED_INITIAL_SOC] = value;
      fmu_start(cell);
      return 1;
    default:
      return 0;
  }
}

static int fmu_set_count(fmu_cell *cell, unsigned reference, int value) {
  if (value < 1 || !fmu_adjustable(cell)) return 0;
  if (reference != FMU_SERIES && reference != FMU_PARALLEL) return 0;
  cell->saved[reference == FMU_SERIES ? FMU_SAVED_SERIES : FMU_SAVED_PARALLEL] = value;
  return 1;
}

static int fmu_get_count(const fmu_cell *cell, unsigned reference, int *value) {
  const double count = cell->saved[reference == FMU_SERIES ? FMU_SAVED_SERIES : FMU_SAVED_PARALLEL];
  if ((reference != FMU_SERIES && reference != FMU_PARALLEL) || !fmu_is_count(count)) return 0;
  *value = (int)count;
  return 1;
}

static double fmu_watts(const fmu_cell *cell, const double *x, double base_A, double current_A) {
  return current_A * cell_voltage(cell->numbers, x, base_A + current_A, cell->saved[FMU_SAVED_SCALE]);
}

// The current of one cell at these states: that of current_A and, beside it, the one that gives power_W. 0 where
// the pack cannot give that power: more than it has at half of the voltage without that load.
static int fmu_cell_current(const fmu_cell *cell, const double *x, double *current_A) {
  const double *saved = cell->saved;
  const double base_A = saved[FMU_SAVED_CURRENT] / saved[FMU_SAVED_PARALLEL];
  const double watts = saved[FMU_SAVED_POWER] / (saved[FMU_SAVED_SERIES] * saved[FMU_SAVED_PARALLEL]);
  const double rest_V = cell_voltage(cell->numbers, x, base_A, saved[FMU_SAVED_SCALE]);
  double from_A = 0.0;
  double to_A;
  int k;
  *current_A = base_A;
  if (!(watts < 0.0) && !(watts > 0.0)) return 1;
  if (!(rest_V > 0.0)) return 0;
  to_A = watts / rest_V;
  if (watts > 0.0) {
    // Widen until there is enough; the voltage falls meanwhile.
    for (k = 0; fmu_watts(cell, x, base_A, to_A) < watts; ++k) {
      double low_A = from_A;
      double high_A = to_A;
      from_A = to_A;
      to_A *= 1.1;
      if (cell_voltage(cell->numbers, x, base_A + to_A, saved[FMU_SAVED_SCALE]) > 0.5 * rest_V && k < 1000) continue;
      // The last chance is at half of the voltage.
      high_A = to_A;
      for (k = 0; k < 60; ++k) {
        const double middle_A = 0.5 * (low_A + high_A);
        if (cell_voltage(cell->numbers, x, base_A + middle_A, saved[FMU_SAVED_SCALE]) > 0.5 * rest_V) {
          low_A = middle_A;
        } else {
          high_A = middle_A;
        }
      }
      if (fmu_watts(cell, x, base_A, low_A) < watts) return 0;
      to_A = low_A;
      break;
    }
  }
  // Between the two the power crosses what is wanted: the secant of Illinois, which keeps both sides.
  {
    double from_W = fmu_watts(cell, x, base_A, from_A) - watts;
    double to_W = fmu_watts(cell, x, base_A, to_A) - watts;
    for (k = 0; k < 100 && fabs(to_A - from_A) > 1e-14 * fabs(to_A); ++k) {
      double at_A;
      double at_W;
      if (!(from_W < 0.0) && !(from_W > 0.0)) {
        to_A = from_A;
        break;
      }
      if (!(to_W < 0.0) && !(to_W > 0.0)) break;
      at_A = to_A - to_W * (to_A - from_A) / (to_W - from_W);
      at_W = fmu_watts(cell, x, base_A, at_A) - watts;
      if ((at_W < 0.0) != (to_W < 0.0)) {
        from_A = to_A;
        from_W = to_W;
      } else {
        from_W *= 0.5;
      }
      to_A = at_A;
      to_W = at_W;
    }
  }
  *current_A = base_A + to_A;
  return 1;
}

// What a variable has now, with the inputs as they are now. 0: there is none. 2: the power is too much.
static int fmu_get(const fmu_cell *cell, unsigned reference, double *value) {
  const cell_numbers *numbers = cell->numbers;
  const double *saved = cell->saved;
  double current_A;
  int enough = 1;
  switch (reference) {
    case FMU_TIME:
      *value = saved[FMU_SAVED_TIME];
      return 1;
    case FMU_CURRENT:
      *value = saved[FMU_SAVED_CURRENT];
      return 1;
    case FMU_POWER:
      *value = saved[FMU_SAVED_POWER];
      return 1;
    case FMU_INITIAL_SOC:
      *value = saved[FMU_SAVED_INITIAL_SOC];
      return 1;
    case FMU_RESISTANCE_SCALE:
      *value = saved[FMU_SAVED_SCALE];
      return 1;
    default:
      break;
  }
  if (reference >= FMU_STATE && reference - FMU_STATE < (unsigned)cell->states) {
    *value = cell->x[reference - FMU_STATE];
    return 1;
  }
  enough = fmu_cell_current(cell, cell->x, &current_A);
  if (reference >= FMU_DERIVATIVE && reference - FMU_DERIVATIVE < (unsigned)cell->states) {
    const int n = (int)(reference - FMU_DERIVATIVE);
    if (n == 0) {
      *value = current_A;
    } else if (n <= numbers->modes) {
      *value = current_A - numbers->rate_per_s[n - 1] * cell->x[n];
    } else if (n <= numbers->modes + numbers->branches) {
      const int j = n - numbers->modes - 1;
      const double steady_V =
          cell_ohms(&numbers->branch[j], cell_soc(numbers, cell->x, current_A)) * current_A;
      *value = (steady_V - cell->x[n]) / numbers->time_constant_s[j];
    } else {
      *value = (current_A * current_A - cell->x[n]) / numbers->thermal_s;
    }
    return enough ? 1 : 2;
  }
  switch (reference) {
    case FMU_VOLTAGE:
      *value = saved[FMU_SAVED_SERIES] * cell_voltage(numbers, cell->x, current_A, saved[FMU_SAVED_SCALE]);
      break;
    case FMU_SOC:
      *value = cell_soc(numbers, cell->x, current_A);
      break;
    case FMU_OPEN_CIRCUIT:
      *value = saved[FMU_SAVED_SERIES] * cell_open_circuit(numbers, cell_soc(numbers, cell->x, current_A));
      break;
    case FMU_DRAWN:
      *value = saved[FMU_SAVED_PARALLEL] * current_A;
      break;
    default:
      return 0;
  }
  return enough ? 1 : 2;
}

static double fmu_nominal(const fmu_cell *cell, int state) {
  return state <= cell->numbers->modes ? cell->numbers->alpha_C : 1.0;
}

static void fmu_prepare(fmu_cell *cell, double dt_s) {
  if (dt_s < cell->prepared_s || dt_s > cell->prepared_s) {
    cell_prepare(cell->numbers, dt_s, cell->loss, cell->gain);
    cell->prepared_s = dt_s;
  }
}

// Moves on with the inputs held: exact under current. Under power each part of at most FMU_POWER_STEP_S takes the
// mean of the currents at its two ends (Heun). 0 where the pack cannot give the power; the time is then that of the
// last part.
static int fmu_step(fmu_cell *cell, double dt_s) {
  const double *saved = cell->saved;
  const size_t bytes = 2 * (size_t)cell->states * sizeof(double);
  const double begin_s = saved[FMU_SAVED_TIME];
  double parts;
  double part;
  double first_A;
  double last_A;
  if (!(saved[FMU_SAVED_POWER] < 0.0) && !(saved[FMU_SAVED_POWER] > 0.0)) {
    fmu_prepare(cell, dt_s);
    cell_advance(cell->numbers, cell->x, cell->carry, cell->loss, cell->gain,
                 saved[FMU_SAVED_CURRENT] / saved[FMU_SAVED_PARALLEL]);
    cell->saved[FMU_SAVED_TIME] += dt_s;
    return 1;
  }
  parts = ceil(dt_s / FMU_POWER_STEP_S);
  for (part = 0.0; part < parts; part += 1.0) {
    fmu_prepare(cell, dt_s / parts);
    memcpy(cell->trial, cell->x, bytes);
    if (!fmu_cell_current(cell, cell->x, &first_A)) return 0;
    cell_advance(cell->numbers, cell->trial, cell->trial_carry, cell->loss, cell->gain, first_A);
    if (!fmu_cell_current(cell, cell->trial, &last_A)) return 0;
    cell_advance(cell->numbers, cell->x, cell->carry, cell->loss, cell->gain, 0.5 * (first_A + last_A));
    cell->saved[FMU_SAVED_TIME] = begin_s + dt_s * ((part + 1.0) / parts);
  }
  return 1;
}

static size_t fmu_saved_numbers(const fmu_cell *cell) { return FMU_SAVED + 2 * (size_t)cell->states; }

static void fmu_save(const fmu_cell *cell, double *to) {
  memcpy(to, cell->saved, sizeof cell->saved);
  memcpy(to + FMU_SAVED, cell->x, 2 * (size_t)cell->states * sizeof(double));
}

static void fmu_restore(fmu_cell *cell, const double *from) {
  memcpy(cell->saved, from, sizeof cell->saved);
  memcpy(cell->x, from + FMU_SAVED, 2 * (size_t)cell->states * sizeof(double));
}
