#include "model/flight/flight_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "model/battery/curve_range.h"
#include "model/battery/temperature_range.h"
#include "model/control/laws/control_laws.h"
#include "model/core/counted.h"
#include "model/core/errors.h"
#include "model/flight/coupling.h"
#include "model/vehicle/allocation.h"

namespace lipoid {
namespace {

// Above the voltage at rest it would land before it took off.
void CheckLandingVoltage(const FlightSetup& setup) {
  const double full_V =
      setup.cell ? setup.cell->series * setup.cell->open_circuit_voltage(setup.initial_soc)
                 : setup.xi * setup.vehicle.nominal_voltage_V;
  if (setup.cell && setup.land_below_V > 0.0 && setup.land_below_V < full_V) {
    const int cells = setup.cell->series;
    const double empty_V = cells * setup.cell->cutoff_V;
    if (setup.land_below_V > empty_V) return;
    // Most likely the voltage of a cell.
    const double of_all_V = cells * setup.land_below_V;
    throw OptionError(fmt::format(
        "option --land-below-V: {:g} V is not above the {:g} V at which the pack of {} is empty and the "
        "flight ends; {}",
        setup.land_below_V,
        empty_V,
        Counted(static_cast<std::size_t>(cells), "cell"),
        of_all_V > empty_V && of_all_V < full_V
            ? fmt::format("{:g} V a cell are {:g} V", setup.land_below_V, of_all_V)
            : "give more"));
  }
  if (setup.land_below_V < full_V) return;
  if (setup.land_below_V == 0.0) {
    throw OptionError(fmt::format(
        "the battery is empty when it takes off: {:.4g} V at rest at a state of charge of "
        "{:.4g}; start higher (--initial-soc, --initial-voltage-V)",
        full_V,
        setup.initial_soc));
  }
  throw OptionError(fmt::format(
      "option --land-below-V: {:g} V is not below the {:.4g} V that the battery has at rest when it "
      "takes off; give less",
      setup.land_below_V,
      full_V));
}

// What a drawing of the vehicle needs: where the motors are, ahead and to the right of the centre of
// mass, and which way they turn seen from above.
Json Geometry(const Vehicle& vehicle) {
  Json motors = Json::array();
  for (const Rotor& rotor : RotorsOf(vehicle.layout)) {
    const bool clockwise =
        (vehicle.front_right_turns == Turning::kClockwise) == (rotor.turning > 0.0);
    motors.push_back(
        {{"ahead_m", vehicle.arm_m * rotor.ahead},
         {"right_m", vehicle.arm_m * rotor.right},
         {"turns",
          options_internal::ToText(clockwise ? Turning::kClockwise : Turning::kCounterClockwise)}});
  }
  return {{"arm_m", vehicle.arm_m}, {"motors", std::move(motors)}};
}

// That a flight never had the speed that its references may have, and why; "": it had.
std::string DoubtAboutSpeed(const FlightSetup& setup,
                            const FlightPlan& plan,
                            const FlightResult& flight) {
  constexpr double kReached = 0.95;  // references come to their speed as an exponential does
  const ControllerOptions options = FlownController(setup);
  const double most = ReferencesOf(setup.gains.references, options).speed_m_per_s;
  if (plan.arrivals_s.empty() || !(flight.fastest_m_per_s < kReached * most)) return "";
  if (flight.fastest_reference_m_per_s >= kReached * most) {
    return fmt::format(
        "the vehicle flew at most {:.3g} m/s along x or y, where its references had {:.3g} m/s: a tilt of {:.3g} "
        "degrees holds no more against the air. Give less speed (--set controller.position_speed_m_per_s), or "
        "gains with a larger tilt_limit_rad",
        flight.fastest_m_per_s,
        flight.fastest_reference_m_per_s,
        setup.gains.position.tilt_limit_rad * 180.0 / std::numbers::pi);
  }
  if (options.position_speed_m_per_s == 0.0) return "";  // nobody asked for it
  return fmt::format(
      "the vehicle flew at most {:.3g} m/s along x or y of the {:.3g} m/s that position_speed_m_per_s allows: no way "
      "between waypoints is long enough to gain more with a tilt of {:.3g} degrees, half of which is for errors",
      flight.fastest_m_per_s,
      most,
      setup.gains.position.tilt_limit_rad * 180.0 / std::numbers::pi);
}

// That the air carried the vehicle off its place; "": it did not. How far a waypoint was missed is said of each, and an
// estimated position drifts by itself.
std::string DoubtAboutPlace(const FlightSetup& setup,
                            const FlightPlan& plan,
                            const FlightResult& flight) {
  if (!plan.arrivals_s.empty() || setup.estimate || !Blows(setup.wind)) return "";
  if (!(flight.largest_position_error_m > kAtPlace_m)) return "";
  return fmt::format(
      "the air carried the vehicle up to {:.3g} m from its place: the position loop has no integral, and leans against "
      "a steady wind only as far as it is off; larger position gains hold it closer",
      flight.largest_position_error_m);
}

}  // namespace

Json FlightToJson(const FlightResult& flight) {
  Json trim = {
      {"possible", flight.trim.possible()},
      {"speed_rad_per_s", flight.trim.speed_rad_per_s},
      {"duty", flight.trim.duty},
      {"battery_V", flight.trim.battery_V},
      {"battery_A", flight.trim.power_suffices ? Json(flight.trim.battery_A) : Json(nullptr)}};
  Json summary = {{"outcome", options_internal::ToText(flight.outcome)},
                  {"reason", flight.reason},
                  {"trim", std::move(trim)},
                  {"steps", flight.steps},
                  {"simulated_s", flight.simulated_s},
                  {"wall_s", flight.wall_s},
                  {"peak_altitude_error_m", flight.peak_altitude_error_m},
                  {"mse_altitude_m2", NumberOrNull(flight.mse_altitude_m2)},
                  {"mse_pitch_deg2", NumberOrNull(flight.mse_pitch_deg2)},
                  {"mse_position_m2", NumberOrNull(flight.mse_position_m2)},
                  {"largest_position_error_m", NumberOrNull(flight.largest_position_error_m)},
                  {"fastest_m_per_s", NumberOrNull(flight.fastest_m_per_s)},
                  {"waypoint_distance_m", flight.waypoint_distance_m},
                  {"waypoint_heading_error_rad", flight.waypoint_heading_error_rad},
                  {"charge_C", NumberOrNull(flight.charge_C)},
                  {"final_voltage_V", NumberOrNull(flight.final_voltage_V)},
                  {"final_soc", NumberOrNull(flight.final_soc)},
                  {"remaining_soc", NumberOrNull(flight.rest_soc)},
                  {"minimum_voltage_V", NumberOrNull(flight.minimum_voltage_V)},
                  {"saturated_share", flight.saturated_share}};
  if (std::isfinite(flight.final_temperature_degC))
    summary["final_temperature_degC"] = flight.final_temperature_degC;
  if (flight.landed_s) summary["landed_s"] = *flight.landed_s;
  return summary;
}

Json FlownToJson(const FlightSetup& setup,
                 const Maneuver& maneuver,
                 const ManeuverRequest& request) {
  Json json = {{"maneuver", maneuver.name}, {"maneuver_options", Json::object()}};
  if (maneuver.values != nullptr) {
    for (const auto& [name, value] : maneuver.values(request))
      json["maneuver_options"][name] = value;
  }
  json["vehicle"] = setup.vehicle.name;
  json["mass_kg"] = setup.vehicle.mass_kg;
  json["capacity_Ah"] = setup.cell ? Json(setup.cell->capacity_Ah) : Json(nullptr);
  json["battery"] = setup.cell ? setup.cell->name : fmt::format("ideal source, xi = {}", setup.xi);
  json["gains"] = setup.gains.name;
  json["controller"] = setup.controller.law;
  json["compensate"] = setup.controller.compensate;
  json["estimate"] = setup.estimate;
  json["cutoff_V"] = setup.cell ? Json(setup.cell->series * setup.cell->cutoff_V) : Json(nullptr);
  json["vehicle_geometry"] = Geometry(setup.vehicle);
  return json;
}

Json FlightsToJson(std::span<const FlightResult> flights) {
  Json intervals = Json::object();
  for (const FlightNumber& number : kFlightNumbers) {
    const auto [low, high] = IntervalOf(flights, number.of);
    intervals[std::string(number.key)] = {NumberOrNull(low), NumberOrNull(high)};
  }
  return {{"completed", CountOf(flights, Outcome::kCompleted)},
          {"crashed", CountOf(flights, Outcome::kCrashed)},
          {"battery_empty", CountOf(flights, Outcome::kBatteryEmpty)},
          {"off_course", CountOf(flights, Outcome::kOffCourse)},
          {"interval_95", std::move(intervals)}};
}

std::vector<std::string> FlightDoubts(const FlightSetup& setup,
                                      const FlightPlan& plan,
                                      const FlightResult& flight) {
  std::vector<std::string> doubts;
  if (!flight.trim.possible()) {
    doubts.push_back(fmt::format(
        "{} cannot hover on this battery: {}",
        setup.vehicle.name,
        flight.trim.power_suffices ? fmt::format("it would need a duty cycle of {:.4g} at {:.3f} V",
                                                 flight.trim.duty,
                                                 flight.trim.battery_V)
                                   : std::string("it never gives the power")));
  }
  if (setup.cell) {
    if (setup.ambient_degC)
      doubts.push_back(
          DoubtAboutTemperature(*setup.cell, *setup.ambient_degC, *setup.ambient_degC));
    doubts.push_back(DoubtAboutCurve(*setup.cell, flight.final_soc, setup.initial_soc));
  }
  doubts.push_back(DoubtAboutSpeed(setup, plan, flight));
  doubts.push_back(DoubtAboutPlace(setup, plan, flight));
  const std::size_t asked = plan.arrivals_s.size();
  const std::size_t reached = flight.waypoint_distance_m.size();
  if (flight.outcome == Outcome::kCompleted && reached < asked) {
    doubts.push_back(fmt::format(
        "the flight ended after {:.4g} s, before the stays at {} of {} ended: nothing is said of these. The last "
        "stay ends after {:.4g} s; give a longer --duration",
        flight.simulated_s,
        asked - reached,
        Counted(asked, "waypoint"),
        plan.arrivals_s.back()));
  }
  std::erase(doubts, "");
  return doubts;
}

void CheckFlight(const FlightSetup& setup,
                 const Maneuver& maneuver,
                 const ManeuverRequest& request,
                 bool has_duration) {
  if (maneuver.needs_file != !request.waypoints_file.empty()) {
    throw OptionError(maneuver.needs_file
                          ? "maneuver waypoints needs a file of places: --waypoints FILE"
                          : fmt::format("option --waypoints is for the maneuver waypoints, not {}",
                                        maneuver.name));
  }
  CheckLandingVoltage(setup);
  (void)FindControlLaw(setup.controller.law);
  if (maneuver.until_empty && !setup.cell && !has_duration) {
    throw OptionError(
        fmt::format("maneuver {} ends with an empty battery, and an ideal source is never empty: "
                    "give --duration",
                    maneuver.name));
  }
}

}  // namespace lipoid
