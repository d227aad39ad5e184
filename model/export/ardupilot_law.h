#pragma once

/// @file
/// The battery of ArduPilot's simulator SITL (libraries/SITL/SIM_Battery.cpp): a fixed table of
/// resting voltages, scaled; a resistance; a low-pass of 10 Hz. In every step of the simulator, all
/// in float,
///
///   remaining -= i dt/3600,  not below 0
///   v_rest = full * table(100 remaining/capacity)/4.173
///   v     += a (v_rest - R i - v),  a = dt/(dt + 1/(2 pi 10))
///
/// The float matters: at 1200 steps a second a step takes so little charge that it is rounded by
/// some per cent, which lets a constant current drain the battery a little too fast or too slowly.
/// Volts, amperes and ohms of the pack. Tests: tests/model/export/ardupilot_law_test.cc.

#include <vector>

#include "model/export/exported.h"

namespace lipoid {

struct ArduPilotBattery {
  double full_V = 0.0;          ///< maxVoltage, SIM_BATT_VOLTAGE
  double capacity_Ah = 0.0;     ///< battCapacityAh, > 0
  double resistance_Ohm = 0.0;  ///< refBatRes
};

inline constexpr double kArduPilotSteps_per_s = 1200.0;  ///< default of SIM_RATE_HZ

/// The resting voltage of one cell of the table when full, and at a percentage of capacity.
inline constexpr double kArduPilotFull_V = 4.173;
[[nodiscard]] double ArduPilotRestingVoltage(double percent);

/// The percentages of its rows, rising.
[[nodiscard]] std::vector<double> ArduPilotTablePercents();

/// The voltage of the pack in every row, as the simulator computes it in float at its own steps;
/// `drawn_Ah` is the charge that has left in every row (ChargeDrawn_Ah), of which the first one
/// counts here. The battery starts at rest.
[[nodiscard]] std::vector<double> ArduPilotVoltage(const ArduPilotBattery& battery,
                                                   const ExportMission& mission,
                                                   const std::vector<double>& drawn_Ah);

/// The same law in double with one step for each row: smooth in the three numbers, so that they can
/// be fitted.
[[nodiscard]] std::vector<double> ArduPilotVoltageSmooth(const ArduPilotBattery& battery,
                                                         const ExportMission& mission,
                                                         const std::vector<double>& drawn_Ah);

}  // namespace lipoid
