#include "tools/commands/surroundings_options.h"

#include "model/battery/ranges.h"

namespace lipoid {

void SurroundingsOptions::AddTo(cli::CommandLine& line) {
  line.Option(
      "ambient-degC",
      ambient_degC,
      kTemperatures_degC,
      "temperature of the surroundings in degC, from which the cell starts and warms, where "
      "a log has no temperature_degC; by default the cell's reference temperature");
  line.Flag("predict-temperature",
            predict,
            "predict the temperature also where a log has temperature_degC; without "
            "--ambient-degC the surroundings are as warm as its first row");
}

void SurroundingsOptions::TellWhatSaysNothing(cli::CommandLine& line, const Cell& cell) const {
  if (cell.temperature || (!ambient_degC && !predict)) return;
  line.Message(
      "{}: the cell file knows no temperature (key `temperature`), and predicts the same at any",
      ambient_degC ? "--ambient-degC" : "--predict-temperature");
}

Surroundings SurroundingsOptions::Of(const Record& record) const {
  const auto& measured_degC = record.temperature_degC;
  Surroundings surroundings{.ambient_degC = ambient_degC};
  if (measured_degC.empty()) return surroundings;
  if (!predict) {
    surroundings.measured_degC = measured_degC;
    return surroundings;
  }
  surroundings.initial_degC = measured_degC.front();
  if (!ambient_degC) surroundings.ambient_degC = measured_degC.front();
  return surroundings;
}

}  // namespace lipoid
