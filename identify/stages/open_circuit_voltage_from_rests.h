#pragma once

/// @file
/// Stage 2 without a low-rate log: v_oc(A) from the rests between pulses.
///
///   v_oc(A) = the voltage at the end of a rest,   A = initial_soc - sigma/alpha        (4.59)
///
/// Straight lines join the rests. The start of a log counts as one, because every log starts
/// rested; any other rest must last kShortestRest_s. Of rests at nearly one state of charge the
/// longest is taken.
///
/// How far a rest was from settled is reported and not corrected: `drift_V` is how far the voltage
/// moved in the second half of the rest. A relaxation whose time constants are below
/// rest/(2 ln 2) = 0.72 rest has no more than that still before it. Extrapolation would need the
/// law of the relaxation, of which logs with a resolution of 1 mV show a few steps.
///
/// Below the lowest rest the discharge to the end of that log is all there is. Two guesses enclose
/// v_oc there: the voltage under load, raised by the drop that the load before that rest showed at
/// its end, is too low, because resistance and diffusion take more near empty; the straight line
/// through the two lowest rests is too high, because the curve bends down. The curve goes half-way
/// between them, and `half_gap_V` is how far either is away at its end.
///
/// Tests: tests/identify/stages/open_circuit_voltage_from_rests_test.cc.

#include <optional>
#include <string>
#include <vector>

#include "identify/logs/record.h"
#include "identify/logs/segments.h"
#include "model/battery/open_circuit_voltage.h"

namespace lipoid {

/// After 5 min branches, of 10 to 100 s in the cells known here, have settled, and what still
/// relaxes is slow.
inline constexpr double kShortestRest_s = 300.0;
/// Two states of charge only give a straight line, whose slope no third one tests.
inline constexpr std::size_t kFewestRests = 3;

/// A log of pulses, cut into its segments; both must outlive the call.
struct LogOfRests {
  const Record* record = nullptr;
  const std::vector<Segment>* segments = nullptr;
  double initial_soc = 1.0;
};

struct SettledRest {
  double soc = 0.0;
  double voltage_V = 0.0;      ///< at its end, by a straight line through its last quarter
  double rest_s = 0.0;         ///< how long; 0 where the log starts with a single row at rest
  double drift_V = 0.0;        ///< by which the voltage moved in its second half, with its sign
  double slope_V_per_s = 0.0;  ///< of the straight line
};

struct OcvFromRests {
  OpenCircuitVoltage curve;
  std::vector<SettledRest> rests;  ///< by state of charge, rising
  double largest_drift_V = 0.0;    ///< of their magnitudes
  /// Below rests.front() the curve is a guess down to this state of charge, where it may be off by
  /// half_gap_V; drop_V raised the voltage under load. None where the log ends with a rest.
  std::optional<double> guessed_to_soc;
  double half_gap_V = 0.0;
  double drop_V = 0.0;
};

/// alpha_C > 0. LoadError at the first log where the rests are at fewer than kFewestRests states of
/// charge.
[[nodiscard]] OcvFromRests FindOpenCircuitVoltageFromRests(const std::vector<LogOfRests>& logs,
                                                           double alpha_C);

/// Where the curve comes from and how far to believe it, as a sentence without a full stop.
[[nodiscard]] std::string InWords(const OcvFromRests& result);

/// alpha where nothing else gives it: the charge that left a log of pulses until it came to the
/// cut-off, over initial_soc. The most of all logs; none where no log comes so far.
[[nodiscard]] std::optional<double> ChargeToCutoff(const std::vector<LogOfRests>& logs,
                                                   double cutoff_V);

/// What alpha must be for the rests to lie on a v_oc(A) that is given over the whole charge.
struct AlphaOfRests {
  double alpha_C = 0.0;
  /// Of what was still relaxing, by drift_V, and of what the rests disagree by, which is taken as one
  /// error of all of them: a curve that is a little off is off at neighbouring states of charge.
  double error_C = 0.0;
  std::size_t rests = 0;
};

/// By least squares of the states of charge. None where fewer than kFewestRests rests lie within the
/// curve, or none of them half a charge below the start.
[[nodiscard]] std::optional<AlphaOfRests> FindAlphaOfRests(const std::vector<LogOfRests>& logs,
                                                           const OpenCircuitVoltage& curve);

}  // namespace lipoid
