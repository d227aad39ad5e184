#include "model/control/estimator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "model/core/errors.h"
#include "model/core/special_values.h"
#include "tests/support/constants.h"

namespace lipoid {
namespace {

constexpr std::uint64_t kNoiseSeed = 40;
using test::kDegree;

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
  motion.angles_rad = {0.0, 0.0, 0.7};
  motion.specific_force_m_per_s2 = {0.0, 0.0, -kGravity_m_per_s2};
  motion.battery_V = 3.9;
  return motion;
}

MeasuredState Truth(const SensedMotion& motion) {
  return {.position_m = motion.position_m,
          .velocity_m_per_s = motion.velocity_m_per_s,
          .angles_rad = motion.angles_rad,
          .body_rates_rad_per_s = motion.body_rates_rad_per_s,
          .battery_V = motion.battery_V};
}

std::vector<SensorReadings> ReadAtRest(Sensors& sensors, const SensedMotion& motion, int count) {
  std::vector<SensorReadings> readings;
  for (int k = 0; k < count; ++k) readings.push_back(sensors.Read(motion));
  return readings;
}

// Every number of two states.
void ExpectEqual(const MeasuredState& a, const MeasuredState& b) {
  EXPECT_EQ(a.position_m, b.position_m);
  EXPECT_EQ(a.velocity_m_per_s, b.velocity_m_per_s);
  EXPECT_EQ(a.angles_rad, b.angles_rad);
  EXPECT_EQ(a.body_rates_rad_per_s, b.body_rates_rad_per_s);
  EXPECT_EQ(a.battery_V, b.battery_V);
}

bool Finite(const MeasuredState& s) {
  double sum = s.battery_V;
  for (std::size_t k = 0; k < 3; ++k) {
    sum += s.position_m[k] + s.velocity_m_per_s[k] + s.angles_rad[k] + s.body_rates_rad_per_s[k];
  }
  return std::isfinite(sum);
}

TEST(Estimator, WithoutFaultsKnowsARest) {
  Sensors sensors(Faultless(), kNoiseSeed);
  Estimator estimator({});
  const SensedMotion motion = Hovering(1.5);
  estimator.Reset(Truth(motion), ReadAtRest(sensors, motion, 10));
  MeasuredState state;
  for (int k = 0; k < 1000; ++k) state = estimator.Step(sensors.Read(motion));
  constexpr double kRounding = 1e-12;
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(state.position_m[k], motion.position_m[k], kRounding);
    EXPECT_NEAR(state.velocity_m_per_s[k], 0.0, kRounding);
    EXPECT_NEAR(state.angles_rad[k], motion.angles_rad[k], kRounding);
    EXPECT_EQ(state.body_rates_rad_per_s[k], 0.0);
  }
  EXPECT_EQ(state.battery_V, 3.9);
}

// Told a state that is wrong, with all the noise of the sensors: it finds the truth where there is
// something to find it by.
TEST(Estimator, AtRestConvergesToTheTruthWithinItsCovariance) {
  SensorOptions unbiased;
  unbiased.accelerometer_bias = 0.0;
  unbiased.gyro_bias = 0.0;
  const SensedMotion motion = Hovering(1.5);
  MeasuredState wrong = Truth(motion);
  wrong.position_m[2] += 0.2;
  wrong.velocity_m_per_s = {1.0, -1.0, 0.5};
  wrong.angles_rad[0] += 0.02;
  wrong.angles_rad[1] -= 0.02;
  double roll_square = 0.0;
  constexpr int kRuns = 50;
  for (int run = 0; run < kRuns; ++run) {
    Sensors sensors(unbiased, kNoiseSeed + static_cast<std::uint64_t>(run));
    Estimator estimator({});
    estimator.Reset(wrong, {});
    MeasuredState state;
    for (int k = 0; k < 8000; ++k) state = estimator.Step(sensors.Read(motion));  // 8 times 5 s
    // Q and R are above the noise of the sensors: all errors are within two sigma.
    const auto& p = estimator.altitude().covariance();
    EXPECT_LT(std::abs(state.position_m[2] + 1.5), 2.0 * std::sqrt(p.zz));
    EXPECT_LT(std::abs(state.velocity_m_per_s[2]), 2.0 * std::sqrt(p.ww));
    const double sigma_m_per_s = std::sqrt(estimator.velocity().variance());
    EXPECT_LT(std::abs(state.velocity_m_per_s[0]), 2.0 * sigma_m_per_s);
    EXPECT_LT(std::abs(state.velocity_m_per_s[1]), 2.0 * sigma_m_per_s);
    roll_square += state.angles_rad[0] * state.angles_rad[0];
  }
  // What W lets through of the roll shown, W/2 of the variance of 0.19/g; four sigma of the mean of
  // 50 squares is 4 sqrt(2/50) of it.
  const double shown_rad = 0.19 / kGravity_m_per_s2;
  EXPECT_NEAR(roll_square / kRuns / (0.0005 * shown_rad * shown_rad), 1.0, 0.8);
}

