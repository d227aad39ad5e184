#pragma once

/// @file
/// A flight as a series of a report, made while it flies. Memory does not grow with the flight.
/// Tests: tests/tools/flight_series_test.cc.
///
///   FlightSeries series(rotors, warms);
///   const FlightResult flight = Fly(setup, plan, [&](const FlightSample& s) { series.Row(s); });
///   line.report_series().push_back(series.Take("flight.csv"));

#include <cstddef>
#include <string>
#include <vector>

#include "model/flight/flight_log.h"
#include "tools/report/report.h"

namespace lipoid {

/// Whether charts show this column of a flight log: not speeds, rates and currents of single motors.
[[nodiscard]] bool IsShownOfFlight(const std::string& column);

class FlightSeries {
 public:
  /// With the columns of FlightSample::OfRotors().
  FlightSeries(std::size_t rotors, bool warms);

  void Row(const FlightSample& sample);

  /// Kind "flight", with the name of its flight log, where it has one, and the columns of it that
  /// charts show. A flight of more than 65536 rows is thinned, as by Thinned(). Once.
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

}  // namespace lipoid
