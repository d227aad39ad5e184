#pragma once

/// @file
/// How long a full cell lasts at constant current by the diffusion model.
///
///   alpha = I [L + U(L)],  U(L) = 2 sum_k (1 - e^{-beta² k² L})/(beta² k²)
///                                          (4.37) at constant current
///   alpha = I [L + pi²/(3 beta²)]          (4.40), its limit for beta² L >> 1
///
/// Tests: tests/model/battery/discharge_time_test.cc.

namespace lipoid {

/// pi²/(3 beta²), in s: the steady unavailable charge per ampere.
[[nodiscard]] double SteadyLag(double beta_per_sqrt_s);
/// The beta of that lag; infinite where lag_s is not positive.
[[nodiscard]] double BetaOfSteadyLag(double lag_s);

/// U(time_s), in s: the unavailable charge per ampere after time_s of constant current. Rises from
/// 0 to SteadyLag(). Accurate to rounding for every beta > 0 and time_s >= 0.
[[nodiscard]] double UnavailableLag(double beta_per_sqrt_s, double time_s);

/// L of (4.40), 0 where the charge that is available is none.
[[nodiscard]] double SteadyDischargeTime(double alpha_C, double beta_per_sqrt_s, double current_A);

/// L of (4.37).
[[nodiscard]] double ExactDischargeTime(double alpha_C, double beta_per_sqrt_s, double current_A);

}  // namespace lipoid
