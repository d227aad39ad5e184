#pragma once

/// @file
/// Gazebo's LinearBatteryPlugin: one straight line, one resistance and one time constant, which
/// smooths the drop and the count of the charge alike. In every physics step, with the raw current
/// i = P/v of the last voltage or, here, an imposed one,
///
///   s += (dt/tau)(i - s),   q -= s dt/3600,   v = e0 + e1 (1 - q/c) - r s
///
/// tau is at least dt. Volts, amperes and ohms of the pack. Tests:
/// tests/model/export/laws_test.cc.

#include <vector>

#include "model/export/exported.h"

namespace lipoid {

struct GazeboBattery {
  double constant_V = 0.0;      ///< e0, open_circuit_voltage_constant_coef
  double linear_V = 0.0;        ///< e1, open_circuit_voltage_linear_coef: over a full discharge
  double capacity_Ah = 0.0;     ///< c, > 0
  double resistance_Ohm = 0.0;  ///< r
  double smoothing_s = 1.0;     ///< tau, smooth_current_tau, > 0
};

inline constexpr double kGazeboStep_s = 1e-3;  ///< max_step_size of its default physics

/// The voltage in every row with the current imposed. `drawn_Ah` as of ChargeDrawn_Ah(), of which
/// the first one counts here. The smoothed current starts at 0, and so does the battery at rest.
[[nodiscard]] std::vector<double> GazeboVoltage(const GazeboBattery& battery,
                                                const ExportMission& mission,
                                                const std::vector<double>& drawn_Ah);

/// The same with a power of power_W[k] in W over the interval that ends with row k, and the current
/// P/v of the last step: what a power_load does.
[[nodiscard]] std::vector<double> GazeboVoltageUnderPower(const GazeboBattery& battery,
                                                          const ExportMission& mission,
                                                          const std::vector<double>& power_W,
                                                          const std::vector<double>& drawn_Ah);

}  // namespace lipoid
