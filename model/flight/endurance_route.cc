#include "model/flight/endurance_route.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/battery/aged_cell.h"
#include "model/core/errors.h"
#include "model/flight/maneuvers/maneuvers.h"
#include "model/flight/simulator.h"

namespace lipoid {

PowerMission FlyRoute(const EnduranceRequest& request,
                      const Gains& gains,
                      const std::string& waypoints_file) {
  FlightSetup setup;
  setup.vehicle = request.vehicle;
  setup.vehicle.mass_kg += request.payload_kg.value;
  setup.cell = Resized(Aged(request.cell, request.health.value, request.resistance_factor.value),
                       request.size_factor);
  setup.initial_soc = request.initial_voltage_V
                          ? request.cell.open_circuit_voltage.SocAtVoltage(
                                *request.initial_voltage_V / request.cell.series)
                          : request.initial_soc;
  if (request.ambient_degC) setup.ambient_degC = request.ambient_degC->value;
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
  return mission;
}

}  // namespace lipoid
