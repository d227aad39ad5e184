#pragma once

/// @file
/// The only list of control laws of the inner loops: help, `list controllers` and messages are made
/// from it. To add one: a file here and a row in control_laws.cc.
/// Tests: tests/model/control/control_laws_test.cc.

#include <optional>
#include <string_view>
#include <vector>

#include "model/control/control_law.h"

namespace lipoid {

/// From references, measured state and error integrals to the wrench that is commanded; everything
/// around it (references, allocation, anti-windup, saturation, PWM) is the flight controller's.
struct ControlLaw {
  std::string_view name;
  std::string_view summary;
  std::string_view source;
  InnerLoopOutput<double> (*inner_loops)(const Vehicle&,
                                         const Gains&,
                                         const InnerLoopState<double>&,
                                         const InnerLoopReferences<double>&,
                                         const ErrorIntegrals<double>&);
  /// The value of LIPOID_LAW for it in model/export/flight_code/lipoid_controller.c; none: the law
  /// flies in the simulator only.
  std::optional<int> in_c;
};

[[nodiscard]] const std::vector<ControlLaw>& ControlLaws();

/// Throws OptionError naming all laws.
[[nodiscard]] const ControlLaw& FindControlLaw(std::string_view name);

}  // namespace lipoid
