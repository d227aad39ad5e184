#include "identify/surroundings_request.h"

namespace lipoid {

Surroundings SurroundingsRequest::Of(const Record& record) const {
  const auto& measured_degC = record.temperature_degC;
  if (!measured_degC.empty() && !predict_temperature)
    return {.measured_degC = measured_degC, .ambient_degC = ambient_degC};
  std::optional<double> first_degC;
  if (!measured_degC.empty()) first_degC = measured_degC.front();
  return {.ambient_degC = ambient_degC ? ambient_degC : first_degC,
          .initial_degC = initial_degC ? initial_degC : first_degC};
}

}  // namespace lipoid
