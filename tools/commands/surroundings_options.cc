#include "tools/commands/surroundings_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "model/battery/arrhenius.h"
#include "model/battery/temperature_range.h"
#include "model/core/special_values.h"

namespace lipoid {
namespace {

// The option that says how warm it is; nullptr: none.
const char* Said(const SurroundingsRequest& surroundings) {
  if (surroundings.ambient_degC) return "--ambient-degC";
  return surroundings.initial_degC ? "--initial-degC" : nullptr;
}

}  // namespace

void TellWhatSaysNothing(cli::CommandLine& line,
                         const Cell& cell,
                         const SurroundingsRequest& surroundings) {
  const char* given = Said(surroundings);
  if (!given && surroundings.predict_temperature) given = "--predict-temperature";
  if (cell.temperature || !given) return;
  line.Message(
      "{}: the cell file knows no temperature (key `temperature`), and predicts the same at any",
      given);
}

void TellWhatIsMeasured(cli::CommandLine& line,
                        const Cell& cell,
                        const std::string& file,
                        const SurroundingsRequest& asked,
                        const Surroundings& surroundings) {
  if (!cell.temperature || surroundings.measured_degC.empty() || !Said(asked)) return;
  line.Message(
      "{}: it has temperature_degC, which is used in place of {}; --predict-temperature asks "
      "for the temperature that the cell would have there",
      file,
      Said(asked));
}

void TellWhatIsExtrapolated(cli::CommandLine& line,
                            const Cell& cell,
                            std::span<const Surroundings> all) {
  double coldest_degC = kInfinity;
  double warmest_degC = -kInfinity;
  const auto feel = [&](double degC) {
    coldest_degC = std::min(coldest_degC, degC);
    warmest_degC = std::max(warmest_degC, degC);
  };
  for (const Surroundings& among : all) {
    std::for_each(among.measured_degC.begin(), among.measured_degC.end(), feel);
    if (!among.measured_degC.empty()) continue;
    if (among.ambient_degC) feel(*among.ambient_degC);
    if (among.initial_degC) feel(*among.initial_degC);
  }
  if (coldest_degC > warmest_degC) return;
  const std::string doubt = DoubtAboutTemperature(cell, coldest_degC, warmest_degC);
  if (!doubt.empty()) line.Message("{}", doubt);
}

void TellWhatTemperatureMayExplain(cli::CommandLine& line,
                                   const Cell& cell,
                                   const std::string& file,
                                   const Surroundings& surroundings) {
  const auto measured_degC = surroundings.measured_degC;
  if (cell.temperature && measured_degC.empty() && !surroundings.ambient_degC) {
    line.Message(
        "{}: it tells no temperature, and is predicted {} {:.3g} degC; --ambient-degC says which it was",
        file,
        surroundings.initial_degC ? "in surroundings of" : "at",
        cell.temperature->reference_K - kZeroCelsius_K);
  }
  constexpr double kRoom_degC = kUsual_K - kZeroCelsius_K;  // where cells are mostly identified
  constexpr double kFar_K = 10.0;                           // a resistance then differs by a third
  if (cell.temperature || measured_degC.empty()) return;
  const double mean_degC = std::accumulate(measured_degC.begin(), measured_degC.end(), 0.0) /
                           static_cast<double>(measured_degC.size());
  if (!(std::abs(mean_degC - cell.reference_degC.value_or(kRoom_degC)) > kFar_K)) return;
  line.Message(
      "{}: it was {:.0f} degC on average, and the cell file knows no temperature (key `temperature`): {}"
      "that may be why the prediction is off; identify the cell from logs of both",
      file,
      mean_degC,
      cell.reference_degC
          ? fmt::format("it was identified at {:.3g} degC, and ", *cell.reference_degC)
          : "if the cell was identified at another one, ");
}

}  // namespace lipoid
