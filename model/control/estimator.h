#pragma once

/// @file
/// From the sensors' readings to what the controller is told, as the Parrot Mambo does it: a
/// complementary filter for the attitude, a Kalman filter for the height, another for the
/// horizontal velocity, and integration for position and yaw, which therefore drift.
///
/// Weights, Q, R and the gates of sonar and pressure are the vehicle's published ones; the band
/// around g is not given and is four times the noise of |f|. Per step of 5 ms they mean
///
///   tilt      W = 0.001 is a time constant of 5 s
///   height    gains 0.0262 and 0.0698 /s, poles at 3.8 rad/s with a damping of 0.71. Q is what 4.5
///             m/s² of white acceleration give, R is 0.32 m: consistent with each other, but far
///             above the noise of the sensors, so the covariance is an upper bound
///   velocity  gain 0.125, a time constant of 37 ms. Q would be 60 m/s² of acceleration and R a
///             noise of 2.2 m/s: only their ratio means something
///
/// The height is that of the sonar, or of the pressure where the sonar is at its floor, away or
/// beyond its gate. After `reacquire_s` in which neither was within its gate, the next reading is
/// believed. Readings that are no numbers, or beyond their sensor's range, are not taken: inertial
/// ones and the voltage stay as they were, the others are left out.
///
/// Before a flight the biases of accelerometer, gyro and pressure are found as means at rest
/// (`calibrate`). Without it the published biases give an error of 2.7 degrees in roll and 2.2 in
/// pitch from the gyro, half a degree from the accelerometer, and 6 degrees a minute in yaw.
/// Tests: tests/model/control/estimator_test.cc.

#include <span>

#include "model/control/altitude_filter.h"
#include "model/control/attitude_filter.h"
#include "model/control/flight_controller.h"
#include "model/control/velocity_filter.h"
#include "model/vehicle/sensors.h"

namespace lipoid {

/// Cosine of the tilt up to which the optical flow is used: beyond 60 degrees the camera does not
/// look at the ground below.
inline constexpr double kLeastUpright = 0.5;

struct EstimatorOptions {
  bool calibrate = true;
  int calibration_samples = 400;
  double accelerometer_weight = 0.001;
  double gravity_band_m_per_s2 = 1.0;
  double altitude_q_m2_per_s2 = 5e-4;
  double altitude_r_m2 = 0.1;
  double sonar_gate_m = 0.3;
  double pressure_gate_m = 0.8;
  double reacquire_s = 0.5;
  double velocity_q_m2_per_s2 = 0.09;
  double velocity_r_m2_per_s2 = 5.0;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    const Range variance{1e-12, 1e6};
    const Range gate{0.0, 1e6};
    v("calibrate",
      self.calibrate,
      Names(),
      "whether the biases of gyroscope and accelerometer are found at rest before the flight");
    v("calibration_samples",
      self.calibration_samples,
      Range{1, 1'000'000},
      "number of readings at rest that the biases are found from, 5 ms apart");
    v("accelerometer_weight",
      self.accelerometer_weight,
      Range{0.0, 1.0},
      "share of the accelerometer in roll and pitch per step of 5 ms; the rest is the gyroscope's");
    v("gravity_band_m_per_s2",
      self.gravity_band_m_per_s2,
      gate,
      "m/s² by which the specific force may differ from g where the accelerometer counts");
    v("altitude_q_m2_per_s2",
      self.altitude_q_m2_per_s2,
      variance,
      "variance that the estimate of the vertical speed gains per step of 5 ms");
    v("altitude_r_m2",
      self.altitude_r_m2,
      variance,
      "variance of one reading of the altitude, in m²");
    v("sonar_gate_m",
      self.sonar_gate_m,
      gate,
      "metres from the estimate beyond which a reading of the sonar is refused");
    v("pressure_gate_m",
      self.pressure_gate_m,
      gate,
      "metres from the estimate beyond which an altitude by pressure is refused");
    v("reacquire_s",
      self.reacquire_s,
      Range{0.005, 1e6},
      "seconds of refused readings after which the estimate starts again from a reading");
    v("velocity_q_m2_per_s2",
      self.velocity_q_m2_per_s2,
      variance,
      "variance that the estimate of a horizontal velocity gains per step of 5 ms");
    v("velocity_r_m2_per_s2",
      self.velocity_r_m2_per_s2,
      variance,
      "variance of one reading of the horizontal velocity");
  }
};

class Estimator {
 public:
  explicit Estimator(const EstimatorOptions& options);

  /// At a state of rest that is known, one step before the first Step(). The readings were taken
  /// there; with `calibrate` their means are the biases. None: no biases.
  void Reset(const MeasuredState& at_rest, std::span<const SensorReadings> readings);

  /// One control step on. Does not allocate.
  MeasuredState Step(const SensorReadings& readings);

  [[nodiscard]] const AltitudeFilter& altitude() const { return altitude_; }
  [[nodiscard]] const VelocityFilter& velocity() const { return velocity_; }
  [[nodiscard]] const Triple<double>& accelerometer_bias_m_per_s2() const { return force_bias_; }
  [[nodiscard]] const Triple<double>& gyro_bias_rad_per_s() const { return rate_bias_; }

 private:
  void TakeAltitude(const SensorReadings& readings);
  void TakeFlow(const SensorReadings& readings);

  EstimatorOptions options_;
  AttitudeFilter attitude_;
  AltitudeFilter altitude_;
  VelocityFilter velocity_;
  Triple<double> force_bias_{};
  Triple<double> rate_bias_{};
  double pressure_bias_m_ = 0.0;
  Triple<double> force_{};         // of the last good readings, less the bias, body axes
  Triple<double> rates_{};         // likewise
  Triple<double> acceleration_{};  // inertial, at the last step
  double battery_V_ = 0.0;
  double without_altitude_s_ = 0.0;
};

}  // namespace lipoid