TEST(Estimator, CalibrationFindsTheBiases) {
  Sensors sensors(SensorOptions{.pressure_bias_m = 200.0}, kNoiseSeed);
  SensedMotion motion = Hovering(0.1);    // the sonar at its floor: only the pressure knows
  motion.angles_rad = {0.05, -0.1, 0.7};  // on a slope
  motion.specific_force_m_per_s2 =
      Attitude<double>(motion.angles_rad).ToBody({0.0, 0.0, -kGravity_m_per_s2});
  constexpr int kSamples = 10'000;
  Estimator estimator({});
  estimator.Reset(Truth(motion), ReadAtRest(sensors, motion, kSamples));
  const double of_mean = 4.0 / std::sqrt(kSamples);  // four sigma
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(estimator.accelerometer_bias_m_per_s2()[k],
                kAccelerometerBias_m_per_s2[k],
                of_mean * kAccelerometerNoise_m_per_s2[k]);
    EXPECT_NEAR(
        estimator.gyro_bias_rad_per_s()[k], kGyroBias_rad_per_s[k], of_mean * kGyroNoise_rad_per_s);
  }
  MeasuredState state;
  for (int k = 0; k < 2000; ++k) state = estimator.Step(sensors.Read(motion));
  // The filter passes a tenth of the noise of the pressure, 0.13 m.
  EXPECT_NEAR(state.position_m[2], -0.1, 4.0 * 0.013 * 2.0);
}

