#pragma once

/// @file
/// Kalman filter for the horizontal velocity, driven by the measured acceleration, and the position
/// by integration. Both axes have the same Q (variance gained per step) and R (of one reading), so
/// one variance serves both, in whatever axes the readings are:
///
///   v += dt a + n,  var n = Q;       measured v + e,  var e = R;       x += dt (v_before + v)/2
///
/// Nothing measures the position: it wanders by the noise of the readings. Tests:
/// tests/model/control/velocity_filter_test.cc.

#include <array>

namespace lipoid {

class VelocityFilter {
 public:
  using Pair = std::array<double, 2>;

  VelocityFilter(double q_m2_per_s2, double r_m2_per_s2, double step_s)
      : q_(q_m2_per_s2), r_(r_m2_per_s2), step_s_(step_s) {}

  /// A state that is known exactly.
  void Reset(const Pair& position_m, const Pair& velocity_m_per_s) {
    position_m_ = position_m;
    velocity_m_per_s_ = velocity_m_per_s;
    before_m_per_s_ = velocity_m_per_s;
    variance_ = 0.0;
  }

  void Predict(const Pair& acceleration_m_per_s2) {
    before_m_per_s_ = velocity_m_per_s_;
    for (std::size_t k = 0; k < 2; ++k) velocity_m_per_s_[k] += step_s_ * acceleration_m_per_s2[k];
    variance_ += q_;
  }
  void Update(const Pair& velocity_m_per_s) {
    const double gain = variance_ / (variance_ + r_);
    for (std::size_t k = 0; k < 2; ++k) {
      velocity_m_per_s_[k] += gain * (velocity_m_per_s[k] - velocity_m_per_s_[k]);
    }
    variance_ *= 1.0 - gain;
  }
  /// Ends the step, after Update() where there was a reading.
  void Integrate() {
    for (std::size_t k = 0; k < 2; ++k) {
      position_m_[k] += 0.5 * step_s_ * (before_m_per_s_[k] + velocity_m_per_s_[k]);
    }
  }

  [[nodiscard]] const Pair& position_m() const { return position_m_; }
  [[nodiscard]] const Pair& velocity_m_per_s() const { return velocity_m_per_s_; }
  [[nodiscard]] double variance() const { return variance_; }

 private:
  double q_;
  double r_;
  double step_s_;
  Pair position_m_{};
  Pair velocity_m_per_s_{};
  Pair before_m_per_s_{};
  double variance_ = 0.0;
};

}  // namespace lipoid
