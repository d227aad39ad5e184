#pragma once

/// @file
/// Forms of a curve v_oc(A), each by least squares over rows under load, of which a fit may be
/// shown all or a part.
///
/// On nodes, with straight lines between (curve_on_nodes.cc): nodes stand densely where the curve
/// falls fast, for they share out its length. Of smooth functions over the whole range
/// (curve_in_basis.cc): Chebyshev polynomials, or harmonics whose frequency is found, too.
/// Tests: tests/identify/stages/open_circuit_voltage_fit_test.cc.

#include <cstddef>
#include <span>
#include <vector>

#include "model/battery/open_circuit_voltage.h"

namespace lipoid {

/// Rows under load, in the order of time, and the range that the curve is to span.
struct CurveRows {
  std::span<const double> soc;
  std::span<const double> voltage_V;
  double lo = 0.0;
  double hi = 1.0;

  [[nodiscard]] std::size_t size() const { return soc.size(); }
};

/// The rows that a fit is shown: all, or all but every n-th.
struct Share {
  int every = 0;  ///< 0: all rows are shown

  // The held-out rows.
  [[nodiscard]] std::size_t first() const { return static_cast<std::size_t>(every / 2); }
  [[nodiscard]] std::size_t step() const { return static_cast<std::size_t>(every); }

  [[nodiscard]] bool Has(std::size_t row) const { return every == 0 || row % step() != first(); }
};

/// Least squares over the values at the nodes: a tridiagonal system, summed over rows.
struct NodeSums {
  double middle_V = 0.0;  ///< what the sums are taken about: near zero squares keep more digits
  std::vector<double> diagonal, beside, right;  ///< entry k of beside couples k and k+1
  std::vector<double> rows;                     ///< in the interval above each node

  explicit NodeSums(std::size_t nodes)
      : diagonal(nodes, 0.0), beside(nodes, 0.0), right(nodes, 0.0), rows(nodes, 0.0) {}

  void Add(const NodeSums& other, double factor);
  /// The values; every interval holds a row.
  [[nodiscard]] std::vector<double> Solve() const;
};

/// Nodes with the sums of every row and of those to be held out: either fit follows from them.
/// Without nodes a curve joins its rows, which is right for few.
struct NodeTask {
  std::vector<double> nodes;
  NodeSums all{0};
  NodeSums left_out{0};
};

/// With `count` nodes, or fewer where rows stand together; `judged` are the rows to be held out.
[[nodiscard]] NodeTask MakeNodeTask(const CurveRows& rows, int count, const Share& judged);

struct CurveNodes {
  std::vector<double> soc;
  std::vector<double> voltage_V;
};

/// By the rows that are shown, all or those that the task does not hold out. They are joined where
/// they are too few for four nodes.
[[nodiscard]] CurveNodes FitOnNodes(const NodeTask& task,
                                    const CurveRows& rows,
                                    const Share& shown);

/// The nearest values that do not fall: noise must not make a curve that is to be monotone go back.
void MakeMonotone(std::vector<double>& values);

[[nodiscard]] OpenCircuitVoltage FitPolynomial(const CurveRows& rows,
                                               const Share& shown,
                                               int degree);

[[nodiscard]] OpenCircuitVoltage FitFourier(const CurveRows& rows,
                                            const Share& shown,
                                            int harmonics);

}  // namespace lipoid
