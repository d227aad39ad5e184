#pragma once

/// @file
/// Gains of all loops: the thesis' two sets, or a file. Tests: tests/model/control/gains_test.cc.
///
///   { "schema": "lipoid.gains/1", "name": "mine",
///     "altitude": {"proportional": 5.03, "integral": 1.36, "derivative": 7.87},
///     "attitude": {"proportional": 0.99, "integral": 0.07, "derivative": 0.25},
///     "yaw":      {...}, "position": {"proportional": 0.3, "derivative": 0.35} }

#include <string>
#include <vector>

#include "model/control/error_controller.h"
#include "model/control/position_controller.h"
#include "model/core/json.h"

namespace lipoid {

inline constexpr const char* kGainsSchema = "lipoid.gains/1";

struct Gains {
  std::string name;
  ErrorGains altitude;
  ErrorGains attitude;  ///< roll and pitch
  ErrorGains yaw;
  PositionGains position;
};

/// "aware", "unaware".
[[nodiscard]] std::vector<std::string> ShippedGainsNames();

/// A set by name, else the gains file of that name. LoadError names both ways where neither is.
[[nodiscard]] Gains LoadGains(const std::string& name_or_file);

/// Strict: yaw and position may be absent and are then those of the shipped sets.
[[nodiscard]] Gains ParseGains(const std::string& text, const std::string& file);
[[nodiscard]] Json GainsToJson(const Gains& gains);

}  // namespace lipoid
