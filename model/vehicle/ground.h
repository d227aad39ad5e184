#pragma once

/// @file
/// The ground: four feet under the motors, each on a damped spring with friction, so that a vehicle
/// lands, rights itself and lies still. The springs are chosen from the mass: at rest they give by
/// g/(50 rad/s)² = 4 mm, which the default step of 5 ms resolves.
/// Tests: tests/model/vehicle/ground_test.cc.

#include "model/battery/exact_hold.h"
#include "model/vehicle/allocation.h"
#include "model/vehicle/rigid_body.h"
#include "model/vehicle/vehicle.h"

namespace lipoid {

inline constexpr double kGroundFrequency_rad_per_s = 50.0;
/// How far below z = 0 a vehicle stands that lies still.
inline constexpr double kGroundRest_m =
    kGravity_m_per_s2 / (kGroundFrequency_rad_per_s * kGroundFrequency_rad_per_s);

template <class T>
struct GroundReaction {
  Triple<T> force_N{T(0.0), T(0.0), T(0.0)};     ///< inertial axes
  Triple<T> torque_N_m{T(0.0), T(0.0), T(0.0)};  ///< body axes
};

/// Whether a foot could reach the ground: z down, the ground at z = 0.
template <class T>
bool NearGround(const Vehicle& v, const T& down_m) {
  return ScalarPart(down_m) > -v.arm_m;
}

template <class T>
GroundReaction<T> GroundContact(const Vehicle& v,
                                const Triple<T>& position_m,
                                const Attitude<T>& attitude,
                                const Triple<T>& velocity_m_per_s,
                                const Triple<T>& body_rates) {
  using std::sqrt;
  constexpr double kFrequency_rad_per_s = kGroundFrequency_rad_per_s;
  constexpr double kDamping = 0.7;
  constexpr double kFriction = 0.6;
  constexpr double kSlip_m_per_s = 0.05;  // below it friction grows with the speed
  const double stiffness = 0.25 * v.mass_kg * kFrequency_rad_per_s * kFrequency_rad_per_s;
  const double damping = 0.25 * v.mass_kg * 2.0 * kDamping * kFrequency_rad_per_s;

  GroundReaction<T> sum;
  const double lever = v.lever_m();
  for (std::size_t i = 0; i < 4; ++i) {
    // Front feet are ahead, left feet at negative y.
    const Triple<T> arm{T(lever * kPitchSign[i]), T(-lever * kRollSign[i]), T(0.0)};
    const Triple<T> offset = attitude.ToInertial(arm);
    const T depth = position_m[2] + offset[2];
    if (!(ScalarPart(depth) > 0.0)) continue;
    const Triple<T> swing = attitude.ToInertial(Cross(body_rates, arm));
    const T normal = stiffness * depth + damping * (velocity_m_per_s[2] + swing[2]);
    if (!(ScalarPart(normal) > 0.0)) continue;  // feet do not stick
    const T x = velocity_m_per_s[0] + swing[0];
    const T y = velocity_m_per_s[1] + swing[1];
    const T grip = kFriction * normal / sqrt(x * x + y * y + T(kSlip_m_per_s * kSlip_m_per_s));
    const Triple<T> force{-(grip * x), -(grip * y), -normal};
    const Triple<T> torque = Cross(arm, attitude.ToBody(force));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sum.force_N[axis] = sum.force_N[axis] + force[axis];
      sum.torque_N_m[axis] = sum.torque_N_m[axis] + torque[axis];
    }
  }
  return sum;
}

}  // namespace lipoid