TEST(Estimator, WithoutCalibrationErrsByTheBiasesAsItsHeaderSays) {
  SensorOptions biased = Faultless();
  biased.gyro_bias = 1.0;
  const auto settle = [](const SensorOptions& faults) {
    Sensors sensors(faults, kNoiseSeed);
    EstimatorOptions options;
    options.calibrate = false;
    Estimator estimator(options);
    const SensedMotion motion = Hovering(1.5);
    estimator.Reset(Truth(motion), ReadAtRest(sensors, motion, 100));
    MeasuredState state;
    for (int k = 0; k < 12'000; ++k) state = estimator.Step(sensors.Read(motion));  // a minute
    return state;
  };
  const MeasuredState by_gyro = settle(biased);
  EXPECT_NEAR(by_gyro.angles_rad[0] / kDegree, -2.7, 0.05);
  EXPECT_NEAR(by_gyro.angles_rad[1] / kDegree, -2.2, 0.1);
  EXPECT_NEAR((by_gyro.angles_rad[2] - 0.7) / kDegree, 6.0, 0.5);
  biased.gyro_bias = 0.0;
  biased.accelerometer_bias = 1.0;
  const MeasuredState by_accelerometer = settle(biased);
  EXPECT_NEAR(by_accelerometer.angles_rad[1] / kDegree, 0.5, 0.05);
}

// A flight along x, y and z at once with the tilt that makes it: the force along the body's axis.
struct Flight {
  double ahead_m = 0.25;
  double right_m = 0.2;
  double up_m = 0.1;
  double omega_rad_per_s = 2.0;

  Triple<double> Position(double t) const {
    const double w = omega_rad_per_s * t;
    return {ahead_m * (1.0 - std::cos(w)),
            right_m * (1.0 - std::cos(1.3 * w)),
            -2.0 - up_m * (1.0 - std::cos(0.7 * w))};
  }
  Triple<double> Velocity(double t) const {
    const double w = omega_rad_per_s;
    return {ahead_m * w * std::sin(w * t),
            right_m * 1.3 * w * std::sin(1.3 * w * t),
            -up_m * 0.7 * w * std::sin(0.7 * w * t)};
  }
  Triple<double> Force(double t) const {  // inertial
    const double w = omega_rad_per_s;
    const double v = 1.3 * w;
    const double u = 0.7 * w;
    return {ahead_m * w * w * std::cos(w * t),
            right_m * v * v * std::cos(v * t),
            -up_m * u * u * std::cos(u * t) - kGravity_m_per_s2};
  }
  Triple<double> Angles(double t) const {
    const auto f = Force(t);
    const double size = std::sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
    // Heading X: the body's z axis is (sin Theta cos Phi, -sin Phi, cos Theta cos Phi) = -f/|f|.
    return {std::asin(f[1] / size), std::atan2(-f[0], -f[2]), 0.0};
  }
  SensedMotion At(double t) const {
    constexpr double kDelta_s = 1e-4;
    const auto before = Angles(t - kDelta_s);
    const auto after = Angles(t + kDelta_s);
    Triple<double> angle_rates;
    for (std::size_t k = 0; k < 3; ++k) angle_rates[k] = (after[k] - before[k]) / (2.0 * kDelta_s);
    const Attitude<double> attitude(Angles(t));
    return {.position_m = Position(t),
            .angles_rad = Angles(t),
            .velocity_m_per_s = Velocity(t),
            .body_rates_rad_per_s = attitude.BodyRates(angle_rates),
            .specific_force_m_per_s2 = attitude.ToBody(Force(t)),
            .battery_V = 4.0};
  }
};

struct Worst {
  double position_m = 0.0;
  double velocity_m_per_s = 0.0;
  double tilt_rad = 0.0;
};
Worst Follow(const SensorOptions& faults, const EstimatorOptions& options, std::uint64_t seed) {
  const Flight flight;
  Sensors sensors(faults, seed);
  Estimator estimator(options);
  SensedMotion rest = Hovering(2.0);
  rest.position_m = flight.Position(0.0);
  rest.angles_rad = flight.Angles(0.0);  // leaning as it will take off
  rest.specific_force_m_per_s2 =
      Attitude<double>(rest.angles_rad).ToBody({0.0, 0.0, -kGravity_m_per_s2});
  estimator.Reset(Truth(rest), ReadAtRest(sensors, rest, options.calibration_samples));
  Worst worst;
  constexpr double kSettled_s = 25.0;
  for (int k = 1; k <= 10'000; ++k) {
    const SensedMotion motion = flight.At(k * kControlStep_s);
    const MeasuredState state = estimator.Step(sensors.Read(motion));
    if (k * kControlStep_s < kSettled_s) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      worst.position_m =
          std::max(worst.position_m, std::abs(state.position_m[i] - motion.position_m[i]));
      worst.velocity_m_per_s = std::max(
          worst.velocity_m_per_s, std::abs(state.velocity_m_per_s[i] - motion.velocity_m_per_s[i]));
    }
    for (std::size_t i = 0; i < 2; ++i) {
      worst.tilt_rad =
          std::max(worst.tilt_rad, std::abs(state.angles_rad[i] - motion.angles_rad[i]));
    }
  }
  return worst;
}

TEST(Estimator, FollowsAKnownFlight) {
  EstimatorOptions by_gyro;
  by_gyro.accelerometer_weight = 0.0;
  const Worst w = Follow(Faultless(), by_gyro, kNoiseSeed);
  // Integration by trapezoids, (omega dt)²/12 = 1.4e-5 of tilts of 0.14 and speeds of 0.5, summed
  // up over 50 s in the position; 2 for the body's axes.
  constexpr double kTrapezoid = 2.0 * 1.4e-5;
  EXPECT_LT(w.tilt_rad, kTrapezoid * 0.14);
  EXPECT_LT(w.velocity_m_per_s, kTrapezoid * 0.5);
  EXPECT_LT(w.position_m, kTrapezoid * 0.5 * 50.0);
}

