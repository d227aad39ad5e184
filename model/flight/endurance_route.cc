#include "model/flight/endurance_route.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/battery/aged_cell.h"
#include "model/core/errors.h"
#include "model/flight/maneuvers/maneuvers.h"
#include "model/flight/simulator.h"

namespace lipoid {
namespace {

// At which the linear drag is the pull of this tilt; infinite where the file has no drag.
double SpeedHeldAgainstDrag(const Vehicle& vehicle, double tilt_rad) {
  return vehicle.mass_kg * kGravity_m_per_s2 * std::tan(tilt_rad) / vehicle.linear_drag_N_s_per_m;
}

}  // namespace

PowerMission FlyRoute(const EnduranceRequest& request,
                      const Gains& gains,
                      const std::string& waypoints_file) {
  FlightSetup setup;
  setup.vehicle = request.vehicle;
  setup.vehicle.mass_kg += request.payload_kg.value;
  setup.cell = Resized(Aged(request.cell, request.health.value, request.resistance_factor.value),
                       request.size_factor);
  if (request.ambient_degC) setup.ambient_degC = request.ambient_degC->value;
  setup.initial_soc = StartOf(request, request.cell, {.ambient_degC = setup.ambient_degC});
  setup.gains = gains;
  setup.controller.compensate = true;
  const FlightPlan plan = FindManeuver("waypoints").plan({.waypoints_file = waypoints_file});
  PowerMission mission;
  const FlightResult flight = Fly(setup, plan, [&mission](const FlightSample& sample) {
    const double duty = *std::max_element(sample.duty.begin(), sample.duty.end());
    mission.legs.push_back({.duration_s = kControlStep_s,
                            .power_W = sample.battery_V * sample.battery_A,
                            .least_V = duty < 1.0 ? duty * sample.battery_V : 0.0,
                            .ground_speed_m_per_s = std::hypot(sample.velocity_m_per_s[0],
                                                               sample.velocity_m_per_s[1])});
  });
  if (flight.outcome == Outcome::kCrashed || flight.outcome == Outcome::kOffCourse) {
    throw OptionError(fmt::format(
        "{} {} the route of {}: {}. See how with `lipoid fly "
        "waypoints --waypoints {} --compensate` and the same --vehicle, --cell and pack "
        "(the duty cycles follow the voltage here), or give other --gains",
        request.vehicle.name,
        flight.outcome == Outcome::kCrashed ? "crashes on" : "does not fly",
        waypoints_file,
        flight.reason,
        waypoints_file));
  }
  const FlightCommand& first = plan.commands.front().command;
  const FlightCommand& last = plan.commands.back().command;
  mission.way_back_m =
      std::hypot(last.x_m - first.x_m, last.y_m - first.y_m, last.altitude_m - first.altitude_m);
  mission.doubts.emplace_back(
      "the route is flown with duty cycles that follow the voltage (`lipoid fly waypoints --compensate`), "
      "without the drag of the air, and a climb costs no more than a hover: a fast or a high route "
      "takes more than this says (the mission cruise knows the power of a speed)");
  const double tilt_rad = gains.position.tilt_limit_rad;
  const double held_m_per_s = SpeedHeldAgainstDrag(setup.vehicle, tilt_rad);
  if (flight.fastest_m_per_s > held_m_per_s) {
    mission.doubts.push_back(fmt::format(
        "the route is flown at up to {:.3g} m/s along x or y, and against the drag of {} its tilt of {:.3g} degrees "
        "holds {:.3g} m/s: in the air it takes longer than this says. Give gains of less speed_m_per_s or a larger "
        "tilt_limit_rad",
        flight.fastest_m_per_s,
        request.vehicle.name,
        tilt_rad * 180.0 / std::numbers::pi,
        held_m_per_s));
  }
  return mission;
}

}  // namespace lipoid
