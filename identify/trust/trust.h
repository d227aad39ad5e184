#pragma once

/// @file
/// How far to believe parameters that weighted least squares found.
///
/// The fit minimizes sum_k w_k r_k² + theta' P theta. To first order its error is that of the rows,
///
///   theta^ - theta = H^{-1} J'W e,   H = J'WJ + P
///   covariance     = H^{-1} J'W Sigma W J H^{-1}
///
/// with Sigma the covariance of the residuals, estimated from them: their size from place to place
/// (local_noise.h) and their correlation (residual_correlation.h). A formula for white noise counts a million rows of one slow error as a million measurements. The
/// fit has followed some of the noise, which the residuals therefore lack: noise of every
/// correlation time is put through the same fit, to see what is left of it. Simulations also say
/// how well the correlation itself is known: intervals are Student's, with so many degrees of
/// freedom.
///
/// What is not in an interval: a model that is wrong in a way no candidate is right (its bias), and
/// what the fit took as exact. What a choice among models adds comes with the quantities.
/// Parameters nobody asks about are profiled out, those at a bound are held.
/// docs/verdicts.md. Tests: tests/identify/trust/trust_test.cc.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "identify/trust/residual_correlation.h"

namespace lipoid {

/// One log as the fit saw it.
struct FittedRows {
  std::vector<double> time_s = {};
  Eigen::VectorXd residual_V = {};   ///< measured less predicted
  Eigen::VectorXd weight = {};       ///< of each row's square in the objective
  Eigen::MatrixXd sensitivity = {};  ///< d predicted voltage/d parameter, rows x p
  Eigen::VectorXd averaged = {};     ///< log rows whose mean a row is; empty: 1
};

/// A parameter, or a linear combination of the p parameters.
struct TrustedQuantity {
  std::string name = {};
  std::string unit = {};
  double value = 0.0;
  double lower = -std::numeric_limits<double>::infinity();  ///< intervals end here
  double upper = std::numeric_limits<double>::infinity();
  bool at_bound = false;             ///< the parameters of the combination are held
  Eigen::VectorXd combination = {};  ///< length p; for one parameter a unit vector
  bool from_elsewhere =
      false;           ///< known by added_spread, and not by these rows: a combination of zeros
  double scale = 0.0;  ///< a change that is of note; 0: |value|
  /// What is not in the scatter of the rows, the choice among models and the error of the model's
  /// own tables: independent moves, the same for all quantities, whose squares add to the variance
  /// and whose products to a covariance. Those that are missing at the end are zero.
  Eigen::VectorXd added_spread = {};
};

enum class Verdict { kIdentified, kWeak, kAtBound, kOnlyInCombination };
constexpr std::array<std::pair<Verdict, std::string_view>, 4> OptionNames(Verdict) {
  return {{{Verdict::kIdentified, "identified"},
           {Verdict::kWeak, "weak"},
           {Verdict::kAtBound, "at-bound"},
           {Verdict::kOnlyInCombination, "only-in-combination-with"}}};
}

/// Identified: the 95 % interval lies within so much of the scale to either side. A tenth decides
/// what a user does with a cell: its drop, its run time, its gains change by no more.
inline constexpr double kIdentifiedHalfWidth = 0.1;
/// Only in combination: knowing its partners would shrink the standard error at least so much,
/// which is a (multiple) correlation of 0.95 and more. Partners are taken one by one, most helpful
/// first, until it would be identified.
inline constexpr double kPartnersShrink = 3.2;
inline constexpr int kMostPartners = 3;
/// Directions whose information is so much below the best, each parameter in its own unit, are not
/// in the data at all: what is left of them is rounding.
inline constexpr double kNoInformation = 1e-11;

/// A linear combination of the p parameters by its name.
struct NamedCombination {
  std::string name = {};
  Eigen::VectorXd combination = {};
  Eigen::VectorXd added_spread = {};  ///< as that of a quantity
};

inline constexpr int kSimulations = 48;

struct TrustOptions {
  std::vector<Eigen::Index> held;  ///< parameters at an active bound beside those of quantities
  int simulations =
      kSimulations;  ///< of noise like the residuals', for the degrees of freedom; > 1
  std::uint64_t seed = 1;
  /// Noise that is assumed, for an experiment that is only planned; else the residuals tell.
  std::optional<ResidualCorrelation> assumed = std::nullopt;
  /// What cells are to be drawn from: their covariance is found too, and nobody is told of them.
  std::vector<NamedCombination> drawn = {};
};

struct QuantityTrust {
  std::string name = {};
  std::string unit = {};
  double estimate = 0.0;
  double standard_error = 0.0;           ///< infinite: the data say nothing; NaN: at its bound
  double model_standard_error = 0.0;     ///< the part of it that the choice of the model adds
  double relative_standard_error = 0.0;  ///< of the scale
  double low = 0.0;                      ///< 95 % interval; infinite or NaN as the error
  double high = 0.0;
  Verdict verdict = Verdict::kWeak;
  std::vector<std::string> with;  ///< partners of kOnlyInCombination
  bool insensitive = false;       ///< no prediction of any log is sensitive to it
  bool open_by_model = false;     ///< weak, and identified were there no error but that of noise
  double degrees_of_freedom = 0.0;
  /// What the formula for independent residuals of the same size would have said; NaN of a plan.
  double white_standard_error = 0.0;
  /// The objective with this quantity moved to the end of its interval and the others refitted
  /// lies so much above its least.
  double objective_rise_95 = 0.0;
};

/// What a pulse test would measure from rest: (v_b(0) - v_b(t))/i
/// (identify/fit/pulse_resistance.h).
struct PulseResistance {
  double soc = 0.5;  ///< as the cell counts it
  double after_s = 0.0;
  double current_A = 0.0;
  std::optional<double> temperature_degC = {};  ///< none: the cell knows no temperature
  double resistance_Ohm = 0.0;
  double low_Ohm = 0.0;   ///< 95 %
  double high_Ohm = 0.0;  ///< infinite where the error is not known
};

/// A combination of the quantities, each over its scale.
struct CarriedCombination {
  double singular_value_V = 0.0;  ///< rms change of the predictions if it moves by one
  std::vector<double> weights;    ///< of each quantity; norm 1
};

struct TrustReport {
  std::vector<QuantityTrust> quantities;
  Eigen::MatrixXd covariance;  ///< of the quantities; not finite where their errors are not
  /// Worst carried first. Those of quantities at a bound or that follow from others are left out.
  std::vector<CarriedCombination> combinations;
  std::vector<ResidualCorrelation> residual_correlation;  ///< of each log
  /// Of TrustOptions::drawn, in its order. Parameters that are held, and directions of which the
  /// rows know nothing, do not vary in it.
  Eigen::MatrixXd drawn_covariance;
  std::vector<std::string> drawn;           ///< their names
  std::vector<PulseResistance> resistance;  ///< often known where its parts are not
  /// How much larger the error of a new log like each of these is than that in the fit, which has
  /// followed some of the noise: by noise like the residuals', drawn for both. 1 of a plan.
  std::vector<double> new_over_fitted;
  double new_over_fitted_spread = 0.0;  ///< relative standard error of what this says of all logs
  double sampling_s = 0.0;              ///< the shortest usual step of the logs
  double span_s = 0.0;                  ///< the longest log
  std::string sentence;                 ///< the one that a user needs
};

/// `penalty` is P, p x p, or empty. Weights, residuals and sensitivities are finite.
[[nodiscard]] TrustReport AssessTrust(std::span<const FittedRows> logs,
                                      const Eigen::MatrixXd& penalty,
                                      const std::vector<TrustedQuantity>& quantities,
                                      const TrustOptions& options = {});

/// The same of a positive quantity whose standard error comes from elsewhere: a few discharge
/// times, say. Without degrees of freedom left, or where the error is no number, it is not known.
[[nodiscard]] QuantityTrust TrustOfEstimate(std::string name,
                                            std::string unit,
                                            double estimate,
                                            double standard_error,
                                            double degrees_of_freedom);

/// What a user should do next, in one sentence: which parameters cannot be told apart by these
/// logs, and which experiment would tell them. The physics is in the names: beta, r_s, r_j, tau_j,
/// c_j, alpha. Tests: tests/identify/trust/trust_sentence_test.cc.
[[nodiscard]] std::string TrustSentence(const TrustReport& report);

/// The trust in a parameter; nullptr where the report does not have it.
[[nodiscard]] const QuantityTrust* FindQuantity(const TrustReport& trust, const std::string& name);

/// How far the 95 % interval reaches to either side; NaN or infinite as the standard error.
[[nodiscard]] double Reach95(const QuantityTrust& quantity);

}  // namespace lipoid
