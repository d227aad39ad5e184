// Gives the library of an FMU thousands of damaged resources, under sanitizers: each is refused, or read and run.
// fmi_test.cc compiles it with model/export/runtime/fmi2.c:  fmu_damaged FOLDER GUID, where FOLDER holds cell.orig.
#define FMU_READS_NUMBERS
#include "fmi2.c"

enum { HEAD = 48, MOST = 1 << 20, ROUNDS = 1500 };

static unsigned char original[MOST];
static unsigned char damaged[MOST];

// A small generator of our own: the same damage on every system.
static unsigned next(unsigned below) {
  static unsigned long long state = 1;
  state = state * 6364136223846793005ULL + 1442695040888963407ULL;
  return (unsigned)(state >> 33) % below;
}

static size_t damage(size_t size) {
  const double numbers[] = {0.0, 1.0, 2.0, 3.0, 10.0, 1e9, -1.0, 1e300, 0.5, 34.0};
  const unsigned edits = 1 + next(3);
  size_t length = size;
  unsigned k;
  memcpy(damaged, original, size);
  for (k = 0; k < edits; ++k) {
    const size_t at = HEAD + next((unsigned)(size - HEAD));
    switch (next(4)) {
      case 0:
        damaged[at] = (unsigned char)next(256);
        break;
      case 1:
        memcpy(damaged + HEAD + (at - HEAD) / 8 * 8, &numbers[next(10)], 8);
        break;
      case 2:
        length = at;
        break;
      default:
        damaged[at] = original[HEAD + next((unsigned)(size - HEAD))];
    }
  }
  return length;
}

int main(int arguments, char **argument) {
  const fmi2CallbackFunctions none = {NULL, NULL, NULL, NULL, NULL};
  char *file;
  FILE *in;
  size_t size;
  int ran = 0;
  int round;
  if (arguments != 3) return 2;
  file = fmu_resource(argument[1], "cell.orig");
  in = fopen(file, "rb");
  free(file);
  if (in == NULL) return 2;
  size = fread(original, 1, sizeof original, in);
  fclose(in);
  file = fmu_resource(argument[1], "cell.bin");
  for (round = 0; round < ROUNDS; ++round) {
    const unsigned inputs[] = {FMU_CURRENT, FMU_POWER};
    const double loads[] = {2.0, 5.0};
    const unsigned outputs[] = {FMU_VOLTAGE, FMU_SOC, FMU_OPEN_CIRCUIT};
    double values[3];
    const size_t length = damage(size);
    fmi2Component cell;
    FILE *out = fopen(file, "wb");
    if (out == NULL || fwrite(damaged, 1, length, out) != length || fclose(out) != 0) return 2;
    cell = fmi2Instantiate("damaged", fmi2CoSimulation, argument[2], argument[1], &none, 0, 0);
    if (cell == NULL) continue;
    ++ran;
    (void)fmi2EnterInitializationMode(cell);
    (void)fmi2ExitInitializationMode(cell);
    (void)fmi2SetReal(cell, &inputs[0], 1, &loads[0]);
    (void)fmi2DoStep(cell, 0.0, 0.5, 1);
    (void)fmi2SetReal(cell, &inputs[1], 1, &loads[1]);
    (void)fmi2DoStep(cell, 0.5, 0.5, 1);
    (void)fmi2GetReal(cell, outputs, 3, values);
    fmi2FreeInstance(cell);
  }
  free(file);
  printf("%d of %d ran\n", ran, ROUNDS);
  return ran > 0 && ran < ROUNDS ? 0 : 1;
}