// In such a flight the accelerometer shows no tilt (see attitude_filter.h). What it takes away of a
// tilt of A sin(w t) is A/(T w), T = 5 s: 0.138/(5 2.6) in roll. The rest is of second order.
TEST(Estimator, TheAccelerometerTakesAwaySomeOfATilt) {
  const Worst w = Follow(Faultless(), {}, kNoiseSeed);
  constexpr double kTaken_rad = 0.138 / (5.0 * 2.6);
  EXPECT_NEAR(w.tilt_rad, kTaken_rad, 0.15 * kTaken_rad);
  // g times that accelerates the filter of the velocity for 37 ms.
  EXPECT_LT(w.velocity_m_per_s, 2.0 * kGravity_m_per_s2 * kTaken_rad * 0.037);

  // With all faults: noise and calibration of the tilt as at rest, 1.3e-3 rad rms. Of the speeds
  // the vertical one has the most noise, 0.018 m/s by the filter's gains from the sonar's 0.05 m.
  // The position gets a random walk of the flow's noise, and 50 s of what g times that tilt makes
  // of the velocity in 37 ms.
  constexpr double kTilt_rad = 1.3e-3;
  constexpr double kDrift_m_per_s = kGravity_m_per_s2 * kTilt_rad * 0.037;
  const Worst all = Follow({}, {}, kNoiseSeed);
  EXPECT_LT(all.tilt_rad, kTaken_rad + 4.0 * kTilt_rad);
  EXPECT_LT(all.velocity_m_per_s, w.velocity_m_per_s + 5.0 * 0.018);
  EXPECT_LT(all.position_m,
            w.position_m + 4.0 * (0.02 * std::sqrt(50.0 * kControlStep_s) + 50.0 * kDrift_m_per_s));
}

TEST(Estimator, FollowsAConstantAcceleration) {
  Sensors sensors(Faultless(), kNoiseSeed);
  Estimator estimator({});
  SensedMotion motion = Hovering(2.0);
  estimator.Reset(Truth(motion), {});
  constexpr double kUp_m_per_s2 = 0.8;
  motion.specific_force_m_per_s2[2] -= kUp_m_per_s2;
  MeasuredState state;
  for (int k = 1; k <= 800; ++k) {
    const double t_s = k * kControlStep_s;
    motion.velocity_m_per_s[2] = -kUp_m_per_s2 * t_s;
    motion.position_m[2] = -2.0 - 0.5 * kUp_m_per_s2 * t_s * t_s;
    state = estimator.Step(sensors.Read(motion));
  }
  // The first step takes half of the acceleration, which began with it, and leaves 2 mm/s: after
  // 4 s at 2.7 rad/s 5e-5 of that. Without the accelerometer it would lag by a/omega² = 57 mm.
  EXPECT_NEAR(state.position_m[2], motion.position_m[2], 1e-6);
  EXPECT_NEAR(state.velocity_m_per_s[2], motion.velocity_m_per_s[2], 1e-6);
}

// A flight under all faults; `spoil` may change the readings of a step.
using Spoil = std::function<void(int, SensorReadings&)>;
struct Run {
  std::vector<MeasuredState> states;
  std::vector<SensorReadings> readings;
};
Run Fly(const Spoil& spoil, int steps = 400, double altitude_m = 1.5) {
  Sensors sensors({}, kNoiseSeed);
  Estimator estimator({});
  const SensedMotion motion = Hovering(altitude_m);
  estimator.Reset(Truth(motion), ReadAtRest(sensors, motion, 400));
  Run run;
  for (int k = 0; k < steps; ++k) {
    SensorReadings r = sensors.Read(motion);
    if (spoil) spoil(k, r);
    run.readings.push_back(r);
    run.states.push_back(estimator.Step(r));
  }
  return run;
}

TEST(Estimator, IsTheSameForTheSameReadings) {
  const auto one = Fly({});
  const auto same = Fly({});
  for (std::size_t k = 0; k < one.states.size(); ++k) {
    ExpectEqual(one.states[k], same.states[k]);
  }
}

TEST(Estimator, ASonarOutlierChangesNothing) {
  const auto without = Fly([](int k, SensorReadings& r) {
    if (k >= 200 && k < 220) r.sonar_m = kNaN;
  });
  for (const double offset_m : {0.6, -0.6, 5.0, -1.0}) {
    const auto with = Fly([&](int k, SensorReadings& r) {
      if (k >= 200 && k < 220) r.sonar_m = 1.5 + offset_m;
    });
    for (std::size_t k = 0; k < with.states.size(); ++k) {
      ExpectEqual(with.states[k], without.states[k]);
    }
  }
  // A reading within the gate does change the height.
  const auto near = Fly([](int k, SensorReadings& r) {
    if (k == 200) r.sonar_m = 1.7;
  });
  EXPECT_NE(near.states[200].position_m[2], without.states[200].position_m[2]);
}

