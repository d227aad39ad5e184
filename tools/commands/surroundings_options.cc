#include "tools/commands/surroundings_options.h"

namespace lipoid {

void TellWhatSaysNothing(cli::CommandLine& line,
                         const Cell& cell,
                         const SurroundingsRequest& surroundings) {
  if (cell.temperature || (!surroundings.ambient_degC && !surroundings.predict_temperature)) return;
  line.Message(
      "{}: the cell file knows no temperature (key `temperature`), and predicts the same at any",
      surroundings.ambient_degC ? "--ambient-degC" : "--predict-temperature");
}

}  // namespace lipoid
