#pragma once

/// @file
/// Several flights side by side: eight numbers where endurance.cc has one, so that the processor has
/// eight independent chains to work on and adds two numbers at once. Only what nothing happens in is
/// flown so: a block of steps in which a flight might end, or a formula of its curves might, is left
/// to endurance.cc, which goes on from its beginning. Tests: tests/model/flight/endurance_test.cc.

#include <span>
#include <vector>

#include "model/battery/cell_model.h"
#include "model/flight/endurance.h"

namespace lipoid {

/// Where a flight is that has not ended.
struct MissionState {
  CellModel<double>::State cell;
  double cell_A = 0.0;    ///< of one cell, in the last step
  double before_A = 0.0;  ///< of the pack, at the beginning of the last step
  std::size_t steps = 0;  ///< flown so far
  double charge_C = 0.0;
  double energy_J = 0.0;
  double minimum_voltage_V = 0.0;
  double peak_current_A = 0.0;
};

inline constexpr std::size_t kLanes = kMissionsAtOnce;

/// Whether this flight can be flown side by side: one endless leg without diodes, from a cell whose
/// drops are proportional to the current and whose curve consists of pieces.
[[nodiscard]] bool FitsLanes(const EnduranceSetup& setup);

/// Flies up to kLanes such flights until each is close to its end; their steps in s are given.
/// A flight depends on its own setup alone, not on those beside it.
[[nodiscard]] std::vector<MissionState> FlyLanes(std::span<const EnduranceSetup* const> setups,
                                                 std::span<const double> step_s);

}  // namespace lipoid
