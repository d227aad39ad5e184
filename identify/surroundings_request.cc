#include "identify/surroundings_request.h"

namespace lipoid {

Surroundings SurroundingsRequest::Of(const Record& record) const {
  const auto& measured_degC = record.temperature_degC;
  Surroundings surroundings{.ambient_degC = ambient_degC};
  if (measured_degC.empty()) return surroundings;
  if (!predict_temperature) {
    surroundings.measured_degC = measured_degC;
    return surroundings;
  }
  surroundings.initial_degC = measured_degC.front();
  if (!ambient_degC) surroundings.ambient_degC = measured_degC.front();
  return surroundings;
}

}  // namespace lipoid
