#pragma once

/// @file
/// Gains of all loops: the thesis' two sets, or a file. Tests: tests/model/control/gains_test.cc.
///
///   { "schema": "lipoid.gains/1", "name": "mine",
///     "altitude": {"proportional": 5.03, "integral": 1.36, "derivative": 7.87},
///     "attitude": {"proportional": 0.99, "integral": 0.07, "derivative": 0.25},
///     "yaw":      {...}, "position": {"proportional": 0.3, "derivative": 0.35},
///     "references": {"altitude_rad_per_s": 5, "attitude_rad_per_s": 100, ...} }

#include <string>
#include <vector>

#include "model/control/error_controller.h"
#include "model/control/position_controller.h"
#include "model/core/json.h"

namespace lipoid {

inline constexpr const char* kGainsSchema = "lipoid.gains/1";

/// Natural frequencies and speeds of the reference models that the gains go with. The thesis gives
/// altitude and attitude for its vehicle, the rest is ours.
struct References {
  double altitude_rad_per_s = 5.0;
  double attitude_rad_per_s = 100.0;
  double yaw_rad_per_s = 4.0;
  double position_rad_per_s = 1.2;  ///< of x and y
  double climb_m_per_s = 2.0;       ///< at most
  double descent_m_per_s = 1.5;     ///< at most
  double speed_m_per_s = 1.5;       ///< at most, of x and of y
};

struct Gains {
  std::string name;
  ErrorGains altitude;
  ErrorGains attitude;  ///< roll and pitch
  ErrorGains yaw;
  PositionGains position;
  References references = {};
};

/// "aware", "unaware".
[[nodiscard]] std::vector<std::string> ShippedGainsNames();

/// A set by name, else the gains file of that name. LoadError names both ways where neither is.
[[nodiscard]] Gains LoadGains(const std::string& name_or_file);

/// Strict: yaw, position and references may be absent and are then those of the shipped sets.
[[nodiscard]] Gains ParseGains(const std::string& text, const std::string& file);
[[nodiscard]] Json GainsToJson(const Gains& gains);

}  // namespace lipoid
