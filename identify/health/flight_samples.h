#pragma once

/// @file
/// What of a flight log is compared with a prediction, and where in time.
///
/// An autopilot samples voltage and current by turns, repeats values until new ones come, and its
/// filters delay one against the other. A row's voltage then belongs to another instant than its
/// current, and single rows show a resistance that is too small. The rows whose voltage is new are
/// therefore averaged over windows: the shortest ones over which the changes of the voltage follow
/// those of the current, after the lag with which they follow best. Tests:
/// tests/identify/health/flight_samples_test.cc, tests/tools/health_test.cc.

#include <Eigen/Core>
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "identify/health/unresolved_current.h"
#include "identify/logs/log.h"

namespace lipoid {

/// Interpolates at rising times.
class Follower {
 public:
  explicit Follower(const Column& time_s) : time_s_(time_s) {}
  /// The row before, and the share of the next.
  std::pair<std::size_t, double> operator()(double at_s) {
    while (k_ + 2 < time_s_.size() && time_s_[k_ + 1] <= at_s) ++k_;
    while (k_ > 0 && time_s_[k_] > at_s) --k_;
    const double share = (at_s - time_s_[k_]) / (time_s_[k_ + 1] - time_s_[k_]);
    return {k_, std::clamp(share, 0.0, 1.0)};
  }

 private:
  const Column& time_s_;
  std::size_t k_ = 0;
};

struct FlightSamples {
  Record record;                   ///< rows at which the cell is stepped
  std::vector<std::size_t> fresh;  ///< rows of it whose voltage is new
  /// Of `fresh`, [first, second) for each window, in order.
  std::vector<std::pair<std::size_t, std::size_t>> windows;
  std::vector<double> time_s;  ///< of each window, its mean
  Eigen::VectorXd voltage_V;   ///< of each window, its mean
  double voltage_update_s = 0.0;
  double current_update_s = 0.0;
  double window_s = 0.0;             ///< 0: single rows
  double lag_s = 0.0;                ///< of the voltage after the current, where they follow best
  double coherence = 0.0;            ///< correlation of their changes there, with the sign turned
  double edge_resistance_Ohm = 0.0;  ///< what those changes show, at least 0
  double largest_A = 0.0;
  double unfollowed_share =
      0.0;  ///< noise that was taken out of the current (followed_current.h), of the largest
  UnresolvedCurrent unresolved;  ///< between the values of the current
  double gap_C = 0.0;            ///< that may have flowed in gaps between the rows
  std::size_t dropped_rows = 0;  ///< at the end, while the plug was pulled
  double stuck_voltage_s = 0.0;  ///< over which the voltage stood still: none of it is in `fresh`
  std::string doubt;             ///< of the current, in a sentence (stuck_sensor.h)

  /// The shortest time after a step of the current that the samples tell from the step itself.
  [[nodiscard]] double settle_s() const { return 2.0 * std::max(window_s, voltage_update_s); }
  /// Sentences on what to think of the log: changes that do not agree, and what was taken out of it, that
  /// noise, a voltage that stood still.
  [[nodiscard]] std::vector<std::string> Said() const;
  /// Values at all rows of the record as the windows see them: taken `after_s` earlier, with straight
  /// lines between rows, and averaged.
  [[nodiscard]] Eigen::MatrixXd InWindows(const Eigen::MatrixXd& at_rows, double after_s) const;
  /// The slope of that in the lag.
  [[nodiscard]] Eigen::VectorXd LagSlope(const Eigen::VectorXd& at_rows, double after_s) const;
  /// Relative errors, at the rows of `fresh`, of a prediction at all rows, taken `after_s` earlier.
  struct Errors {
    double mean_percent = 0.0;
    double max_percent = 0.0;
  };
  [[nodiscard]] Errors ErrorsOf(const Eigen::VectorXd& predicted_V, double after_s) const;
};

/// Windows grow until the changes agree so well, within the lag; below the second, they do not.
inline constexpr double kCoherentEnough = 0.97;
inline constexpr double kCoherent = 0.9;
/// The largest lag that is looked for, either way.
inline constexpr double kLargestLag_s = 1.5;

/// LoadError for a flight that says nothing of a battery: too short, too idle, too slowly sampled. The
/// record and the capacity are of the same pack, or of one cell.
void RefuseIdleFlight(const Record& record, double capacity_Ah);

/// The log is that of one cell, with a voltage.
[[nodiscard]] FlightSamples SampleFlight(const Log& log);

}  // namespace lipoid
