#include "model/vehicle/sensors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "model/core/errors.h"
#include "model/vehicle/vehicle.h"

namespace lipoid {
namespace {

constexpr std::uint64_t kNoiseSeed = 30;
constexpr std::size_t kChannels = 11;

SensorOptions Faultless() {
  SensorOptions options;
  options.accelerometer_bias = 0.0;
  options.accelerometer_noise = 0.0;
  options.gyro_bias = 0.0;
  options.gyro_noise = 0.0;
  options.sonar_noise_m = 0.0;
  options.pressure_noise_m = 0.0;
  options.flow_noise_m_per_s = 0.0;
  return options;
}

SensedMotion Hovering(double altitude_m) {
  SensedMotion motion;
  motion.position_m = {1.0, 2.0, -altitude_m};
  motion.specific_force_m_per_s2 = {0.0, 0.0, -kGravity_m_per_s2};
  motion.battery_V = 3.9;
  return motion;
}

std::array<double, kChannels> Channels(const SensorReadings& r) {
  return {r.accelerometer_m_per_s2[0],
          r.accelerometer_m_per_s2[1],
          r.accelerometer_m_per_s2[2],
          r.gyro_rad_per_s[0],
          r.gyro_rad_per_s[1],
          r.gyro_rad_per_s[2],
          r.sonar_m,
          r.pressure_altitude_m,
          r.flow_m_per_s[0],
          r.flow_m_per_s[1],
          r.battery_V};
}

TEST(Sensors, HaveTheBiasAndNoiseTheyShouldAndNoMemory) {
  SensorOptions options;
  options.voltage_noise_V = 0.01;
  options.pressure_bias_m = 12.0;
  const std::array<double, kChannels> mean{
      0.09, -0.06, 0.337 - 9.81, -0.0095, -0.0075, 0.0015, 1.5, 13.5, 0.0, 0.0, 3.9};
  const std::array<double, kChannels> rms{
      0.21, 0.19, 0.27, 1.5e-3, 1.5e-3, 1.5e-3, 0.05, 0.13, 0.02, 0.02, 0.01};
  constexpr int kCount = 200'000;
  Sensors sensors(options, kNoiseSeed);
  std::array<double, kChannels> sum{};
  std::array<double, kChannels> last{};
  std::array<double, kChannels> lagged{};
  std::array<std::array<double, kChannels>, kChannels> product{};
  for (int k = 0; k < kCount; ++k) {
    std::array<double, kChannels> noise = Channels(sensors.Read(Hovering(1.5)));
    for (std::size_t i = 0; i < kChannels; ++i) {
      noise[i] = (noise[i] - mean[i]) / rms[i];
      sum[i] += noise[i];
      lagged[i] += noise[i] * last[i];
    }
    for (std::size_t i = 0; i < kChannels; ++i) {
      for (std::size_t j = 0; j < kChannels; ++j) product[i][j] += noise[i] * noise[j];
    }
    last = noise;
  }
  // Four sigma of a mean of normal numbers, of their products, of their squares.
  const double of_mean = 4.0 / std::sqrt(kCount);
  for (std::size_t i = 0; i < kChannels; ++i) {
    EXPECT_NEAR(sum[i] / kCount, 0.0, of_mean) << "channel " << i;
    EXPECT_NEAR(lagged[i] / kCount, 0.0, of_mean) << "channel " << i;
    for (std::size_t j = 0; j < kChannels; ++j) {
      EXPECT_NEAR(
          product[i][j] / kCount, i == j ? 1.0 : 0.0, i == j ? std::sqrt(2.0) * of_mean : of_mean)
          << "channels " << i << " and " << j;
    }
  }
}

TEST(Sensors, WithoutFaultsReadTheMotion) {
  Sensors sensors(Faultless(), kNoiseSeed);
  SensedMotion motion = Hovering(2.0);
  motion.body_rates_rad_per_s = {0.1, -0.2, 0.3};
  motion.specific_force_m_per_s2 = {0.5, -0.4, -9.0};
  const SensorReadings r = sensors.Read(motion);
  EXPECT_EQ(r.accelerometer_m_per_s2, motion.specific_force_m_per_s2);
  EXPECT_EQ(r.gyro_rad_per_s, motion.body_rates_rad_per_s);
  EXPECT_EQ(r.sonar_m, 2.0);
  EXPECT_EQ(r.pressure_altitude_m, 2.0);
  EXPECT_EQ(r.battery_V, 3.9);
}

TEST(Sensors, SeeTheVelocityInBodyAxes) {
  Sensors sensors(Faultless(), kNoiseSeed);
  constexpr double kRounding = 1e-15;
  SensedMotion motion = Hovering(2.0);
  motion.angles_rad = {0.0, 0.0, 0.5 * std::numbers::pi};  // heading along Y
  motion.velocity_m_per_s = {3.0, 4.0, 0.0};
  auto flow = sensors.Read(motion).flow_m_per_s;
  EXPECT_NEAR(flow[0], 4.0, 4.0 * kRounding);
  EXPECT_NEAR(flow[1], -3.0, 4.0 * kRounding);

  motion.angles_rad = {0.0, std::numbers::pi / 6.0, 0.0};  // nose up 30 degrees, falling
  motion.velocity_m_per_s = {2.0, 1.0, 1.0};
  flow = sensors.Read(motion).flow_m_per_s;
  EXPECT_NEAR(flow[0], 2.0 * std::cos(std::numbers::pi / 6.0) - 0.5, 4.0 * kRounding);
  EXPECT_NEAR(flow[1], 1.0, kRounding);
}

TEST(Sensors, ClipAtTheirRange) {
  Sensors sensors({}, kNoiseSeed);
  SensedMotion motion = Hovering(2.0);
  motion.specific_force_m_per_s2 = {80.0, -80.0, 0.0};
  motion.body_rates_rad_per_s = {20.0, -20.0, 0.0};
  motion.velocity_m_per_s = {99.0, -99.0, 0.0};
  const SensorReadings r = sensors.Read(motion);
  EXPECT_EQ(r.accelerometer_m_per_s2[0], 50.0);
  EXPECT_EQ(r.accelerometer_m_per_s2[1], -50.0);
  EXPECT_EQ(r.gyro_rad_per_s[0], 10.0);
  EXPECT_EQ(r.gyro_rad_per_s[1], -10.0);
  EXPECT_EQ(r.flow_m_per_s[0], kFlowRange_m_per_s);
  EXPECT_EQ(r.flow_m_per_s[1], -kFlowRange_m_per_s);
}

TEST(Sensors, TheSonarHasAFloorAndThePressureHasNot) {
  Sensors sensors(Faultless(), kNoiseSeed);
  EXPECT_EQ(sensors.Read(Hovering(0.2)).sonar_m, 0.44);
  EXPECT_EQ(sensors.Read(Hovering(0.2)).pressure_altitude_m, 0.2);
  EXPECT_EQ(sensors.Read(Hovering(0.45)).sonar_m, 0.45);
  Sensors noisy({}, kNoiseSeed);
  for (int k = 0; k < 1000; ++k) EXPECT_GE(noisy.Read(Hovering(0.44)).sonar_m, 0.44);
}

TEST(Sensors, TheVoltageIsRoundedToItsStep) {
  SensorOptions options;
  options.voltage_noise_V = 0.02;
  options.voltage_step_V = 0.125;  // binary, so that its multiples are exact
  Sensors sensors(options, kNoiseSeed);
  Sensors fine(SensorOptions{.voltage_noise_V = 0.02}, kNoiseSeed);
  for (int k = 0; k < 100; ++k) {
    const double read_V = sensors.Read(Hovering(1.0)).battery_V;
    EXPECT_EQ(std::fmod(read_V, 0.125), 0.0);
    EXPECT_LE(std::abs(read_V - fine.Read(Hovering(1.0)).battery_V), 0.0625);
  }
}

TEST(Sensors, AreTheSameForTheSameSeedOnly) {
  Sensors one({}, kNoiseSeed);
  Sensors same({}, kNoiseSeed);
  Sensors other({}, kNoiseSeed + 1);
  for (int k = 0; k < 1000; ++k) {
    const auto now = Channels(one.Read(Hovering(1.5)));
    EXPECT_EQ(Channels(same.Read(Hovering(1.5))), now);
    EXPECT_NE(Channels(other.Read(Hovering(1.5))), now);
  }
}

TEST(Sensors, OneNoiseSwitchedOffLeavesTheOthers) {
  SensorOptions quiet;
  quiet.accelerometer_noise = 0.0;
  quiet.sonar_noise_m = 0.0;
  Sensors one({}, kNoiseSeed);
  Sensors other(quiet, kNoiseSeed);
  for (int k = 0; k < 100; ++k) {
    const SensorReadings a = one.Read(Hovering(1.5));
    const SensorReadings b = other.Read(Hovering(1.5));
    EXPECT_EQ(b.accelerometer_m_per_s2[2], 0.337 - kGravity_m_per_s2);
    EXPECT_EQ(b.sonar_m, 1.5);
    EXPECT_EQ(a.gyro_rad_per_s, b.gyro_rad_per_s);
    EXPECT_EQ(a.pressure_altitude_m, b.pressure_altitude_m);
    EXPECT_EQ(a.flow_m_per_s, b.flow_m_per_s);
  }
}

TEST(SensorOptions, RefuseNegativeNoise) {
  SensorOptions options;
  EXPECT_THROW(SetOption(options, "sonar_noise_m", "-0.1"), OptionError);
  SetOption(options, "gyro_bias", "0");
  EXPECT_EQ(options.gyro_bias, 0.0);
}

}  // namespace
}  // namespace lipoid
