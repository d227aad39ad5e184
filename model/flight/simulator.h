#pragma once

/// @file
/// The coupled simulator: controller every 5 ms, plant by fixed steps of Runge-Kutta of fourth
/// order between, the cell by its exact step under each step's mean current.
///
///   FlightSetup setup{.vehicle = LoadVehicle("mambo-coupled"), .cell = LoadCell("gifi-600mAh-1"),
///                     .gains = LoadGains("aware")};
///   const FlightResult flight = Fly(setup, FindManeuver("altitude-steps").plan({}));
///
/// Flight is deterministic: the same setup and seed give the same bits. Tests:
/// tests/model/flight/simulator_test.cc.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "model/battery/cell.h"
#include "model/control/estimator.h"
#include "model/control/flight_controller.h"
#include "model/flight/flight_code.h"
#include "model/flight/flight_log.h"
#include "model/flight/flight_plan.h"
#include "model/flight/trim.h"
#include "model/vehicle/plant.h"
#include "model/vehicle/sensors.h"
#include "model/vehicle/wind.h"

namespace lipoid {

enum class Integrator { kRk4, kDormandPrince };

constexpr std::array<std::pair<Integrator, std::string_view>, 2> OptionNames(Integrator) {
  return {{{Integrator::kRk4, "rk4"}, {Integrator::kDormandPrince, "dormand-prince"}}};
}

inline constexpr int kMostSubsteps = 10000;

struct SimulationOptions {
  Integrator integrator = Integrator::kRk4;
  int substeps = 1;
  double tolerance = 1e-9;
  bool motor_lag = true;
  bool ground = true;
  bool drag = false;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("integrator",
      self.integrator,
      Names(),
      "integrator of the plant: fixed steps (rk4), or adaptive steps as a check of them "
      "(dormand-prince)");
    v("substeps",
      self.substeps,
      Range{1, kMostSubsteps},
      "number of steps of the plant and of the cell in a control step of 5 ms");
    v("tolerance",
      self.tolerance,
      Range{1e-14, 1e-2},
      "absolute and relative tolerance of dormand-prince");
    v("motor_lag",
      self.motor_lag,
      Names(),
      "whether motors take time to change their speed; if false they are at their equilibrium "
      "(5.10), for an ideal source only");
    v("ground", self.ground, Names(), "whether there is a ground at zero height");
    v("drag", self.drag, Names(), "whether the vehicle's linear drag against the air acts");
  }
};

struct FlightSetup {
  Vehicle vehicle;
  std::optional<Cell> cell;  ///< none: an ideal source of xi v_b0
  double xi = 1.0;
  double initial_soc = 1.0;
  std::optional<double> ambient_degC;  ///< none: the reference temperature of the cell
  Gains gains;
  ControllerOptions controller;
  SimulationOptions simulation;
  bool estimate = false;  ///< the controller sees sensors and estimator, not the true state
  SensorOptions sensors;
  EstimatorOptions estimator;
  WindOptions wind;
  std::uint64_t seed = 0;  ///< of gusts and of the sensors' noise
  /// Of the pack: lands when the battery has been below it for a second.
  double land_below_V = 0.0;
  /// Flies instead of lipoid's controller and estimator; outlives the flight, one at a time.
  FlightCode* flight_code = nullptr;

  [[nodiscard]] bool Warms() const { return cell && cell->temperature; }
};

/// OptionError where a flight cannot start at this state of charge: empty, or far beyond full.
void CheckStart(double initial_soc);

/// The controller's options as they are flown. By sensors the attitude's reference is no faster than
/// the motors, where no frequency is given: the noise of the optical flow becomes tilts, and motors
/// that cannot follow turn what is asked of them into errors that swing a weak attitude loop up. A
/// flight of code that was exported has that code's own frequencies.
[[nodiscard]] ControllerOptions FlownController(const FlightSetup& setup);

/// A vehicle is at a place within it.
inline constexpr double kAtPlace_m = 1.0;

/// Off course: it flew to the end, but could not hold its place or missed a waypoint.
enum class Outcome { kCompleted, kCrashed, kBatteryEmpty, kOffCourse };

constexpr std::array<std::pair<Outcome, std::string_view>, 4> OptionNames(Outcome) {
  return {{{Outcome::kCompleted, "completed"},
           {Outcome::kCrashed, "crashed"},
           {Outcome::kBatteryEmpty, "battery-empty"},
           {Outcome::kOffCourse, "off-course"}}};
}

struct FlightResult {
  Outcome outcome = Outcome::kCompleted;
  std::string reason;  ///< why it ended, for people
  Trim trim;           ///< what it started from
  std::size_t steps = 0;
  double simulated_s = 0.0;
  double wall_s = 0.0;  ///< the loop alone
  /// Per altitude step: the most that the reference was above the altitude in the 5 s after it.
  std::vector<double> peak_altitude_error_m;
  double mse_altitude_m2 = 0.0;
  double mse_pitch_deg2 = 0.0;
  /// Horizontal, from the reference of the place; NaN where the maneuver commands angles alone.
  double mse_position_m2 = std::numeric_limits<double>::quiet_NaN();
  double largest_position_error_m = std::numeric_limits<double>::quiet_NaN();
  /// Along x or y, of the vehicle and of the reference of its place; NaN as above.
  double fastest_m_per_s = std::numeric_limits<double>::quiet_NaN();
  double fastest_reference_m_per_s = std::numeric_limits<double>::quiet_NaN();
  /// Of each waypoint whose stay was flown: how far the vehicle was from it at the end of the stay.
  std::vector<double> waypoint_distance_m;
  /// And how far its heading was from the commanded one, 0 to pi.
  std::vector<double> waypoint_heading_error_rad;
  double charge_C = 0.0;
  double final_voltage_V = 0.0;
  double minimum_voltage_V = 0.0;
  double final_soc = 1.0;  ///< A, available under load; NaN with an ideal source
  double rest_soc = 1.0;   ///< share of the charge that is left; NaN with an ideal source
  /// Of the cell; NaN where it knows no temperature.
  double final_temperature_degC = std::numeric_limits<double>::quiet_NaN();
  std::optional<double> landed_s;
  double saturated_share = 0.0;  ///< of the control steps, in which a motor was at its limit
};

using FlightRecorder = std::function<void(const FlightSample&)>;
using FlightProgress = std::function<void(double fraction)>;

/// Flies the plan. OptionError where the setup cannot be simulated: motors without lag on a cell,
/// an empty cell, drag without a coefficient.
[[nodiscard]] FlightResult Fly(const FlightSetup& setup,
                               const FlightPlan& plan,
                               const FlightRecorder& record = {},
                               const FlightProgress& progress = {});

}  // namespace lipoid
