#include "tools/commands/surroundings_options.h"

#include <algorithm>

#include "model/battery/temperature_range.h"

namespace lipoid {

void TellWhatSaysNothing(cli::CommandLine& line,
                         const Cell& cell,
                         const SurroundingsRequest& surroundings) {
  if (cell.temperature || (!surroundings.ambient_degC && !surroundings.predict_temperature)) return;
  line.Message(
      "{}: the cell file knows no temperature (key `temperature`), and predicts the same at any",
      surroundings.ambient_degC ? "--ambient-degC" : "--predict-temperature");
}

void TellWhatIsExtrapolated(cli::CommandLine& line,
                            const Cell& cell,
                            const Surroundings& surroundings) {
  const auto measured = surroundings.measured_degC;
  if (measured.empty() && !surroundings.ambient_degC) return;
  const double ambient_degC = surroundings.ambient_degC.value_or(0.0);
  const auto [coldest, warmest] = std::minmax_element(measured.begin(), measured.end());
  const std::string doubt = measured.empty()
                                ? DoubtAboutTemperature(cell, ambient_degC, ambient_degC)
                                : DoubtAboutTemperature(cell, *coldest, *warmest);
  if (!doubt.empty()) line.Message("{}", doubt);
}

}  // namespace lipoid
