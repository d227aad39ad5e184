#pragma once

/// @file
/// PX4's battery. Nothing in PX4 simulates volts from a current; what the numbers of its estimator
/// mean as a law is
///
///   v_cell = V_E + (1 - q/C)(V_C - V_E) - R i,
///
/// i being the current of the pack. The estimator, in float, takes the cell's measured voltage and
/// the current, 100 times a second:
///
///   soc_v = (LP(v_cell + R i) - V_E)/(V_C - V_E) within 0 .. 1, LP a low-pass of 1 s
///   soc   = (1 - w) soc + w soc_v - dq/C,  w = 0.03 (1 - soc_v),  within 0 .. 1 - q/C
///
/// Tests: tests/model/export/laws_test.cc.

#include <vector>

#include "model/export/exported.h"

namespace lipoid {

struct Px4Battery {
  int cells = 1;                ///< BAT1_N_CELLS, in series
  double empty_V = 0.0;         ///< BAT1_V_EMPTY, of a cell, below charged_V
  double charged_V = 0.0;       ///< BAT1_V_CHARGED, of a cell
  double resistance_Ohm = 0.0;  ///< BAT1_R_INTERNAL, of a cell times the pack's current
  double capacity_mAh = 0.0;    ///< BAT1_CAPACITY, of the pack
};

inline constexpr double kPx4Updates_per_s = 100.0;
inline constexpr double kPx4LargestResistance_Ohm = 0.2;

/// The voltage of the pack in every row, by the law above. `drawn_Ah` as of ChargeDrawn_Ah().
[[nodiscard]] std::vector<double> Px4Voltage(const Px4Battery& battery,
                                             const ExportMission& mission,
                                             const std::vector<double>& drawn_Ah);

/// What the estimator shows in every row, given the pack's voltage there: a fraction. It starts
/// with what the voltage says, and with no charge counted.
[[nodiscard]] std::vector<double> Px4StateOfCharge(const Px4Battery& battery,
                                                   const ExportMission& mission,
                                                   const std::vector<double>& voltage_V);

}  // namespace lipoid
