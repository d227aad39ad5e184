#pragma once

/// @file
/// Whether the loops of a flight controller are stable about a hover, and how well they are damped,
/// before anything flies. Small motions of an axis are y'' = kappa G nu with
///
///   G(s) = 1/((lag s + 1)(T/2 s + 1)),    nu = r'' + C (r - y),    C(s) = K_edot s + K_e + K_eI/s
///
/// where T is the control step, of which holding the output costs half. The altitude, the attitude
/// (pitch; roll is alike) and the yaw are then
///
///   s³ (lag s + 1)(T/2 s + 1) + kappa P(s) = 0,    P(s) = K_edot s² + K_e s + K_eI
///
/// and the position, which commands tilts through the reference model F of the attitude, is
///
///   s² [s³/(kappa G) + P] + g F (s³ + P)(K_p + K_d s) = 0
///
/// A gain K_eI of zero leaves an integrator that nothing reads: it is no pole of the loop.
/// Quasi-static means G = 1. Margins are those of the loop cut at its pseudo-control, of the
/// position cut at the tilt that it commands. Tests: tests/model/analysis/stability_test.cc.

#include <complex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/analysis/poles.h"
#include "model/core/json.h"
#include "model/flight/simulator.h"

namespace lipoid {

/// Below this damping ratio a loop is said to ring: a step then overshoots by more than half.
inline constexpr double kRingingDamping = 0.2;

/// One loop about one hover.
struct LoopStability {
  std::string_view loop;       ///< altitude, attitude, yaw or position
  std::complex<double> pole;   ///< in 1/s, the one with the largest real part
  double quasistatic_per_s;    ///< the largest real part with motors at their equilibrium
  double frequency_rad_per_s;  ///< of the least damped pair of poles; NaN: all poles are real
  double damping;              ///< of that pair, 1 where all poles are real
  /// The least factors above and below 1 on the gain at which the loop becomes unstable; infinity
  /// and 0 where none does. NaN: the loop is unstable.
  double gain_margin_up;
  double gain_margin_down;
  double phase_margin_deg;  ///< NaN: the loop is unstable, or its gain never passes 1

  bool decays;  ///< whether every pole of both has a negative real part, by Routh's criterion

  [[nodiscard]] bool stable() const { return decays; }
  [[nodiscard]] bool rings() const { return stable() && damping < kRingingDamping; }
};

/// The largest real part among the poles of one axis, in 1/s, and its slopes in the gains.
struct Growth {
  double per_s;
  ErrorGains slopes;
};
[[nodiscard]] Growth GrowthOf(const AxisResponse& response, const ErrorGains& gains);

/// Altitude, attitude, yaw, and position where it has gains.
[[nodiscard]] std::vector<LoopStability> CheckLoops(const Vehicle& vehicle,
                                                    const Gains& gains,
                                                    const ControllerOptions& controller,
                                                    bool motor_lag,
                                                    const HoverPoint& hover);

/// The loops about one hover of a flight.
struct HoverStability {
  std::string_view when;  ///< "take-off", or "lowest voltage allowed"
  double xi;              ///< the battery's voltage under the current of hover, over v_b0
  std::vector<LoopStability> loops;

  [[nodiscard]] bool stable() const;
};

/// At take-off, and where the battery is so low that the flight ends: at its cut-off, at the voltage
/// at which it is to land, or where hover needs a duty cycle of 1. An ideal source has one voltage.
/// Empty where the vehicle cannot hover.
[[nodiscard]] std::vector<HoverStability> CheckFlightLoops(const FlightSetup& setup);

/// One sentence for each loop that is unstable or rings at one of the hovers, the unstable ones
/// first: "the yaw loop is unstable at xi = 0.71 (lowest voltage allowed): its error doubles every 1.2 s".
[[nodiscard]] std::vector<std::string> StabilityWarnings(std::span<const HoverStability> hovers);

/// In a summary: one object for each loop at each hover; null where a number does not exist.
[[nodiscard]] Json StabilityToJson(std::span<const HoverStability> hovers);

}  // namespace lipoid
