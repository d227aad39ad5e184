#pragma once

/// @file
/// A flight as a series of a report, made while it flies. Memory does not grow with the flight.
/// Tests: tests/tools/flight_series_test.cc.
///
///   FlightSeries series;
///   const FlightResult flight = Fly(setup, plan, [&](const FlightSample& s) { series.Row(s); });
///   line.report_series().push_back(series.Take("flight.csv"));

#include <cstddef>
#include <string>
#include <vector>

#include "model/flight/flight_log.h"
#include "tools/report/report.h"

namespace lipoid {

/// What the series of all flights of a page may take together, as they stand in it: with three.js
/// and all else the page stays below 2 MB.
inline constexpr std::size_t kBytesOfFlights = 1'150'000;

class FlightSeries {
 public:
  /// Of a vehicle of so many rotors.
  explicit FlightSeries(std::size_t rotors = 4);

  void Row(const FlightSample& sample);

  /// Kind "flight", with the name of its flight log, where it has one. Columns are those of the
  /// flight log but for speeds, rates and the currents of single motors, which no chart shows. A
  /// flight of more than 65536 rows is thinned, as by Thinned(). Once.
  [[nodiscard]] Series Take(const std::string& name);

 private:
  void KeepExtremes(std::size_t stretch);

  std::vector<std::string> names_;  // of the columns of a flight log
  std::vector<std::size_t> shown_;  // of the columns of a flight log, those of the series
  std::vector<std::size_t> index_;  // of each row kept, which row of the flight it is
  std::vector<double> time_s_;
  std::vector<std::vector<float>> values_;  // by column
  std::size_t seen_ = 0;
  std::size_t stretch_ = 1;
};

/// The series with so few rows that it takes no more than `most_bytes` of a page: stretches of equal
/// duration keep the rows at which a column is least or largest, so that no peak is lost.
[[nodiscard]] Series Thinned(const Series& series, std::size_t most_bytes);

}  // namespace lipoid
