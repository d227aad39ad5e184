#include "model/vehicle/allocation.h"

#include <algorithm>
#include <cmath>

namespace lipoid {

Triple<double> TorqueReach(const Vehicle& vehicle) {
  if (vehicle.layout == RotorLayout::kQuadX) {
    const double tilt = 4.0 * vehicle.lever_m() * vehicle.thrust_coefficient_N_s2;
    return {tilt, tilt, 4.0 * vehicle.torque_coefficient_N_m_s2};
  }
  Triple<double> reach{};
  for (const Rotor& rotor : RotorsOf(vehicle.layout)) {
    const double share = vehicle.ThrustShare(rotor);
    reach[0] += share * std::abs(rotor.right);
    reach[1] += share * std::abs(rotor.ahead);
    reach[2] += 1.0;
  }
  const double lever = vehicle.arm_m * vehicle.thrust_coefficient_N_s2;
  return {reach[0] * lever, reach[1] * lever, reach[2] * vehicle.torque_coefficient_N_m_s2};
}

Vehicle EquivalentQuadrotor(const Vehicle& vehicle) {
  if (vehicle.layout == RotorLayout::kQuadX) return vehicle;
  double right = 0.0;
  double ahead = 0.0;
  double per_thrust = 0.0;
  for (const Rotor& rotor : RotorsOf(vehicle.layout)) {
    right = std::max(right, std::abs(rotor.right));
    ahead = std::max(ahead, std::abs(rotor.ahead));
    per_thrust = std::max(per_thrust, 1.0 / vehicle.ThrustShare(rotor));
  }
  const RotorSums sums = vehicle.SumsOverRotors();
  Vehicle quadrotor = vehicle;
  quadrotor.layout = RotorLayout::kQuadX;
  quadrotor.lower_rotor_thrust_ratio = 1.0;
  quadrotor.mass_kg *= 4.0 / sums.thrust;
  // An X's motors have sin 45 degrees each, and 4 sin² 45 degrees together.
  quadrotor.inertia_kg_m2[0] *= right * (2.0 / std::sqrt(0.5)) / sums.right_squared;
  quadrotor.inertia_kg_m2[1] *= ahead * (2.0 / std::sqrt(0.5)) / sums.ahead_squared;
  quadrotor.inertia_kg_m2[2] *= per_thrust * 4.0 / sums.per_thrust;
  return quadrotor;
}

}  // namespace lipoid
