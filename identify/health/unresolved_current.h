#pragma once

/// @file
/// What flows between the values of a current that come too seldom to follow it.
///
/// A log with a row each second shows what a drone drew at instants. In between it drew something else: its voltage
/// at a row follows the current of the row, but the charge that left, and every state of the cell that remembers it,
/// follow the mean. To hold a value until the next would make the cell remember currents that it never saw, and bend
/// every estimate (errors in variables). Of values a step apart g(1) is half the mean square of what they differ by,
/// g(2) that of every other one: a current that is followed moves twice as far in two steps, and 2 g(1) - g(2) is what
/// changes in between (the nugget of a straight variogram; Cressie, Statistics for Spatial Data, 1993, chapter 2). That
/// part of what a value differs from its neighbours by is taken to have flowed on average as little above as below.
/// What remains, independent from value to value, makes the charge walk away at random. Values that are means change as
/// much, and each is what flowed: which of the two a log has the fit tells (FitAsFlowed). Tests:
/// tests/identify/health/unresolved_current_test.cc, tests/identify/health/coverage_test.cc.

#include <Eigen/Core>
#include <vector>

#include "identify/logs/record.h"

namespace lipoid {

struct UnresolvedCurrent {
  /// Rows with a new value, in order.
  std::vector<std::size_t> rows;
  double between_s = 0.0;  ///< the median time between them
  std::vector<double>
      deviation_A;        ///< standard deviation of the mean current beside each, from `flowed_A`
  double charge_C = 0.0;  ///< of the charge of all, therefore
  Column flowed_A;        ///< the mean current since the row before, at each row

  [[nodiscard]] bool any() const { return !flowed_A.empty(); }
  /// The largest of the deviations.
  [[nodiscard]] double most_A() const;
  /// What may have flowed on average since the row before, beside flowed_A, at each row: the slowest `count` of the
  /// orthogonal modes of what is independent from value to value, cosines, each times its standard deviation. Faster
  /// ones leave no charge behind, and look like noise of the voltage. Rows x count; none where nothing is unresolved.
  [[nodiscard]] Eigen::MatrixXd Modes(int count) const;
};

/// Of rows whose current has a new value each update_s. Nothing where they follow it, or are too few to tell.
[[nodiscard]] UnresolvedCurrent FindUnresolved(const Record& record, double update_s);

}  // namespace lipoid
