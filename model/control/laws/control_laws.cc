#include "model/control/laws/control_laws.h"

#include "model/control/laws/pid.h"
#include "model/core/nearest_name.h"

namespace lipoid {

const std::vector<ControlLaw>& ControlLaws() {
  static const std::vector<ControlLaw> kLaws{
      {"inversion",
       "dynamic inversion: torques and thrust cancel the dynamics",
       "(3.49), (3.58)",
       &InnerLoops<double>,
       0},
      {"pid",
       "PID on each axis, as if the axes were apart and the vehicle level",
       "the cascade of common autopilots",
       &PidInnerLoops,
       1},
      {"lqr",
       "linear-quadratic regulator with integral action: a PID whose gains are least in error and "
       "effort (gains files of `lipoid design --controller lqr`, or placed)",
       "model/control/riccati.h",
       &PidInnerLoops,
       1},
  };
  return kLaws;
}

const ControlLaw& FindControlLaw(std::string_view name) {
  return FindNamed("controller", name, ControlLaws());
}

}  // namespace lipoid
