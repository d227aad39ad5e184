#pragma once

/// @file
/// What modes of the diffusion beyond M, which count by their steady value (4.46), do to a fit.
///
/// Where these modes are no faster than the rows, the voltage still moves where the model stands, and r_s and fast
/// branches stand in for it: a table of mOhm that is off by more than its noise. More modes at the same parameters say
/// by how much the predicted voltages move, and the fit follows (followed_move.h): an interval reaches as far. Tests:
/// tests/identify/fit/fast_modes_test.cc.

#include <functional>
#include <vector>

#include "identify/fit/followed_move.h"
#include "identify/fit/pulse_resistance.h"

namespace lipoid {

/// Adds the move to so many modes as the rows, and the pulse resistances, tell apart; none where M are enough, or the
/// modes beyond are none of the model (no tail). `rows_with`: those of the fit with another setup.
void AddFastModes(const LinearizedFit& fit,
                  const JointSolution& solution,
                  const JointSetup& setup,
                  double typical_A,
                  const PulseQuestion& question,
                  const std::function<std::vector<FittedRows>(const JointSetup& setup)>& rows_with,
                  FollowedMoves& moves);

}  // namespace lipoid
