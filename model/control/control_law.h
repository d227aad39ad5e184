#pragma once

/// @file
/// The inner loops as one function: from references, measured state and error integrals to the
/// torques and the thrust that are commanded. The flight controller samples it, the poles differentiate it. T is double, or
/// an automatic-differentiation scalar. Tests: tests/model/control/control_law_test.cc.

#include "model/control/command_generation.h"
#include "model/control/dynamic_inversion.h"
#include "model/control/gains.h"
#include "model/control/reference_model.h"
#include "model/vehicle/allocation.h"

namespace lipoid {

/// What the controller knows of the vehicle: measured, or perfect.
template <class T>
struct InnerLoopState {
  T down_m;
  T down_rate_m_per_s;
  Triple<T> angles_rad;
  Triple<T> body_rates;
};

template <class T>
struct InnerLoopReferences {
  LoopReference<T> down;
  Triple<LoopReference<T>> angles;
};

template <class T>
struct ErrorIntegrals {
  T down{};
  Triple<T> angles{};
};

template <class T>
struct InnerLoopOutput {
  T down_error;
  Triple<T> angle_errors;
  T pseudo_control_down;
  Triple<T> pseudo_control_angles;
  Wrench<T> wrench;  ///< tau_C and T_C; model/vehicle/allocation.h makes speeds of them
};

/// Errors and pseudo-controls of the four loops, which all control laws share. `angle_rates` are what
/// the law takes for the rates of the angles.
template <class T>
InnerLoopOutput<T> LoopErrors(const Gains& gains,
                              const InnerLoopState<T>& state,
                              const Triple<T>& angle_rates,
                              const InnerLoopReferences<T>& reference,
                              const ErrorIntegrals<T>& integrals) {
  InnerLoopOutput<T> out;
  out.down_error = reference.down.value - state.down_m;  // (3.62)
  out.pseudo_control_down = PseudoControl(gains.altitude,
                                          reference.down.acceleration,
                                          integrals.down,
                                          out.down_error,
                                          T(reference.down.rate - state.down_rate_m_per_s));
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& wanted = reference.angles[k];
    out.angle_errors[k] = wanted.value - state.angles_rad[k];
    out.pseudo_control_angles[k] = PseudoControl(k == 2 ? gains.yaw : gains.attitude,
                                                 wanted.acceleration,
                                                 integrals.angles[k],
                                                 out.angle_errors[k],
                                                 T(wanted.rate - angle_rates[k]));
  }
  return out;
}

/// The thesis' law: dynamic inversion.
template <class T>
InnerLoopOutput<T> InnerLoops(const Vehicle& vehicle,
                              const Gains& gains,
                              const InnerLoopState<T>& state,
                              const InnerLoopReferences<T>& reference,
                              const ErrorIntegrals<T>& integrals) {
  const Attitude<T> attitude(state.angles_rad);
  InnerLoopOutput<T> out =
      LoopErrors(gains, state, attitude.AngleRates(state.body_rates), reference, integrals);
  out.wrench.torque_N_m =
      InvertAttitude(vehicle, attitude, state.body_rates, out.pseudo_control_angles);
  out.wrench.thrust_N = InvertAltitude(vehicle, attitude, out.pseudo_control_down);
  return out;
}

}  // namespace lipoid
