#pragma once

/// @file
/// What is to be known before a flight. Tests: tests/tools/fly_test.cc, tests/python/test_flight.py.

#include <span>
#include <string>
#include <vector>

#include "model/analysis/stability.h"
#include "model/flight/maneuvers/maneuvers.h"
#include "model/flight/simulator.h"

namespace lipoid {

/// A sentence each: what of wind and climb the model leaves out, a duration in which nothing is asked for, a pack that
/// is not the vehicle's or heavier than it, loops that are unstable or ring, and what may help. `hovers` are those of
/// CheckFlightLoops().
[[nodiscard]] std::vector<std::string> WarningsBeforeFlight(const FlightSetup& setup,
                                                            const Maneuver& maneuver,
                                                            const FlightPlan& plan,
                                                            std::span<const HoverStability> hovers);

}  // namespace lipoid
