#include "identify/pack_request.h"

#include "model/battery/rest_voltage.h"
#include "model/core/errors.h"

namespace lipoid {

double StartRequest::Soc(const Cell& cell, const Surroundings& surroundings) const {
  if (initial_soc && initial_voltage_V) {
    throw OptionError("options --initial-soc and --initial-voltage-V: give one of them");
  }
  if (initial_voltage_V) return SocAtRestVoltage(cell, *initial_voltage_V, surroundings);
  return initial_soc.value_or(1.0);
}

double StartRequest::SocOfDrawn(const Cell& cell, const Surroundings& surroundings) const {
  return initial_voltage_V ? NearestSocAtRest(cell, *initial_voltage_V, surroundings)
                           : initial_soc.value_or(1.0);
}

}  // namespace lipoid
