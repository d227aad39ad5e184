#include "model/analysis/before_flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/analysis/placed_gains.h"
#include "model/vehicle/vehicle_file.h"

namespace lipoid {

std::vector<std::string> WarningsBeforeFlight(const FlightSetup& setup,
                                              const Maneuver& maneuver,
                                              const FlightPlan& plan,
                                              std::span<const HoverStability> hovers) {
  std::vector<std::string> warnings;
  constexpr double kFelt_m_per_s = 1.0;  // at which the hover of an F450 takes half a per cent less
  if (std::hypot(setup.wind.wind_x_m_per_s, setup.wind.wind_y_m_per_s) >= kFelt_m_per_s) {
    warnings.emplace_back(
        "the rotors are taken to need the power of still air, whatever passes them: lipoid endurance "
        "--airspeed-m-per-s counts what an airflow saves and costs");
  }
  constexpr double kFelt_m = 10.0;
  if (const double up_m = plan.Climb_m(); up_m >= kFelt_m) {
    warnings.push_back(fmt::format(
        "a climb costs no more than a hover here: the {:.4g} m up of this flight take {:.3g} Wh more of the "
        "battery at least",
        up_m,
        setup.vehicle.mass_kg * kGravity_m_per_s2 * up_m / 3600.0));
  }
  if (maneuver.changes && plan.commands.size() == 1) {
    warnings.push_back(fmt::format(
        "{}: nothing is asked for within {:g} s; give a longer --duration, or earlier times (--set {}.*)",
        maneuver.name,
        plan.duration_s,
        maneuver.name));
  }
  if (setup.cell) {
    warnings.push_back(DoubtAboutPack(setup.vehicle, setup.cell->series));
    warnings.push_back(DoubtAboutEnergy(setup.vehicle, *setup.cell));
  }
  for (std::string& warning : StabilityWarnings(hovers)) warnings.push_back(std::move(warning));
  if (!std::all_of(hovers.begin(), hovers.end(), [](const auto& at) { return at.stable(); })) {
    warnings.emplace_back(setup.gains.name == kPlacedGains
                              ? "gains that keep it stable may be found by lipoid design"
                              : kPlacedGainsHint);
  }
  std::erase(warnings, "");
  return warnings;
}

}  // namespace lipoid
