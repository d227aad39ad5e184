#include "model/control/laws/control_laws.h"

#include <fmt/format.h>

#include "model/control/laws/pid.h"
#include "model/core/errors.h"

namespace lipoid {

const std::vector<ControlLaw>& ControlLaws() {
  static const std::vector<ControlLaw> kLaws{
      {"inversion",
       "dynamic inversion: torques and thrust cancel the dynamics",
       "(3.49), (3.58)",
       &InnerLoops<double>},
      {"pid",
       "PID on each axis, as if the axes were apart and the vehicle level",
       "the cascade of common autopilots",
       &PidInnerLoops},
  };
  return kLaws;
}

const ControlLaw& FindControlLaw(std::string_view name) {
  std::string known;
  for (const ControlLaw& law : ControlLaws()) {
    if (law.name == name) return law;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", law.name);
  }
  throw OptionError(fmt::format("unknown controller '{}'. Known: {}", name, known));
}

}  // namespace lipoid
