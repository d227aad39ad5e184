#pragma once

/// @file
/// The current of a flight without noise that its voltage does not follow.
///
/// A current that truly wavers takes the voltage with it: dv = -r di from row to row, after the lag of the
/// sensors. Where the voltage does not, the sensor's own noise is in the current, or the current of other
/// instants, and a fit that takes it for what the cell saw finds resistances that are too small and puts the
/// rest of the drop on the state of charge. What the cell saw is then taken to be a level that moves as a random
/// walk between jumps, below white noise (a local level model; Durbin and Koopman, Time Series Analysis by
/// State Space Methods, 2012, chapter 2). Tests: tests/identify/health/followed_current_test.cc.

#include <optional>

#include "identify/health/flight_samples.h"
#include "identify/logs/record.h"

namespace lipoid {

struct FollowedCurrent {
  Column current_A;      ///< the level, at each row
  double noise_A = 0.0;  ///< standard deviation of what was taken out
};

/// Of a flight whose windows are chosen. None where the voltage follows the noise, or would not show it, or too few
/// rows tell.
[[nodiscard]] std::optional<FollowedCurrent> TakeOutUnfollowed(const FlightSamples& flight);

}  // namespace lipoid
