#include "identify/surroundings_request.h"

namespace lipoid {

Surroundings SurroundingsRequest::Of(const Record& record) const {
  const auto& measured_degC = record.temperature_degC;
  if (!measured_degC.empty() && !predict_temperature)
    return {.measured_degC = measured_degC, .ambient_degC = ambient_degC};
  Surroundings surroundings{.ambient_degC = ambient_degC, .initial_degC = initial_degC};
  if (measured_degC.empty()) return surroundings;
  if (!initial_degC) surroundings.initial_degC = measured_degC.front();
  if (!ambient_degC) surroundings.ambient_degC = measured_degC.front();
  return surroundings;
}

}  // namespace lipoid
