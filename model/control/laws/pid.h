#pragma once

/// @file
/// PID control of each axis by itself, as common autopilots do it: the body rates are taken for the
/// rates of the angles, a torque is the moment of inertia times the pseudo-control (3.60), and the
/// thrust is that of a level vehicle. Near hover it is dynamic inversion to first order; tilted it
/// gives too little thrust, and turning it lets the axes disturb one another.
/// Tests: tests/model/control/control_laws_test.cc.

#include "model/control/control_law.h"

namespace lipoid {

inline InnerLoopOutput<double> PidInnerLoops(const Vehicle& vehicle,
                                             const Gains& gains,
                                             const InnerLoopState<double>& state,
                                             const InnerLoopReferences<double>& reference,
                                             const ErrorIntegrals<double>& integrals) {
  auto out = LoopErrors<double>(gains, state, state.body_rates, reference, integrals);
  for (std::size_t k = 0; k < 3; ++k)
    out.wrench.torque_N_m[k] = vehicle.inertia_kg_m2[k] * out.pseudo_control_angles[k];
  out.wrench.thrust_N = vehicle.mass_kg * (kGravity_m_per_s2 - out.pseudo_control_down);
  return out;
}

}  // namespace lipoid
