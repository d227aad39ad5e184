#include "model/control/estimator.h"

#include <algorithm>
#include <cmath>

namespace lipoid {
namespace {

template <std::size_t N>
bool Within(const std::array<double, N>& values, double range) {
  return std::all_of(values.begin(), values.end(), [&](double x) { return std::abs(x) <= range; });
}

Triple<double> Less(const Triple<double>& a, const Triple<double>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

// Mean of those that were taken; zero of none.
class Means {
 public:
  template <std::size_t N>
  void Add(const std::array<double, N>& values) {
    for (std::size_t k = 0; k < N; ++k) sum_[k] += values[k];
    ++count_;
  }
  [[nodiscard]] bool empty() const { return count_ == 0.0; }
  double operator[](std::size_t k) const { return sum_[k] / count_; }

 private:
  Triple<double> sum_{};
  double count_ = 0.0;
};

}  // namespace

Estimator::Estimator(const EstimatorOptions& options)
    : options_(options),
      attitude_(options.accelerometer_weight, options.gravity_band_m_per_s2, kControlStep_s),
      altitude_(options.altitude_q_m2_per_s2, options.altitude_r_m2, kControlStep_s),
      velocity_(options.velocity_q_m2_per_s2, options.velocity_r_m2_per_s2, kControlStep_s) {}

void Estimator::Reset(const MeasuredState& at_rest, std::span<const SensorReadings> readings) {
  const Triple<double>& position = at_rest.position_m;
  const Triple<double>& velocity = at_rest.velocity_m_per_s;
  attitude_.Reset(at_rest.angles_rad, at_rest.body_rates_rad_per_s);
  altitude_.Reset(position[2], velocity[2]);
  velocity_.Reset({position[0], position[1]}, {velocity[0], velocity[1]});
  force_ = attitude_.attitude().ToBody({0.0, 0.0, -kGravity_m_per_s2});
  rates_ = at_rest.body_rates_rad_per_s;
  acceleration_ = {};
  battery_V_ = at_rest.battery_V;
  without_altitude_s_ = 0.0;
  force_bias_ = {};
  rate_bias_ = {};
  pressure_bias_m_ = 0.0;
  if (!options_.calibrate) return;

  Means force;
  Means rates;
  Means pressure;
  for (const SensorReadings& r : readings) {
    if (Within(r.accelerometer_m_per_s2, kAccelerometerRange_m_per_s2)) {
      force.Add(r.accelerometer_m_per_s2);
    }
    if (Within(r.gyro_rad_per_s, kGyroRange_rad_per_s)) rates.Add(r.gyro_rad_per_s);
    if (std::isfinite(r.pressure_altitude_m)) pressure.Add(std::array{r.pressure_altitude_m});
  }
  for (std::size_t k = 0; k < 3; ++k) {
    if (!force.empty()) force_bias_[k] = force[k] - force_[k];
    if (!rates.empty()) rate_bias_[k] = rates[k] - rates_[k];
  }
  if (!pressure.empty()) pressure_bias_m_ = pressure[0] + position[2];
}

MeasuredState Estimator::Step(const SensorReadings& readings) {
  if (Within(readings.accelerometer_m_per_s2, kAccelerometerRange_m_per_s2)) {
    force_ = Less(readings.accelerometer_m_per_s2, force_bias_);
  }
  if (Within(readings.gyro_rad_per_s, kGyroRange_rad_per_s)) {
    rates_ = Less(readings.gyro_rad_per_s, rate_bias_);
  }
  if (std::isfinite(readings.battery_V)) battery_V_ = readings.battery_V;

  attitude_.Step(rates_, force_);
  Triple<double> acceleration = attitude_.attitude().ToInertial(force_);
  acceleration[2] += kGravity_m_per_s2;
  Triple<double> mean;  // over the step
  for (std::size_t k = 0; k < 3; ++k) mean[k] = 0.5 * (acceleration_[k] + acceleration[k]);
  acceleration_ = acceleration;

  altitude_.Predict(mean[2]);
  TakeAltitude(readings);
  velocity_.Predict({mean[0], mean[1]});
  TakeFlow(readings);
  velocity_.Integrate();

  const auto& [x_m, y_m] = velocity_.position_m();
  const auto& [u_m_per_s, v_m_per_s] = velocity_.velocity_m_per_s();
  return {.position_m = {x_m, y_m, altitude_.down_m()},
          .velocity_m_per_s = {u_m_per_s, v_m_per_s, altitude_.rate_m_per_s()},
          .angles_rad = attitude_.angles_rad(),
          .body_rates_rad_per_s = rates_,
          .battery_V = battery_V_};
}

void Estimator::TakeAltitude(const SensorReadings& readings) {
  const bool echo = std::isfinite(readings.sonar_m) && readings.sonar_m > kSonarFloor_m;
  const double pressure_down_m = pressure_bias_m_ - readings.pressure_altitude_m;
  if ((echo && altitude_.Update(-readings.sonar_m, options_.sonar_gate_m)) ||
      altitude_.Update(pressure_down_m, options_.pressure_gate_m)) {
    without_altitude_s_ = 0.0;
    return;
  }
  without_altitude_s_ += kControlStep_s;
  if (without_altitude_s_ < options_.reacquire_s) return;
  if (!echo && !std::isfinite(pressure_down_m)) return;
  altitude_.Restart(echo ? -readings.sonar_m : pressure_down_m);
  without_altitude_s_ = 0.0;
}

// The flow is two components of the body's velocity; the third is the one that makes the vertical
// speed what the filter of the height says.
void Estimator::TakeFlow(const SensorReadings& readings) {
  const auto& flow = readings.flow_m_per_s;
  const Attitude<double>& a = attitude_.attitude();
  const double upright = a.cos_pitch * a.cos_roll;
  if (!Within(flow, kFlowRange_m_per_s) || upright < kLeastUpright) return;
  const double below =
      (altitude_.rate_m_per_s() + a.sin_pitch * flow[0] - a.cos_pitch * a.sin_roll * flow[1]) /
      upright;
  const Triple<double> velocity = a.ToInertial({flow[0], flow[1], below});
  velocity_.Update({velocity[0], velocity[1]});
}

}  // namespace lipoid
