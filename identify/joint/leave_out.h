#pragma once

/// @file
/// What leaving groups of rows out says of a structure at its rates. Weighted means of the errors'
/// sizes, since a few rows at the end of a discharge outweigh all others in a sum of squares.
/// Tests: tests/identify/joint/joint_fit_test.cc.

#include <limits>
#include <vector>

#include "identify/joint/joint_fit.h"
#include "identify/joint/joint_sweep.h"
#include "identify/trust/trust.h"

namespace lipoid {

/// NaN and empty without two groups.
struct LeftOutErrors {
  double smoothness = 0.0;
  double fitted_V = std::numeric_limits<double>::quiet_NaN();    ///< with the groups in the fit
  double left_out_V = std::numeric_limits<double>::quiet_NaN();  ///< each predicted by the others
  /// 0.368 fitted + 0.632 held out: what to expect of new rows (Efron 1983). A piece that is left
  /// out whole is harder to predict than a new log of the same cell is.
  double expected_V = std::numeric_limits<double>::quiet_NaN();
  /// What is expected of each unit (paired_errors.h), times its weight.
  std::vector<double> unit_V = {};
};

/// A smoothness that predicts held-out rows no worse than the best one by this share is as good:
/// the least such is taken, as it follows the data most closely.
inline constexpr double kSmoothnessLoss = 0.02;

/// The least smoothness of the rising ladder that predicts left-out pieces as well as any, but for
/// kSmoothnessLoss, and what is to be expected of left-out stretches with it. `fit` is one of these logs.
[[nodiscard]] LeftOutErrors LeaveOut(const JointFit& fit,
                                     const JointLogs& logs,
                                     const JointStructure& structure,
                                     const JointRates& rates,
                                     const std::vector<double>& ladder);

/// The mean error (4.57) that a new log of the kinds of these is to be expected to have, in percent of
/// the voltage: every log counts the same. It is the larger of two: by the same rule, which knows what
/// the structure cannot follow; and the fitted error times what the fit has followed of noise, which
/// held-out rows beside others in the same slow noise do not show. The 95 % interval is that of the
/// mean over such logs, from the scatter of the units and of such noise; one log scatters more. NaN
/// without two groups.
struct ExpectedError {
  double percent = std::numeric_limits<double>::quiet_NaN();
  double low_percent = std::numeric_limits<double>::quiet_NaN();
  double high_percent = std::numeric_limits<double>::quiet_NaN();
};

/// The rates of the solution stay, all else is found anew without each group. `trust` is that in the
/// solution by these logs.
[[nodiscard]] ExpectedError ExpectError(const JointFit& fit,
                                        const JointLogs& logs,
                                        const JointSolution& solution,
                                        const TrustReport& trust);

}  // namespace lipoid
