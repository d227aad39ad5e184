#pragma once

/// @file
/// The sensors of a Parrot Mambo, read once per control step of 5 ms.
///
///   accelerometer  specific force (acceleration less gravity) in body axes + bias + noise, clipped
///   gyro           body rates + bias + noise, clipped
///   sonar          altitude + noise; it says its floor wherever that is less
///   pressure       altitude + bias + noise
///   optical flow   body velocity ahead and to the right + noise, clipped
///   voltage        of the battery + noise, rounded to a step
///
/// Biases, noise, ranges and the sonar's floor are the figures published with the vehicle's
/// simulation package. It gives none for the noise of sonar, pressure and flow: the first two are
/// taken as a sixth of the gates that the vehicle's estimator has for them, so that no healthy
/// reading is refused. (The estimator's R of 0.1 m² cannot be the sonar's variance: a third of its
/// readings would then lie beyond its gate of 0.3 m.) The flow's is chosen: it is what the position
/// controller turns into tilt, half a degree at most in a hover, as little as the vehicle shows.
///
/// Altitude is -Z, positive up. Noise is white. Switching one kind of noise off leaves the numbers
/// of the others as they are. Tests: tests/model/vehicle/sensors_test.cc.

#include <array>
#include <cstdint>

#include "model/core/options.h"
#include "model/statistics/normal_noise.h"
#include "model/vehicle/rigid_body.h"

namespace lipoid {

inline constexpr Triple<double> kAccelerometerBias_m_per_s2{0.09, -0.06, 0.337};
inline constexpr Triple<double> kAccelerometerNoise_m_per_s2{0.21, 0.19, 0.27};  // rms at 5 ms
inline constexpr double kAccelerometerRange_m_per_s2 = 50.0;
inline constexpr Triple<double> kGyroBias_rad_per_s{-0.0095, -0.0075, 0.0015};
inline constexpr double kGyroNoise_rad_per_s = 1.5e-3;  // rms at 5 ms
inline constexpr double kGyroRange_rad_per_s = 10.0;
inline constexpr double kSonarFloor_m = 0.44;
inline constexpr double kFlowRange_m_per_s =
    30.0;  // beyond what the vehicle flies; no figure given

struct SensorOptions {
  double accelerometer_bias = 1.0;
  double accelerometer_noise = 1.0;
  double gyro_bias = 1.0;
  double gyro_noise = 1.0;
  double sonar_noise_m = 0.05;
  double pressure_noise_m = 0.13;
  double pressure_bias_m = 0.0;
  double flow_noise_m_per_s = 0.02;
  double voltage_noise_V = 0.0;
  double voltage_step_V = 0.0;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    const Range factor{0.0, 100.0};
    const Range noise{0.0, 10.0};
    v("accelerometer_bias",
      self.accelerometer_bias,
      factor,
      "bias of the accelerometer, as a multiple of the published one");
    v("accelerometer_noise",
      self.accelerometer_noise,
      factor,
      "noise of the accelerometer, as a multiple of the published one");
    v("gyro_bias",
      self.gyro_bias,
      factor,
      "bias of the gyroscope, as a multiple of the published one");
    v("gyro_noise",
      self.gyro_noise,
      factor,
      "noise of the gyroscope, as a multiple of the published one");
    v("sonar_noise_m", self.sonar_noise_m, noise, "rms noise of the sonar's height, m");
    v("pressure_noise_m", self.pressure_noise_m, noise, "rms noise of the altitude by pressure, m");
    v("pressure_bias_m",
      self.pressure_bias_m,
      Range{-1e4, 1e4},
      "constant error of the altitude by pressure, m");
    v("flow_noise_m_per_s",
      self.flow_noise_m_per_s,
      noise,
      "rms noise of each velocity by optical flow, m/s");
    v("voltage_noise_V",
      self.voltage_noise_V,
      noise,
      "rms noise of the measured battery voltage, V");
    v("voltage_step_V",
      self.voltage_step_V,
      noise,
      "step to which the measured battery voltage is rounded, V; 0: not rounded");
  }
};

/// What the sensors sense, without their faults.
struct SensedMotion {
  Triple<double> position_m{};
  Triple<double> angles_rad{};
  Triple<double> velocity_m_per_s{};  ///< inertial
  Triple<double> body_rates_rad_per_s{};
  Triple<double> specific_force_m_per_s2{};  ///< body axes; (0, 0, -g) at rest and level
  double battery_V = 0.0;
};

struct SensorReadings {
  Triple<double> accelerometer_m_per_s2{};
  Triple<double> gyro_rad_per_s{};
  double sonar_m = 0.0;              ///< altitude
  double pressure_altitude_m = 0.0;  ///< altitude
  std::array<double, 2> flow_m_per_s{};
  double battery_V = 0.0;
};

class Sensors {
 public:
  Sensors(const SensorOptions& options, std::uint64_t seed);

  /// Readings of the next step. Does not allocate.
  SensorReadings Read(const SensedMotion& motion);

 private:
  SensorOptions options_;
  NormalNoise noise_;
};

}  // namespace lipoid