// The sonar steps up by 2 m, as over a hole, and the pressure says nothing of it: never believed.
// Both step: believed after half a second.
TEST(Estimator, BelievesAJumpOnlyWhereBothSayItForHalfASecond) {
  const auto hole = Fly(
      [](int k, SensorReadings& r) {
        if (k >= 200) r.sonar_m += 2.0;
      },
      1000);
  EXPECT_NEAR(hole.states.back().position_m[2], -1.5, 0.1);
  const auto both = Fly(
      [](int k, SensorReadings& r) {
        if (k < 200) return;
        r.sonar_m += 2.0;
        r.pressure_altitude_m += 2.0;
      },
      1000);
  EXPECT_NEAR(both.states[298].position_m[2], -1.5, 0.1);
  // Then at once, to a reading: four sigma of the sonar.
  EXPECT_NEAR(both.states[299].position_m[2], -3.5, 4.0 * 0.05);
  EXPECT_NEAR(both.states.back().position_m[2], -3.5, 0.05);
}

TEST(Estimator, BelowTheSonarsFloorGoesByThePressure) {
  const auto low = Fly({}, 4000, 0.2);
  double mean = 0.0;
  for (std::size_t k = 400; k < 4000; ++k) mean += low.states[k].position_m[2] / 3600.0;
  // 18 s of a filter of 0.4 s average 20 independent errors of a tenth of 0.13 m; calibration adds
  // 0.13/20. Four sigma of 0.007 m.
  EXPECT_NEAR(mean, -0.2, 0.028);
}

TEST(Estimator, DoesNotTakeReadingsThatAreNoNumbersOrBeyondTheRange) {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto good = Fly({});
  for (const double bad : {kNaN, infinity, -infinity, 1e9}) {
    // Inertial readings and the voltage: as if they had not changed.
    const auto stays = Fly([&](int k, SensorReadings& r) {
      if (k != 200) return;
      r.accelerometer_m_per_s2[1] = bad;
      r.gyro_rad_per_s[2] = bad;
      if (!std::isfinite(bad)) r.battery_V = bad;
    });
    const auto repeated = Fly([&](int k, SensorReadings& r) {
      if (k != 200) return;
      r.accelerometer_m_per_s2 = good.readings[199].accelerometer_m_per_s2;
      r.gyro_rad_per_s = good.readings[199].gyro_rad_per_s;
      r.battery_V = good.readings[199].battery_V;
    });
    for (std::size_t k = 0; k < good.states.size(); ++k) {
      ExpectEqual(stays.states[k], repeated.states[k]);
    }
    // Everything at once and for a second: what was known goes on.
    const auto blind = Fly([&](int k, SensorReadings& r) {
      if (k < 200) return;
      r.accelerometer_m_per_s2.fill(bad);
      r.gyro_rad_per_s.fill(bad);
      r.sonar_m = std::isfinite(bad) ? kNaN : bad;
      r.pressure_altitude_m = kNaN;
      r.flow_m_per_s = {bad, 0.0};
      r.battery_V = kNaN;
    });
    for (const MeasuredState& state : blind.states) ASSERT_TRUE(Finite(state));
    EXPECT_EQ(blind.states.back().battery_V, good.states[199].battery_V);
    EXPECT_EQ(blind.states.back().body_rates_rad_per_s, good.states[199].body_rates_rad_per_s);
  }
}

TEST(Estimator, CalibrationLeavesOutBadReadings) {
  Sensors sensors(Faultless(), kNoiseSeed);
  const SensedMotion motion = Hovering(1.0);
  auto readings = ReadAtRest(sensors, motion, 10);
  readings[3].accelerometer_m_per_s2[0] = kNaN;
  readings[4].gyro_rad_per_s[0] = 11.0;
  readings[5].pressure_altitude_m = std::numeric_limits<double>::infinity();
  Estimator estimator({});
  estimator.Reset(Truth(motion), readings);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(estimator.accelerometer_bias_m_per_s2()[k], 0.0, 1e-14);
    EXPECT_EQ(estimator.gyro_bias_rad_per_s()[k], 0.0);
  }
  EXPECT_TRUE(Finite(estimator.Step(sensors.Read(motion))));
}

TEST(EstimatorOptions, RefuseWhatMakesNoFilter) {
  EstimatorOptions options;
  EXPECT_THROW(SetOption(options, "altitude_r_m2", "0"), OptionError);
  EXPECT_THROW(SetOption(options, "accelerometer_weight", "1.5"), OptionError);
  SetOption(options, "calibrate", "false");
  EXPECT_FALSE(options.calibrate);
}

}  // namespace
}  // namespace lipoid
