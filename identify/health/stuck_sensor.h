#pragma once

/// @file
/// A sensor that shows one value while what it measures moves: a voltage that is no longer sent anew, a current that
/// is not, or one beyond the end of its sensor's range. The other of the two tells: the resistance that their changes
/// show elsewhere says by how much a voltage should have moved, and how much a current must have. Tests:
/// tests/identify/health/stuck_sensor_test.cc.

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "identify/health/flight_samples.h"

namespace lipoid {

/// Stretches of rows, first to last, over which the voltage stands still for at least 10 s and 20 of its updates, or
/// for 2 s and 5 updates at its largest or least value, where a sensor may be at the end of its range, although the
/// current, by the resistance that the flight shows, moves it by three of its least steps from window to window. For a
/// flight whose windows are chosen; none where voltage and current hardly follow one another.
[[nodiscard]] std::vector<std::pair<std::size_t, std::size_t>> FindStuckVoltage(
    const FlightSamples& flight);

/// In a sentence, that the current comes back again and again to one largest value and stays there, or shows one value
/// for at least ten of its updates, while the voltage goes on moving as under a current that changes. "" where it does
/// not, as while a cell recovers after the landing, or nothing tells: values of a coarse sensor repeat anyway.
[[nodiscard]] std::string DoubtAboutStuckCurrent(const FlightSamples& flight);

}  // namespace lipoid
