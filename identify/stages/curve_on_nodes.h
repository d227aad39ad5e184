#pragma once

/// @file
/// A curve v_oc(A) on nodes: where the nodes stand, and the values there by least squares over rows,
/// with straight lines between. Nodes stand densely where the curve falls fast, for they share out
/// its length.
/// Tests: tests/identify/stages/open_circuit_voltage_fit_test.cc.

#include <cstddef>
#include <vector>

#include "identify/stages/curve_rows.h"

namespace lipoid {

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

}  // namespace lipoid
