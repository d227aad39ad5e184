#pragma once

/// @file
/// From commanded speeds to duty cycles, (3.17) or (5.52), and to the integer that the hardware
/// takes, (6.1). Tests: tests/model/control/command_generation_test.cc.

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "model/vehicle/motor.h"

namespace lipoid {

/// D_i for the speed, were the battery at this voltage: v_b0 for (3.17), the measured v_b for
/// (5.52). May exceed 1.
template <class T>
T DutyCycle(const Vehicle& v, const T& commanded_speed, const T& battery_V) {
  return HoldingVoltage(v, commanded_speed) / battery_V;  // (3.17)
}

/// How duty cycles become the integers of the hardware, (6.1).
///
/// One step of the Mambo's 490 is 0.9 rad/s² of roll: rounding alone leaves the weak attitude gains
/// of the thesis an error of half a radian. Carrying the remainder over to the next step makes the
/// mean over a few steps exact, which is all that motors of 18 ms see.
enum class Pwm { kCarried, kRounded, kContinuous };

constexpr std::array<std::pair<Pwm, std::string_view>, 3> OptionNames(Pwm) {
  return {
      {{Pwm::kCarried, "carried"}, {Pwm::kRounded, "rounded"}, {Pwm::kContinuous, "continuous"}}};
}

class PulseWidth {
 public:
  PulseWidth(const Vehicle& v, Pwm kind)
      : low_(v.pwm_range[0]), span_(v.pwm_range[1] - v.pwm_range[0]), kind_(kind) {}

  /// The duty cycle in [0, 1] that comes out for one that is wanted.
  double operator()(double duty) {
    const double wanted = std::clamp(duty, 0.0, 1.0);
    if (kind_ == Pwm::kContinuous) return wanted;
    const double exact = low_ + span_ * wanted + remainder_;  // (6.1)
    const double pwm = std::clamp(std::nearbyint(exact), low_, low_ + span_);
    if (kind_ == Pwm::kCarried) remainder_ = std::clamp(exact - pwm, -0.5, 0.5);
    return (pwm - low_) / span_;
  }

 private:
  double low_;
  double span_;
  Pwm kind_;
  double remainder_ = 0.0;
};

}  // namespace lipoid
