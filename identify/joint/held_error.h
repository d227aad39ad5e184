#pragma once

/// @file
/// What the error of an earlier cell does to a fit that holds its curve and rates (held_shape.h).
///
/// The earlier cell says how uncertain v_oc(A), its alpha, time constants and the other rates are (key `uncertainty` of
/// its file). The fit follows each principal move of these (followed_move.h): what was 1 % wrong when new is 1 % wrong
/// again, however well the new logs are described. The shape of the resistances is not counted: logs bend it. Tests:
/// tests/identify/joint/held_error_test.cc.

#include "identify/fit/followed_move.h"
#include "identify/fit/pulse_resistance.h"

namespace lipoid {

struct JointResult;

/// Adds its moves. There are none where nothing is held, or the cell that is does not say how uncertain it is.
void AddHeldError(const JointResult& result, const PulseQuestion& question, FollowedMoves& moves);

}  // namespace lipoid
