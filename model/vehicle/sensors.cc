#include "model/vehicle/sensors.h"

#include <algorithm>
#include <cmath>

namespace lipoid {
namespace {

constexpr std::uint32_t kSensorStream = 0x73656e73;  // of its own, whatever else the seed feeds

double Clip(double value, double range) { return std::clamp(value, -range, range); }

}  // namespace

Sensors::Sensors(const SensorOptions& options, std::uint64_t seed)
    : options_(options), noise_(seed, kSensorStream) {}

// Always draws the same count of numbers: see the header.
SensorReadings Sensors::Read(const SensedMotion& motion) {
  SensorReadings r;
  for (std::size_t k = 0; k < 3; ++k) {
    r.accelerometer_m_per_s2[k] =
        Clip(motion.specific_force_m_per_s2[k] +
                 options_.accelerometer_bias * kAccelerometerBias_m_per_s2[k] +
                 options_.accelerometer_noise * kAccelerometerNoise_m_per_s2[k] * noise_(),
             kAccelerometerRange_m_per_s2);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    r.gyro_rad_per_s[k] =
        Clip(motion.body_rates_rad_per_s[k] + options_.gyro_bias * kGyroBias_rad_per_s[k] +
                 options_.gyro_noise * kGyroNoise_rad_per_s * noise_(),
             kGyroRange_rad_per_s);
  }
  const double altitude_m = -motion.position_m[2];
  r.sonar_m = std::max(kSonarFloor_m, altitude_m + options_.sonar_noise_m * noise_());
  r.pressure_altitude_m =
      altitude_m + options_.pressure_bias_m + options_.pressure_noise_m * noise_();
  const Triple<double> velocity =
      Attitude<double>(motion.angles_rad).ToBody(motion.velocity_m_per_s);
  for (std::size_t k = 0; k < 2; ++k) {
    r.flow_m_per_s[k] =
        Clip(velocity[k] + options_.flow_noise_m_per_s * noise_(), kFlowRange_m_per_s);
  }
  r.battery_V = motion.battery_V + options_.voltage_noise_V * noise_();
  if (options_.voltage_step_V > 0.0) {
    r.battery_V = options_.voltage_step_V * std::round(r.battery_V / options_.voltage_step_V);
  }
  return r;
}

}  // namespace lipoid
