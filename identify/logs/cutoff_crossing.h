#pragma once

/// @file
/// When a predicted voltage falls to the cut-off: between two rows of one load on the straight line
/// between them, else at the row that is below. A voltage that rises above it again has not reached it, nor
/// has one at rest or in charge.
/// Tests: tests/identify/logs/cutoff_crossing_test.cc.

#include <algorithm>
#include <cmath>
#include <limits>

namespace lipoid {

class CutoffCrossing {
 public:
  /// Of the pack whose voltages come.
  explicit CutoffCrossing(double cutoff_V) : cutoff_V_(cutoff_V) {}

  void Row(double time_s, double current_A, double voltage_V) {
    const bool above = voltage_V >= cutoff_V_ || current_A <= 0.0;
    if (above) {
      crossed_s_ = kNone;
    } else if (std::isnan(crossed_s_)) {
      // A larger current takes the voltage down at once and not on the way from row to row.
      const bool one_load = std::abs(current_A - current_A_) <=
                            kSameLoad * std::max(std::abs(current_A), std::abs(current_A_));
      crossed_s_ = time_s;
      if (above_ && one_load && voltage_V < voltage_V_)
        crossed_s_ =
            time_s_ + (voltage_V_ - cutoff_V_) / (voltage_V_ - voltage_V) * (time_s - time_s_);
    }
    above_ = above;
    time_s_ = time_s;
    current_A_ = current_A;
    voltage_V_ = voltage_V;
  }

  /// NaN where the last row was above.
  [[nodiscard]] double time_s() const { return crossed_s_; }

 private:
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  static constexpr double kSameLoad = 0.1;  // as a constant current is one

  double cutoff_V_;
  bool above_ = false;  // the row before, of which are:
  double time_s_ = 0.0;
  double current_A_ = 0.0;
  double voltage_V_ = 0.0;
  double crossed_s_ = kNone;
};

}  // namespace lipoid
