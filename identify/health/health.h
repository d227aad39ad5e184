#pragma once

/// @file
/// How old a pack is, by flights on it: its capacity and resistance now, each with an interval, per
/// flight and as a trend over flights, against what it was when new. docs/flight-logs.md says what
/// flights can tell and what not. Tests: tests/tools/health_test.cc,
/// tests/identify/health/coverage_test.cc.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "identify/health/flight_fit.h"
#include "identify/health/trend.h"
#include "identify/logs/log.h"
#include "model/battery/ranges.h"
#include "model/core/errors.h"
#include "model/core/options.h"
#include "model/core/special_values.h"

namespace lipoid {

struct HealthOptions {
  int series = 1;
  int parallel = 1;
  /// Of the new pack; none: the reference's times `parallel`, or, where that is a typical curve, what
  /// the autopilot was told.
  std::optional<double> capacity_Ah;
  std::optional<double> ambient_degC;
  SensorSpread sensors;

  /// Options of `lipoid health` and keywords of lipoid.health().
  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("capacity_Ah",
      self.capacity_Ah,
      Range{1e-3, 1e5},
      "capacity of the new pack in Ah; by default that of the cell file times the cells in parallel, "
      "or, of a shipped cell, what the autopilot was told");
    v("ambient_degC",
      self.ambient_degC,
      kAirTemperatures_degC,
      "temperature of the air in degC, from which the pack starts and warms, where a log has no "
      "temperature");
    v("current_scale_uncertainty",
      self.sensors.current_scale,
      Range{1e-4, 0.5},
      "standard deviation of true over shown current, before the flights: 0.06 of a sensor as it "
      "came, 0.01 of a calibrated one");
  }
};

struct FlightHealth {
  std::string file;
  std::size_t place = 0;  ///< among all flights, refused ones too
  double duration_s = 0.0;
  double charge_Ah = 0.0;  ///< as the log shows it
  WithInterval soc_start;
  WithInterval soc_end;
  WithInterval capacity_Ah;  ///< of the pack
  /// As this current sensor counts: what the error of its scale, the same in every flight, adds is
  /// not in it.
  WithInterval counted_capacity_Ah;
  /// Of the pack, at once, at the middle of the charge that the flight took; where the flight tells its
  /// temperature that at the reference's.
  WithInterval resistance_Ohm;
  double new_resistance_Ohm = kNaN;        ///< the reference's there; NaN: not known
  double reference_resistance_Ohm = kNaN;  ///< the same, of a typical reference, too
  WithInterval counted_resistance_Ohm;
  double log_capacity = 0.0;  ///< over the reference, as fitted, whether that is known or not
  double log_capacity_deviation = 0.0;  ///< of the counted ones, for a trend
  double log_resistance_deviation = 0.0;
  WithInterval current_scale;  ///< true over shown
  WithInterval current_offset_A;
  WithInterval lag_s;     ///< of the voltage after the current
  double window_s = 0.0;  ///< over which rows were averaged; 0: not
  double coherence = 0.0;
  double mean_error_percent = 0.0;
  double max_error_percent = 0.0;
  bool temperature_known = false;
  bool converged = false;  ///< the search for all of this
  /// Why the flight makes no sense against the reference; empty: it does. One that the reference does
  /// not describe has no quantity that is known.
  std::string doubted_because;
  /// An earlier flight that this one is a copy of; the trend counts them once. Empty: none.
  std::string same_rows_as;
  std::vector<std::string> cautions;
};

struct HealthReport {
  std::string reference;         ///< its name
  bool typical = false;          ///< the curve of a chemistry
  bool capacity_told = false;    ///< the capacity is what the autopilot was told
  double new_capacity_Ah = 0.0;  ///< NaN: nobody says it, and the reference is a typical curve
  /// By which the resistance of a flight whose temperature is known becomes that at the reference temperature.
  double activation_energy_J_per_mol = 0.0;
  double reference_degC = 0.0;
  bool temperature_assumed = false;  ///< the energy is a typical one
  std::vector<FlightHealth> flights;
  std::vector<Diagnostic> refused;  ///< flights that say nothing, beside others that do
  std::optional<HealthTrend> capacity_trend, resistance_trend;
};

/// Cells in series: `given`, else as the autopilots were told. OptionError where not every log says the
/// same.
[[nodiscard]] int SeriesOfPack(const std::vector<Log>& logs, std::optional<int> given);

/// Of the flights that tell the quantity, by their place among all. A copy of an earlier flight, and
/// one whose search did not converge, do not count. With `reference` each value counts as a share of what the reference
/// has there, and the line is through what the last of them would have had: a resistance is that after a time which is
/// another for another sampling, at another state of charge.
[[nodiscard]] std::optional<HealthTrend> TrendOf(std::span<const FlightHealth> flights,
                                                 WithInterval FlightHealth::*counted,
                                                 double FlightHealth::*deviation,
                                                 double FlightHealth::*reference = nullptr);

/// The logs are those of the pack. OptionError where the capacity is to be the one that the autopilots were
/// told, and they were told different ones. Flights that are too short or too idle to tell anything are
/// refused; LoadError where all of them are.
[[nodiscard]] HealthReport AssessHealth(const Cell& reference,
                                        std::vector<Log> logs,
                                        const HealthOptions& options);

}  // namespace lipoid
