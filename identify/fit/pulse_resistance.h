#pragma once

/// @file
/// The resistance that a pulse test would measure: from rest at a state of charge a current is
/// switched on, and after t seconds
///
///   R(t) = (v_b(0) - v_b(t))/i
///
/// with all that the cell does meanwhile: series resistance, branches, diffusion, the charge that is
/// taken. Often it is known where none of its parts is: what one of them lacks another one has. Tests:
/// tests/identify/fit/pulse_resistance_test.cc.

#include <optional>
#include <vector>

#include "identify/fit/linearized_fit.h"

namespace lipoid {

/// What is asked: half charge, which may stand elsewhere on the axis of the fit, the current, and
/// after how long.
struct PulseQuestion {
  double soc = 0.5;  ///< on the axis of the fit
  double current_A = 1.0;
  std::vector<double> after_s{1.0, 10.0, 30.0};
  std::optional<double> temperature_degC = {};  ///< of a cell that knows temperature
};

/// R(t) of a solution, in the order of after_s.
[[nodiscard]] std::vector<double> PulseResistancesOf(const JointSolution& solution,
                                                     const JointSetup& setup,
                                                     double typical_A,
                                                     const PulseQuestion& question);

/// The same as combinations of the parameters of a linearized fit, for TrustOptions::drawn.
[[nodiscard]] std::vector<NamedCombination> PulseResistancesIn(const LinearizedFit& fit,
                                                               const JointSolution& solution,
                                                               const JointSetup& setup,
                                                               double typical_A,
                                                               const PulseQuestion& question);

/// Sets the resistances of a report, with the intervals that it found for these combinations, which
/// are the last of what was drawn and leave it: no cell is drawn from them. `beside_Ohm` are standard
/// deviations that the fit does not know; empty: none.
void TakePulseResistances(const std::vector<double>& values_Ohm,
                          const PulseQuestion& question,
                          TrustReport& trust,
                          const std::vector<double>& beside_Ohm = {});

}  // namespace lipoid
