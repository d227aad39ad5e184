#pragma once

/// @file
/// The error controller: pseudo-control from the reference and the error, (3.60), with the gains
/// named as (5.27) uses them (docs/corrections.md). Tests:
/// tests/model/control/error_controller_test.cc.

namespace lipoid {

/// Proportional, integral and derivative gain: K_e, K_eI, K_edot.
template <class T>
struct BasicErrorGains {
  T proportional{};  ///< 1/s²
  T integral{};      ///< 1/s³
  T derivative{};    ///< 1/s
};
using ErrorGains = BasicErrorGains<double>;

/// nu = y_ref'' + K_eI e_I + K_e e + K_edot e', with e = y_ref - y, (3.60)-(3.63).
template <class T>
T PseudoControl(const ErrorGains& gains,
                const T& reference_acceleration,
                const T& error_integral,
                const T& error,
                const T& error_rate) {
  return reference_acceleration + gains.integral * error_integral + gains.proportional * error +
         gains.derivative * error_rate;  // (3.60)
}

}  // namespace lipoid
