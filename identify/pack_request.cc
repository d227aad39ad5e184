#include "identify/pack_request.h"

#include "identify/validation.h"
#include "model/core/errors.h"

namespace lipoid {

double StartRequest::Soc(const Cell& cell) const {
  if (initial_soc && initial_voltage_V) {
    throw OptionError("options --initial-soc and --initial-voltage-V: give one of them");
  }
  if (initial_voltage_V) return SocAtRestVoltage(cell, *initial_voltage_V);
  return initial_soc.value_or(1.0);
}

double StartRequest::SocOfDrawn(const Cell& cell) const {
  return initial_voltage_V ? NearestSocAtRest(cell, *initial_voltage_V) : initial_soc.value_or(1.0);
}

}  // namespace lipoid
