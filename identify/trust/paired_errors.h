#pragma once

/// @file
/// Whether one model predicts held-out data better than another by more than chance would.
///
/// Data are held out in units whose errors are independent of one another: a pulse with the rest
/// that follows it, a long stretch of a discharge. Neighbouring rows are not. Both models predict
/// the same units, so that what makes a unit hard to predict for both drops out of the difference:
///
///   d_u  = e_u(simple) - e_u(rich),   gain = sum_u W_u d_u / sum_u W_u
///   s²   = n/(n-1) sum_u W_u² (d_u - gain)² / (sum_u W_u)²
///
/// with e_u the mean error of the unit, W_u its weight and s the standard error of the gain. A few
/// units at the end of a discharge may outweigh all others in the mean, so that the question whether
/// the rich model is asked for goes to the ranks R_u of |d_u| (Wilcoxon 1945), with which every unit
/// has its say:
///
///   z = sum_u sign(d_u) R_u / sqrt(sum_u R_u²)
///
/// It is where gain > 0 and z > kStandardErrors: z is a standard normal number where neither model
/// is better, and chance alone asks once in 44 times. The simplest model within so many standard
/// errors of the best is the rule of Breiman, Friedman, Olshen and Stone (1984), who take one: with
/// half a dozen models to compare one would take a richer model than the truth in every third case.
/// Tests: tests/identify/trust/paired_errors_test.cc.

#include <vector>

namespace lipoid {

inline constexpr double kStandardErrors = 2.0;

struct PairedGain {
  double gain = 0.0;            ///< positive: the rich model predicts better
  double standard_error = 0.0;  ///< infinite with fewer than two units
  double ranks = 0.0;           ///< z of the signed ranks

  [[nodiscard]] bool AskedFor() const { return gain > 0.0 && ranks > kStandardErrors; }
  /// How probable it is that the rich model predicts better, if gains are normal.
  [[nodiscard]] double Probability() const;
};

/// W_u e_u of both models, and W_u; units of no weight do not count. A model that could not
/// predict a unit (an error that is not finite) is never better.
[[nodiscard]] PairedGain CompareErrors(const std::vector<double>& simple,
                                       const std::vector<double>& rich,
                                       const std::vector<double>& weight);

}  // namespace lipoid
