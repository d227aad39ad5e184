// Asks the library of an FMU for more power than its pack has, then for less: an importer that does not hear that the
// first step cannot be made shorter takes it again for ever.
// fmi_test.cc compiles it with model/export/runtime/fmi2.c:  fmu_spent RESOURCES GUID
#define FMU_READS_NUMBERS
#include "fmi2.c"

int main(int arguments, char **argument) {
  const fmi2CallbackFunctions none = {NULL, NULL, NULL, NULL, NULL};
  const unsigned input = FMU_POWER;
  const double powers[] = {1e6, 1.0};
  const fmi2Status expected[] = {fmi2Discard, fmi2OK};
  fmi2Component cell;
  int k;
  if (arguments != 3) return 2;
  cell = fmi2Instantiate("spent", fmi2CoSimulation, argument[2], argument[1], &none, 0, 0);
  if (cell == NULL) return 2;
  (void)fmi2EnterInitializationMode(cell);
  (void)fmi2ExitInitializationMode(cell);
  for (k = 0; k < 2; ++k) {
    fmi2Boolean terminated = 7;
    double reached_s = 7.0;
    (void)fmi2SetReal(cell, &input, 1, &powers[k]);
    if (fmi2DoStep(cell, 0.0, 0.5, 1) != expected[k]) return 3 + k;
    if (fmi2GetBooleanStatus(cell, fmi2Terminated, &terminated) != fmi2OK || terminated != (k == 0)) return 5 + k;
    if (fmi2GetRealStatus(cell, fmi2LastSuccessfulTime, &reached_s) != fmi2OK || reached_s != 0.5 * k) return 7 + k;
  }
  fmi2FreeInstance(cell);
  return 0;
}
