#pragma once

/// @file
/// What a person may ask of a flight, declared once: the options of `lipoid fly` and the keywords of
/// lipoid.fly(). Tests: tests/tools/fly_test.cc, tests/python/test_options.py.

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>

#include "model/battery/aged_cell.h"
#include "model/battery/ranges.h"
#include "model/core/errors.h"
#include "model/core/option_kinds.h"
#include "model/core/options.h"
#include "model/flight/simulator.h"

namespace lipoid {

struct FlyRequest {
  FlightSetup setup = {};
  InputFile vehicle = {};
  InputFile gains = {};
  InputFile waypoints = {};
  std::optional<double> xi = {};
  std::optional<double> duration_s = {};
  std::optional<double> log_step_s = {};
  double payload_g = 0.0;
  std::optional<double> capacity_Ah = {};
  double health = 1.0;
  double resistance_factor = 1.0;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("vehicle",
      self.vehicle,
      Word{"VEHICLE"},
      "a vehicle file, or the name of a shipped vehicle; by default mambo-coupled on a cell and "
      "mambo-thesis on an ideal source");
    v("gains",
      self.gains,
      Word{"GAINS"},
      "unaware, aware, placed (by the lag of the vehicle's motors), or a gains file; by default "
      "aware for a Mambo and placed for any other vehicle or controller lqr");
    v("compensate",
      self.setup.controller.compensate,
      Names(),
      "turn commands into duty cycles by the measured voltage of the battery (5.52)");
    v("estimate",
      self.setup.estimate,
      Names(),
      "the controller sees noisy sensors through the estimator, not the true state");
    v("xi",
      self.xi,
      Range{0.01, 2.0},
      "voltage of an ideal source over the nominal one; by default they are the same");
    v("duration",
      self.duration_s,
      Range{kControlStep_s, 1e6},
      "duration of the flight, s; by default that of the maneuver");
    v("land_below_V",
      self.setup.land_below_V,
      Range{0.0, 1e4},
      "land when the battery has been below this voltage for a second, V; 0: never");
    v("log_step_s",
      self.log_step_s,
      Range{kControlStep_s, 1e4},
      "seconds between rows of the flight log, a multiple of the control step; by default every "
      "control step, and 0.1 s where the flight takes longer than ten minutes");
    v("waypoints",
      self.waypoints,
      Word{"FILE"},
      "file of the places that the maneuver waypoints visits (docs/formats.md)");
    v("ambient_degC",
      self.setup.ambient_degC,
      kAirTemperatures_degC,
      "temperature of the air in degC, from which the battery starts and warms; by default the "
      "reference temperature of the cell");
    v("payload_g",
      self.payload_g,
      Range{kPayloads_kg.lo / kGram_kg, kPayloads_kg.hi / kGram_kg},
      "mass in g that the vehicle carries besides its own, at its centre of mass");
    v("capacity_Ah",
      self.capacity_Ah,
      kCapacities_Ah,
      "nominal capacity of a cell of the pack, where it is a larger or a smaller one of the kind in "
      "the cell file: its charge, resistances and heat go with the size");
    v("health",
      self.health,
      kCapacityShares,
      "capacity left, as a share of that in the cell file or of --capacity-Ah");
    v("resistance_factor",
      self.resistance_factor,
      kResistanceFactors,
      "resistance of the aged cell over that in the cell file");
  }

  /// Whether the cell that flies is another one than that of the cell file.
  [[nodiscard]] bool ChangesCell() const {
    return capacity_Ah || health != 1.0 || resistance_factor != 1.0;
  }
  [[nodiscard]] double SizeFactor(const Cell& of_file) const {
    return capacity_Ah ? *capacity_Ah / of_file.capacity_Ah : 1.0;
  }
  /// The cell that flies, of that of the cell file or one drawn from its uncertainty.
  [[nodiscard]] Cell Aboard(const Cell& of_file) const {
    return Resized(Aged(of_file, health, resistance_factor), SizeFactor(of_file));
  }
  /// The vehicle with what it carries.
  [[nodiscard]] Vehicle Loaded(Vehicle empty) const {
    empty.mass_kg += kGram_kg * payload_g;
    return empty;
  }

  [[nodiscard]] std::string VehicleName() const {
    if (!vehicle.path.empty()) return vehicle.path;
    return setup.cell ? "mambo-coupled" : "mambo-thesis";
  }
  /// Between rows of the log of a flight that long. One of every control step takes 60 kB a second.
  /// OptionError for one that no whole number of control steps takes.
  [[nodiscard]] double LogStep_s(double duration_s_of_flight) const {
    constexpr double kLongFlight_s = 600.0;
    constexpr double kLongFlightLogStep_s = 0.1;  // `health` counts its charge; 4 kB a second
    constexpr double kWhole = 1e-6;  // steps; what is left of a decimal number divided by 0.005
    if (log_step_s) {
      const double steps = *log_step_s / kControlStep_s;
      if (std::abs(steps - std::round(steps)) > kWhole * steps) {
        throw OptionError(fmt::format(
            "option --log-step-s: expected a multiple of the control step of {} s, found {} s; give "
            "{:g} or {:g}",
            kControlStep_s,
            *log_step_s,
            kControlStep_s * std::floor(steps),
            kControlStep_s * std::ceil(steps)));
      }
    }
    return log_step_s.value_or(duration_s_of_flight > kLongFlight_s ? kLongFlightLogStep_s
                                                                    : kControlStep_s);
  }
};

}  // namespace lipoid
