#pragma once

/// @file
/// Between which temperatures a cell was seen, and what is extrapolated beyond them. An activation energy holds
/// where it was found: cells freeze, and another process may take over. Tests:
/// tests/model/battery/temperature_test.cc.

#include <string>

namespace lipoid {

struct Cell;

/// Of the logs from which a cell was identified.
struct TemperatureRange {
  double coldest_degC = 0.0;
  double warmest_degC = 0.0;

  friend bool operator==(const TemperatureRange&, const TemperatureRange&) = default;
};

/// So far beyond its range a cell is as well known as within.
inline constexpr double kNearRange_K = 5.0;

/// What is extrapolated where the cell is as cold and as warm as this, as a sentence. "": nothing, or
/// its file does not say between which temperatures it was seen.
[[nodiscard]] std::string DoubtAboutTemperature(const Cell& cell,
                                                double coldest_degC,
                                                double warmest_degC);

}  // namespace lipoid
