#pragma once

/// @file
/// What a kind of log must contain: a discharge to cut-off, a slow discharge, pulses with rests.
///
/// A discharge runs from the switch-on of the current to cut-off. With backward hold the current of
/// row k flows over (t[k-1], t[k]], so the switch-on is the stamp of the row before the first
/// loaded one; without such a row it is the first stamp. Cut-off is reached when the voltage comes
/// within CutoffTolerance(); where it crosses, the crossing is interpolated. The current is charge over
/// time. Rests before and after are welcome.
///
/// A record that is not what it should be is a LoadError at its file, in one sentence with the
/// numbers. Tests: tests/identify/logs/discharge_test.cc.

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "identify/logs/record.h"
#include "identify/logs/segments.h"

namespace lipoid {

struct Cell;

inline constexpr double kCutoffTolerance_V = 0.005;
/// A discharge at a higher rate says little about the open-circuit voltage: five hours at least.
inline constexpr double kMaxLowRate_per_h = 0.2;

/// Rows of a rest; fewer show no relaxation.
inline constexpr std::size_t kRestRows = 2;

/// Rows [first, last] carry the current from start_s to end_s.
struct Discharge {
  std::size_t first = 0;
  std::size_t last = 0;          ///< the row that reaches cut-off, or the last loaded one
  double start_s = 0.0;          ///< switch-on
  double end_s = 0.0;            ///< cut-off, or the last stamp under load
  double charge_C = 0.0;         ///< between the two
  double current_A = 0.0;        ///< charge over time
  double end_voltage_V = 0.0;    ///< at end_s; NaN where the log has no voltages
  double voltage_noise_V = 0.0;  ///< standard deviation of a row
  /// From the row before the last one to it; 0 where rows are so few that one more would change the
  /// time.
  double last_fall_V = 0.0;

  [[nodiscard]] double time_s() const { return end_s - start_s; }
  /// How near a row is to the voltage that it shows: kCutoffTolerance_V, or 3 sigma of the noise.
  [[nodiscard]] double nearness_V() const {
    return std::max(kCutoffTolerance_V, 3.0 * voltage_noise_V);
  }
};

/// max(nearness_V(), two falls of the last row but 50 mV at most): a
/// cycler that stops at the cut-off may do so between two rows, and the fall gets faster.
[[nodiscard]] double CutoffTolerance(const Discharge& discharge);

/// Whether a cell has reached its cut-off where it has `voltage_V` under `current_A`, in volts of the pack,
/// after so many rows of a log of `rows_of_log`. An empty cell that rests or is charged has not. A current that
/// ends there is whole: the last row of a discharge lies on a steep end.
[[nodiscard]] bool IsBelowCutoff(const Cell& cell,
                                 double current_A,
                                 double voltage_V,
                                 std::size_t rows_before,
                                 std::size_t rows_of_log);

/// The discharge of a constant-current log, from switch-on to the cut-off of one cell.
[[nodiscard]] Discharge FindDischarge(const Record& record, double cutoff_V);

/// The discharge of a low-rate log: constant, and no faster than kMaxLowRate_per_h. It need not
/// reach any cut-off. The rate is that of capacity_Ah, or of the log's own charge where that is 0.
[[nodiscard]] Discharge FindLowRateDischarge(const Record& record, double capacity_Ah);

/// The one discharge at constant current that a record holds, from switch-on to its last loaded row
/// whatever the voltage; none where there is no such.
[[nodiscard]] std::optional<Discharge> WholeDischarge(const Record& record);

/// The segments of a log of pulses, in which at least one load is followed by a rest.
[[nodiscard]] std::vector<Segment> FindPulses(const Record& record);

}  // namespace lipoid
