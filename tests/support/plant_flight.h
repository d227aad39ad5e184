#pragma once

/// @file
/// The plant alone, without a controller, for tests: integrated with inputs that are held, and its
/// vectors as Eigen's, so that a test computes with other code than the one it tests.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <boost/numeric/odeint/algebra/array_algebra.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta4.hpp>
#include <cmath>
#include <random>

#include "model/vehicle/plant.h"
#include "model/vehicle/vehicle_file.h"

namespace lipoid::test {

/// The vehicle of the thesis.
inline const Vehicle& Mambo() {
  static const Vehicle vehicle = LoadVehicle("mambo-thesis");
  return vehicle;
}

template <class T, std::size_t N>
Eigen::Matrix<T, int(N), 1> AsEigen(const std::array<T, N>& values) {
  return Eigen::Map<const Eigen::Matrix<T, int(N), 1>>(values.data());
}

/// Body to inertial axes: yaw after pitch after roll.
inline Eigen::Matrix3d Rotation(const Triple<double>& angles) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return (AngleAxisd(angles[2], Vector3d::UnitZ()) * AngleAxisd(angles[1], Vector3d::UnitY()) *
          AngleAxisd(angles[0], Vector3d::UnitX()))
      .toRotationMatrix();
}

inline Triple<double> RandomTriple(std::mt19937& engine, double magnitude) {
  std::uniform_real_distribution<double> uniform(-magnitude, magnitude);
  return {uniform(engine), uniform(engine), uniform(engine)};
}

/// Roll and yaw all the way round, pitch up to 1.4 rad: 10 degrees short of its pole.
inline Triple<double> RandomAngles(std::mt19937& engine) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  return {3.1 * uniform(engine), 1.4 * uniform(engine), 3.1 * uniform(engine)};
}

/// `steps` classical Runge-Kutta steps of `derivative(x, dx)`.
template <class State, class Derivative>
void RungeKutta4(const Derivative& derivative, State& x, double step_s, int steps) {
  boost::numeric::odeint::
      runge_kutta4<State, double, State, double, boost::numeric::odeint::array_algebra>
          stepper;
  const auto system = [&](const State& at, State& dx, double) { derivative(at, dx); };
  for (int k = 0; k < steps; ++k) stepper.do_step(system, x, k * step_s, step_s);
}

template <std::size_t N>
void Fly(const Plant& plant,
         const PlantInputs<double>& in,
         PlantState<double, N>& x,
         double step_s,
         int steps) {
  RungeKutta4([&](const PlantState<double, N>& at,
                  PlantState<double, N>& dx) { plant.Derivative(at, in, dx); },
              x,
              step_s,
              steps);
}

/// Speed at which four motors carry the weight.
inline double HoverSpeed(const Vehicle& v) {
  return std::sqrt(v.mass_kg * kGravity_m_per_s2 / (4.0 * v.thrust_coefficient_N_s2));
}

}  // namespace lipoid::test
