#include "model/analysis/poles.h"

#include <ceres/jet.h>

#include <algorithm>
#include <cmath>

#include "model/control/control_law.h"
#include "model/core/errors.h"
#include "model/flight/trim.h"
#include "model/statistics/factorizations.h"
#include "model/vehicle/plant.h"

namespace lipoid {
namespace {

using Jet = ceres::Jet<double, kClosedLoopStates>;
constexpr std::size_t kIntegrals = plant::kStates;
constexpr double kHeight_m = 10.0;  // clear of the ground

template <class T>
using ClosedLoopState = std::array<T, kClosedLoopStates>;

Poles SortedEigenvalues(const Eigen::MatrixXd& matrix) {
  const Eigen::VectorXcd values = EigenvaluesOf(matrix);
  Poles poles(values.begin(), values.end());
  std::sort(poles.begin(), poles.end(), [](const auto& a, const auto& b) {
    return a.real() != b.real() ? a.real() > b.real() : a.imag() < b.imag();
  });
  return poles;
}

// The loop as it flies, but continuous: the same control law, allocation, motors and body.
template <class T>
ClosedLoopState<T> Rate(const Plant& vehicle_plant,
                        const Gains& gains,
                        const HoverPoint& hover,
                        const ClosedLoopState<T>& x) {
  using std::sqrt;
  const Vehicle& vehicle = vehicle_plant.vehicle();
  PlantState<T> body;
  std::copy_n(x.begin(), plant::kStates, body.begin());

  InnerLoopReferences<T> reference{};
  reference.down.value = T(-kHeight_m);
  const InnerLoopState<T> measured{body[plant::kPosition + 2],
                                   body[plant::kVelocity + 2],
                                   TripleAt(body, plant::kAngles),
                                   TripleAt(body, plant::kRates)};
  const ErrorIntegrals<T> integrals{x[kIntegrals],
                                    {x[kIntegrals + 1], x[kIntegrals + 2], x[kIntegrals + 3]}};
  const auto out = InnerLoops(vehicle, gains, measured, reference, integrals);
  const PerMotor<T> squares = SquaredSpeedsOf(vehicle, out.wrench);  // (3.13)
  PlantInputs<T> inputs;
  inputs.supply = {T(hover.supply.voltage_V), T(hover.supply.resistance_Ohm)};
  for (std::size_t i = 0; i < 4; ++i) {
    inputs.duty[i] = DutyCycle(vehicle, T(sqrt(squares[i])), T(hover.assumed_V));
  }
  PlantState<T> body_rate;
  vehicle_plant.Derivative(body, inputs, body_rate);

  ClosedLoopState<T> rate;
  std::copy(body_rate.begin(), body_rate.end(), rate.begin());
  rate[kIntegrals] = out.down_error;
  for (std::size_t k = 0; k < 3; ++k) rate[kIntegrals + 1 + k] = out.angle_errors[k];
  return rate;
}

ClosedLoopState<double> Hover(const Vehicle& vehicle, const Gains& gains, const HoverPoint& hover) {
  const Trim trim = HoverTrim(vehicle, hover.supply);
  Require(gains.altitude.integral > 0.0 || trim.battery_V == hover.assumed_V,
          "an integral gain of the altitude: without one hover at xi < 1 is no equilibrium",
          {{"xi", trim.battery_V / vehicle.nominal_voltage_V}});
  ClosedLoopState<double> x{};
  x[plant::kPosition + 2] = -kHeight_m;
  for (std::size_t i = 0; i < 4; ++i) x[plant::kSpeeds + i] = trim.speed_rad_per_s;
  const double speed = HeldSpeed(vehicle, trim.duty * hover.assumed_V);
  const double thrust_per_mass =
      4.0 * vehicle.thrust_coefficient_N_s2 * speed * speed / vehicle.mass_kg;
  if (gains.altitude.integral > 0.0) {
    x[kIntegrals] = (kGravity_m_per_s2 - thrust_per_mass) / gains.altitude.integral;
  }
  return x;
}

Plant QuietPlant(const Vehicle& vehicle, bool motor_lag) {
  return {vehicle, {.motor_lag = motor_lag, .drag = false, .ground = false}};
}

// Four motors take less current than six or eight: behind so much more resistance they see the same
// voltage.
HoverPoint OfFourMotors(const Vehicle& vehicle, HoverPoint hover) {
  hover.supply.resistance_Ohm *= static_cast<double>(vehicle.rotor_count()) / 4.0;
  return hover;
}

}  // namespace

double Kappa(const Vehicle& vehicle, double xi) {
  Require(xi > 0.0, "xi above 0", {{"xi", xi}});
  const Trim trim = HoverTrim(vehicle, Supply<double>{xi * vehicle.nominal_voltage_V, 0.0});
  const double w = trim.speed_rad_per_s;
  const double commanded = trim.commanded_speed_rad_per_s;
  // d/d omega of the voltage that holds a speed through so much resistance, times k_e.
  const double k_e = vehicle.motor_constant_N_m_per_A;
  const auto slope = [&](double resistance_Ohm, double speed) {
    return k_e * k_e + resistance_Ohm * (vehicle.friction_N_m_s +
                                         2.0 * vehicle.torque_coefficient_N_m_s2 * speed);
  };
  // What a duty cycle adds: v_b, and what the diodes no longer drop (powertrain.h).
  const SpeedController& esc = vehicle.esc;
  const double pulse_V = xi * vehicle.nominal_voltage_V + (esc.synchronous ? 0.0 : esc.diode_V);
  const double r_a = vehicle.armature_resistance_Ohm;
  return pulse_V / vehicle.nominal_voltage_V * w * slope(r_a, commanded) /
         (commanded * slope(r_a + esc.resistance_Ohm, w));
}

Poles ClosedFormPoles(const ErrorGains& gains, double kappa) {
  if (gains.integral == 0.0) {
    Eigen::Matrix2d companion;
    companion << 0.0, 1.0, -kappa * gains.proportional, -kappa * gains.derivative;
    return SortedEigenvalues(companion);
  }
  Eigen::Matrix3d companion;
  companion << 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, -kappa * gains.integral, -kappa * gains.proportional,
      -kappa * gains.derivative;  // (5.21)
  return SortedEigenvalues(companion);
}

ClosedLoopMatrix LinearizeClosedLoop(const Vehicle& of,
                                     const Gains& gains,
                                     const HoverPoint& at_hover,
                                     bool motor_lag) {
  const Vehicle vehicle = EquivalentQuadrotor(of);
  const HoverPoint hover = OfFourMotors(of, at_hover);
  const ClosedLoopState<double> at = Hover(vehicle, gains, hover);
  ClosedLoopState<Jet> x;
  for (int k = 0; k < kClosedLoopStates; ++k) x[std::size_t(k)] = Jet(at[std::size_t(k)], k);
  const auto rate = Rate(QuietPlant(vehicle, motor_lag), gains, hover, x);
  ClosedLoopMatrix matrix;
  for (int k = 0; k < kClosedLoopStates; ++k) matrix.row(k) = rate[std::size_t(k)].v.transpose();
  return matrix;
}

Eigen::Matrix<double, kClosedLoopStates, 1> ClosedLoopRateAtHover(const Vehicle& of,
                                                                  const Gains& gains,
                                                                  const HoverPoint& at_hover,
                                                                  bool motor_lag) {
  const Vehicle vehicle = EquivalentQuadrotor(of);
  const HoverPoint hover = OfFourMotors(of, at_hover);
  const auto rate =
      Rate(QuietPlant(vehicle, motor_lag), gains, hover, Hover(vehicle, gains, hover));
  return Eigen::Map<const Eigen::Matrix<double, kClosedLoopStates, 1>>(rate.data());
}

HoverResponse ResponseAtHover(const Vehicle& vehicle, const HoverPoint& hover) {
  // With gains of 1 the column of an error integral is what a pseudo-control of 1 does.
  constexpr ErrorGains kOne{.proportional = 1.0, .integral = 1.0, .derivative = 1.0};
  const Gains gains{.name = {}, .altitude = kOne, .attitude = kOne, .yaw = kOne, .position = {}};
  const ClosedLoopMatrix matrix = LinearizeClosedLoop(vehicle, gains, hover, /*motor_lag=*/true);
  constexpr auto kMotors = Eigen::Index(plant::kCharge - plant::kSpeeds);
  const auto response = [&](std::size_t integral, std::size_t rate) -> AxisResponse {
    const Eigen::VectorXd pattern =
        matrix.block(Eigen::Index(plant::kSpeeds), Eigen::Index(kIntegrals + integral), kMotors, 1);
    const Eigen::RowVectorXd drive =
        matrix.block(Eigen::Index(rate), Eigen::Index(plant::kSpeeds), 1, kMotors);
    const Eigen::MatrixXd motors =
        matrix.block(Eigen::Index(plant::kSpeeds), Eigen::Index(plant::kSpeeds), kMotors, kMotors);
    const double lag_s = -pattern.squaredNorm() / pattern.dot(motors * pattern);
    return {.kappa = lag_s * drive.dot(pattern), .lag_s = lag_s};
  };
  return {.altitude = response(0, plant::kVelocity + 2),
          .roll = response(1, plant::kRates),
          .pitch = response(2, plant::kRates + 1),
          .yaw = response(3, plant::kRates + 2)};
}

HoverPoint HoverAt(const Vehicle& vehicle, double xi) {
  return {.supply = {xi * vehicle.nominal_voltage_V, 0.0}, .assumed_V = vehicle.nominal_voltage_V};
}

Poles LoopPoles(Loop loop, const ClosedLoopMatrix& matrix, bool motor_lag) {
  // The loop's states as directions of the whole: unit vectors, and a pattern of the four speeds.
  const bool altitude = loop == Loop::kAltitude;
  const std::size_t integral = altitude ? kIntegrals : kIntegrals + 2;
  const std::size_t value = altitude ? plant::kPosition + 2 : plant::kAngles + 1;
  const std::size_t rate = altitude ? plant::kVelocity + 2 : plant::kRates + 1;
  // An integral that nothing reads is no state of the loop: its gain is zero.
  const bool integrates = (matrix.col(Eigen::Index(integral)).array() != 0.0).any();
  const Eigen::Index size = 2 + (integrates ? 1 : 0) + (motor_lag ? 1 : 0);
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(kClosedLoopStates, size);
  Eigen::Index next = 0;
  if (integrates) basis(Eigen::Index(integral), next++) = 1.0;
  basis(Eigen::Index(value), next++) = 1.0;
  basis(Eigen::Index(rate), next++) = 1.0;
  if (motor_lag) {
    for (std::size_t i = 0; i < 4; ++i) {
      basis(Eigen::Index(plant::kSpeeds + i), next) = altitude ? 1.0 : kPitchSign[i];
    }
  }
  const Eigen::MatrixXd image = matrix * basis;
  const Eigen::VectorXd weight = basis.colwise().squaredNorm().cwiseInverse();
  const Eigen::MatrixXd reduced = weight.asDiagonal() * (basis.transpose() * image);
  return SortedEigenvalues(reduced);
}

PolesRow PolesAt(Loop loop, const Vehicle& vehicle, const Gains& gains, double xi) {
  const double kappa = Kappa(vehicle, xi);
  const HoverPoint hover = HoverAt(vehicle, xi);
  return {xi,
          kappa,
          ClosedFormPoles(loop == Loop::kAltitude ? gains.altitude : gains.attitude, kappa),
          LoopPoles(loop, LinearizeClosedLoop(vehicle, gains, hover, false), false),
          LoopPoles(loop, LinearizeClosedLoop(vehicle, gains, hover, true), true)};
}

}  // namespace lipoid
