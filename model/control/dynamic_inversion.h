#pragma once

/// @file
/// Nonlinear dynamic inversion: torques and thrust that give the angles and the altitude wanted
/// accelerations, (3.49) and (3.58). At xi = 1 and without motor lag they cancel the dynamics
/// exactly. Tests: tests/model/control/dynamic_inversion_test.cc.

#include "model/vehicle/rigid_body.h"
#include "model/vehicle/vehicle.h"

namespace lipoid {

/// tau_C = J S^-1 (nu - S' Omega) + Omega x J Omega: (3.49) with its last sign corrected.
template <class T>
Triple<T> InvertAttitude(const Vehicle& v,
                         const Attitude<T>& attitude,
                         const Triple<T>& body_rates,
                         const Triple<T>& pseudo_control) {
  const Triple<T> drift = attitude.AngleRateDrift(body_rates);
  const Triple<T> wanted = attitude.BodyRates(
      {pseudo_control[0] - drift[0], pseudo_control[1] - drift[1], pseudo_control[2] - drift[2]});
  const Triple<T> gyroscopic = GyroscopicTorque(v.inertia_kg_m2, body_rates);
  return {v.inertia_kg_m2[0] * wanted[0] + gyroscopic[0],
          v.inertia_kg_m2[1] * wanted[1] + gyroscopic[1],
          v.inertia_kg_m2[2] * wanted[2] + gyroscopic[2]};  // (3.49)
}

/// T_C = m (g - nu_Z)/(cos Phi cos Theta), (3.58) with (3.54)'s sign corrected. Without bound where
/// the vehicle lies on its side.
template <class T>
T InvertAltitude(const Vehicle& v, const Attitude<T>& attitude, const T& pseudo_control) {
  return v.mass_kg * (T(kGravity_m_per_s2) - pseudo_control) /
         (attitude.cos_roll * attitude.cos_pitch);  // (3.58)
}

}  // namespace lipoid
