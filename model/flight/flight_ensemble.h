#pragma once

/// @file
/// The same flight on many cells, drawn from the uncertainty of one: how far its outcome is known.
/// Tests: tests/model/flight/flight_ensemble_test.cc.

#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "model/flight/simulator.h"

namespace lipoid {

/// Flies the plan once on each cell, on all cores. Gusts and the noise of the sensors are the same
/// in each flight, so that only the cells make a difference. Progress gets the share done, from any
/// thread.
[[nodiscard]] std::vector<FlightResult> FlyOnEach(const FlightSetup& setup,
                                                  const FlightPlan& plan,
                                                  std::span<const Cell> cells,
                                                  std::span<const double> initial_soc,
                                                  const FlightProgress& progress = {});

[[nodiscard]] int CountOf(std::span<const FlightResult> flights, Outcome outcome);

/// A number that each flight has, its interval over all of those in which it is finite.
[[nodiscard]] std::pair<double, double> IntervalOf(std::span<const FlightResult> flights,
                                                   double FlightResult::*number);

}  // namespace lipoid
