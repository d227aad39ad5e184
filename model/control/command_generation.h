#pragma once

/// @file
/// From commanded speeds to duty cycles, (3.17) or (5.52), and to the integer that the hardware
/// takes, (6.1). Tests: tests/model/control/command_generation_test.cc.

#include <algorithm>
#include <cmath>

#include "model/vehicle/motor.h"

namespace lipoid {

/// D_i for the speed, were the battery at this voltage: v_b0 for (3.17), the measured v_b for
/// (5.52). May exceed 1.
template <class T>
T DutyCycle(const Vehicle& v, const T& commanded_speed, const T& battery_V) {
  return HoldingVoltage(v, commanded_speed) / battery_V;  // (3.17)
}

/// D as the hardware's integer makes it, (6.1): rounded, and within its range.
inline double QuantizedDuty(const Vehicle& v, double duty) {
  const double low = v.pwm_range[0];
  const double span = v.pwm_range[1] - low;
  const double pwm = std::clamp(std::nearbyint(low + span * duty), low, v.pwm_range[1]);  // (6.1)
  return (pwm - low) / span;
}

}  // namespace lipoid
