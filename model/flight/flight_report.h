#pragma once

/// @file
/// What came out of a flight, as JSON: `lipoid fly --summary` (docs/formats.md), and the checks of a
/// setup that commands and other languages share. Tests: tests/tools/fly_test.cc.

#include <span>
#include <string>
#include <vector>

#include "model/core/json.h"
#include "model/flight/flight_ensemble.h"
#include "model/flight/maneuvers/maneuvers.h"
#include "model/flight/simulator.h"

namespace lipoid {

[[nodiscard]] Json FlightToJson(const FlightResult& flight);

/// What was flown: maneuver, its options, vehicle, battery, gains.
[[nodiscard]] Json FlownToJson(const FlightSetup& setup,
                               const Maneuver& maneuver,
                               const ManeuverRequest& request);

/// A number of a flight of which an ensemble gives intervals.
struct FlightNumber {
  std::string_view key;
  std::string_view what;
  double FlightResult::*of;
};
inline constexpr FlightNumber kFlightNumbers[] = {
    {"final_soc", "soc at the end, available under load", &FlightResult::final_soc},
    {"remaining_soc", "share of the charge left", &FlightResult::rest_soc},
    {"minimum_voltage_V", "lowest voltage / V", &FlightResult::minimum_voltage_V},
    {"simulated_s", "flown / s", &FlightResult::simulated_s},
    {"mse_altitude_m2", "mean square altitude error / m^2", &FlightResult::mse_altitude_m2},
    {"charge_C", "charge / C", &FlightResult::charge_C}};

[[nodiscard]] Json FlightsToJson(std::span<const FlightResult> flights);

/// What is to be doubted of a flight, a sentence each: that the vehicle cannot hover on this battery; that it was extrapolated beyond what its
/// logs showed, in temperature or in charge; that a flight of waypoints never had the speed that its
/// references may have, and why: no leg is long enough for a speed that was asked for, or the tilt does not hold it against the air.
[[nodiscard]] std::vector<std::string> FlightDoubts(const FlightSetup& setup,
                                                    const FlightPlan& plan,
                                                    const FlightResult& flight);

/// OptionError where the setup and the maneuver do not go together: a landing voltage above that of
/// rest, an unknown control law, an endless flight on an ideal source, a file of waypoints that is
/// missing or not wanted.
void CheckFlight(const FlightSetup& setup,
                 const Maneuver& maneuver,
                 const ManeuverRequest& request,
                 bool has_duration);

}  // namespace lipoid
