#pragma once

/// @file
/// The mission that a target is compared with the cell over, and its numbers are fitted to.
///
/// A target that counts charge alone must hold by resistance, capacity and curve what the cell's
/// diffusion does, so its best numbers depend on the mission. A mission that only hovers does not
/// tell resistance, full voltage and capacity apart, because its current is almost constant: there
/// must be rests before, between and after, and two levels of current.
///
/// Missions have backward hold, whatever they were read with, so that the cell and a target with
/// inertia are compared at the end of an interval, which both have then seen.
/// Tests: tests/identify/export/mission_test.cc.

#include <cstddef>
#include <string>
#include <vector>

#include "identify/logs/log.h"
#include "identify/pack_request.h"
#include "model/export/exported.h"

namespace lipoid {

/// The shape of the default mission: rest, a high current, rest, a low current, rest. The high
/// current is the one that would take the full cell to its cut-off in kDefaultEmpty_s; it flows for
/// half of that time, and half of it again for as long. The cell cannot reach its cut-off then:
/// what the diffusion holds back, and every drop, is at most what it would be had the high current
/// flowed on.
inline constexpr double kDefaultEmpty_s = 720.0;
inline constexpr double kDefaultRests_s[3] = {30.0, 120.0, 180.0};
inline constexpr double kDefaultRow_s = 0.1;

/// The high current of the pack, rounded down to four digits; 0 where no current lasts so long (its
/// v_oc is below its cut-off, its resistance beyond measure).
[[nodiscard]] double DefaultCurrent_A(const Cell& cell);

/// PreconditionError where DefaultCurrent_A() is 0.
[[nodiscard]] ExportMission DefaultMission(const Cell& cell);

/// Rows farther apart than one and a half of this are walked in steps of about it: a voltage that falls in
/// between is part of what a target must follow.
inline constexpr double kMissionStep_s = 1.0;

/// The current of a record, from initial_soc, and its temperature where it has one.
[[nodiscard]] ExportMission MissionOf(const Record& record, std::string name, double initial_soc);

/// Powers of the pack in W at increasing times; power_W[k] flows since times[k-1] (backward) or
/// until times[k+1] (forward).
struct PowerProfile {
  std::vector<double> time_s;
  std::vector<double> power_W;
  Hold hold = Hold::kBackward;
};

/// The powers of a file: time_s,power_W, or the product of voltage and current of any log, a flight
/// log of lipoid among them. LoadError where it is none of these or has fewer than two rows.
struct ReadPower {
  PowerProfile profile;
  std::vector<std::string> warnings;  ///< of the log
};
[[nodiscard]] ReadPower ReadPowerFile(const std::string& file, const ReadOptions& options);

/// The currents with which the cell gives these powers, P = i v: i is constant over a step, and i v is
/// the power at its end. Ends where the cell could give the power only below its cut-off.
[[nodiscard]] ExportMission MissionOf(const Cell& cell,
                                      const PowerProfile& power,
                                      std::string name,
                                      double initial_soc);

struct ReadMission {
  ExportMission mission;
  std::vector<std::string> warnings;  ///< of the file, and what was left out
  std::size_t rows_of_file = 0;
  std::size_t rows_beyond_cutoff = 0;  ///< that were left out
};

/// A log as simulate reads one, time_s,power_W, or a flight log of lipoid; without the rows from
/// the first one on in which the cell is below its cut-off. A voltage of the log that contradicts the start
/// is a warning. LoadError where it is none of these, where fewer than kLeastSteps remain or no current
/// flows, and where it is too long for the steps of a simulator.
inline constexpr std::size_t kLeastSteps = 10;
inline constexpr std::size_t kMostSteps = 2'000'000;
inline constexpr double kLongestMission_s = 7.0 * 86400.0;
[[nodiscard]] ReadMission ReadMissionFile(const Cell& cell,
                                          const std::string& file,
                                          const ReadOptions& options,
                                          const StartRequest& start);
/// The same of a log that was read already, whose warnings were said then.
[[nodiscard]] ReadMission MissionOfLog(const Cell& cell, const Log& log, const StartRequest& start);

}  // namespace lipoid
