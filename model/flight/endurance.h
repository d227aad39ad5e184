#pragma once

/// @file
/// How long a battery carries a mission that is known by the power it takes: hover, cruise, or a
/// recorded power. The vehicle is in equilibrium at every instant, so that no controller and no
/// rigid body takes part; `Fly` (simulator.h) has those.
///
///   i v_b = P,   v_b = E - R i     so   v_b = (E + sqrt(E² - 4 R P))/2
///
/// E and R are the cell as a voltage behind a resistance (battery_supply.h). Over a step the current
/// is held that the middle of it will have, as it goes on changing as in the step before: of second
/// order in the step. The cell then takes the step exactly.
///
/// The mission ends as soon as the share of the charge that is left is down to the reserve, or when
/// for a second the battery is below its cut-off, too low for the motors, or without the power, or
/// when A reaches 0; A that reaches 0 under a power that no current gives is the power's doing.
/// Tests: tests/model/flight/endurance_test.cc.

#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/battery/cell.h"
#include "model/core/options.h"

namespace lipoid {

/// A part of a mission, over which the load is constant. What it takes from a battery of voltage v:
///
///   P(v) = power_W + drive_W v/(v + diode_V) + switched_A v
///
/// the last two by speed controllers with diodes and with switching losses (powertrain.h).
struct MissionLeg {
  /// Infinite: it never ends by itself.
  double duration_s = std::numeric_limits<double>::infinity();
  double power_W = 0.0;  ///< negative: the battery takes it
  double drive_W = 0.0;
  double diode_V = 0.0;     ///< >= 0
  double switched_A = 0.0;  ///< >= 0
  double least_V = 0.0;     ///< battery voltage of a duty cycle of 1: below it motors are too slow
  double ground_speed_m_per_s = 0.0;
};

struct PowerMission {
  std::vector<MissionLeg> legs;  ///< at least one, each longer than 0
  bool repeats = true;           ///< from the last leg it goes on with the first
  /// Of a route: from its end to its beginning, which repeating it leaves out.
  double way_back_m = 0.0;
  std::vector<std::string> doubts = {};  ///< sentences: what its powers leave out
};

enum class MissionEnd {
  kReserve,
  kCutOff,
  kEmpty,
  kMotorVoltage,
  kPower,
  kMissionDone,
  kFull,
  kTimeLimit
};

constexpr std::array<std::pair<MissionEnd, std::string_view>, 8> OptionNames(MissionEnd) {
  return {{{MissionEnd::kReserve, "reserve"},
           {MissionEnd::kCutOff, "cut-off"},
           {MissionEnd::kEmpty, "empty"},
           {MissionEnd::kMotorVoltage, "motor-voltage"},
           {MissionEnd::kPower, "power"},
           {MissionEnd::kMissionDone, "mission-done"},
           {MissionEnd::kFull, "full"},
           {MissionEnd::kTimeLimit, "time-limit"}}};
}

struct EnduranceOptions {
  double step_s = 0.0;
  double longest_s = 1e6;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("step_s",
      self.step_s,
      Range{0.0, 10.0},
      "longest step of the cell in s, over which its current is held; 0: a 50,000th of the time that "
      "the charge would last, at least 0.005 s");
    v("longest_s",
      self.longest_s,
      Range{1.0, 1e8},
      "flight time in s at which the calculation ends if the battery lasts longer");
  }
};

struct EnduranceSetup {
  Cell cell;
  double initial_soc = 1.0;
  std::optional<double> ambient_degC;  ///< none: the reference temperature of the cell
  double reserve = 0.0;                ///< share of the charge of a full battery that must be left
  PowerMission mission;
  EnduranceOptions options;
};

/// A time from which on no current of the battery gives the power of the mission.
struct PowerLack {
  double since_s = 0.0;
  double power_W = 0.0;  ///< of the mission
  double most_W = 0.0;   ///< that the battery gives
};

struct EnduranceResult {
  MissionEnd ended_by = MissionEnd::kTimeLimit;
  double time_s = 0.0;
  double charge_C = 0.0;
  double energy_J = 0.0;
  double landing_voltage_V = 0.0;       ///< of the pack at the end, under the mission's load
  double landing_rest_voltage_V = 0.0;  ///< of the pack once it has rested
  double minimum_voltage_V = 0.0;
  double peak_current_A = 0.0;
  double initial_voltage_V = 0.0;  ///< under the load of the first leg
  double initial_current_A = 0.0;
  double soc = 1.0;       ///< A at the end, under load
  double rest_soc = 1.0;  ///< share of the charge that is left
  /// The highest of a cell on the way; NaN where it knows no temperature.
  double hottest_degC = std::numeric_limits<double>::quiet_NaN();
  double distance_m = 0.0;       ///< over the ground
  int rounds = 0;                ///< how often the whole mission was flown
  double mission_power_W = 0.0;  ///< that the mission takes on the mean
  /// The one that ended the flight, else the first; none where the battery always gave the power.
  std::optional<PowerLack> lack;
  double lack_s = 0.0;  ///< how long no current gave the power, in all
};

/// A flight lasts for more than the second after which a voltage that is too low ends it.
inline constexpr double kLasts_s = 10.0;

/// Whether the battery carries the mission at all: a voltage, power or charge that it does not have
/// from the start is no flight. Judged by the energy, because a mission may begin with waiting.
[[nodiscard]] inline bool IsFlight(const EnduranceResult& result) {
  return result.energy_J >= kLasts_s * result.mission_power_W ||
         (result.ended_by != MissionEnd::kCutOff && result.ended_by != MissionEnd::kMotorVoltage &&
          result.ended_by != MissionEnd::kPower && result.ended_by != MissionEnd::kEmpty);
}

/// Flies the mission until it ends.
[[nodiscard]] EnduranceResult FlyMission(const EnduranceSetup& setup);

/// Flies each mission; side by side where they fit (endurance_lanes.h), which changes results by
/// rounding. A result depends on its own setup alone.
[[nodiscard]] std::vector<EnduranceResult> FlyMissions(std::span<const EnduranceSetup> setups);

/// How many missions FlyMissions() flies side by side.
inline constexpr std::size_t kMissionsAtOnce = 8;

}  // namespace lipoid
