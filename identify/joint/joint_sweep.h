#pragma once

/// @file
/// One pass over all logs for given rates: the normal equations of the linear unknowns, summed
/// apart for every group of rows that may be left out.
///
/// A row touches two nodes of each table and the few nodes of a branch whose share has not decayed,
/// so that a row costs tens of multiplications and not the square of the number of unknowns.
/// Voltages are counted from a reference curve, which keeps the sums from cancelling.
/// Tests: tests/identify/joint/joint_sweep_test.cc.

#include <Eigen/Core>
#include <vector>

#include "identify/fit/cell_rows.h"
#include "identify/joint/joint_log.h"
#include "identify/joint/joint_model.h"

namespace lipoid {

/// A(t) of one log for one beta: of each point, and of the start of the step that leads to it under
/// the step's current (CellModel takes r_j there); their slopes in beta where they were asked for.
struct LogTrace {
  std::vector<double> at;
  std::vector<double> start;
  std::vector<double> at_slope;
  std::vector<double> start_slope;
};
struct SocTrace {
  std::vector<LogTrace> logs;
  double lowest = 1.0;
  double highest = 0.0;
};
[[nodiscard]] SocTrace TraceSoc(const JointLogs& logs,
                                const JointSetup& setup,
                                double beta_per_sqrt_s,
                                bool slopes = false);

/// sum w (y - a'x)² = square - 2 right'x + x' matrix x over the rows of one group, with y counted
/// from the reference. Only the lower triangle of the matrix is filled.
struct NormalEquations {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
  double square = 0.0;
  double weight = 0.0;

  explicit NormalEquations(int n = 0)
      : matrix(Eigen::MatrixXd::Zero(n, n)), right(Eigen::VectorXd::Zero(n)) {}
  void Add(const NormalEquations& other, double sign = 1.0);
  /// The sum at x.
  [[nodiscard]] double At(const Eigen::VectorXd& x) const;
};

/// Of each group 0 .. logs.groups - 1, then of the rows that are never left out. Unknowns as in
/// JointLayout; voltages are those of the nodes above the reference's at the nodes.
[[nodiscard]] std::vector<NormalEquations> SumGroups(const JointLogs& logs,
                                                     const JointSetup& setup,
                                                     const JointStructure& structure,
                                                     const SocTrace& soc,
                                                     const JointRates& rates);
/// Of all rows together, in a tenth of the time.
[[nodiscard]] NormalEquations SumAll(const JointLogs& logs,
                                     const JointSetup& setup,
                                     const JointStructure& structure,
                                     const SocTrace& soc,
                                     const JointRates& rates);

/// What the slopes S of the predicted voltage in the nonlinear parameters (RateSlots) sum to at the
/// unknowns x, with the residual r = y - a'x: sum w S S', sum w S r, sum w S a'.
struct SlopeSums {
  Eigen::MatrixXd of_rates;
  Eigen::VectorXd with_residual;
  Eigen::MatrixXd with_linear;

  void Add(const SlopeSums& other);
};
/// The trace must have slopes.
[[nodiscard]] SlopeSums SumSlopes(const JointLogs& logs,
                                  const JointSetup& setup,
                                  const JointStructure& structure,
                                  const SocTrace& soc,
                                  const JointRates& rates,
                                  const Eigen::VectorXd& x,
                                  CurveSlope curve);

/// Weighted sums of the errors' sizes over the rows of each unit, for s = 0 .. candidates - 1, each
/// group predicted with unknowns of its own: unknowns[group][s]. An empty vector counts as
/// infinitely wrong.
[[nodiscard]] std::vector<std::vector<double>> SumErrors(
    const JointLogs& logs,
    const JointSetup& setup,
    const JointStructure& structure,
    const SocTrace& soc,
    const JointRates& rates,
    const std::vector<std::vector<Eigen::VectorXd>>& unknowns);

/// The points of one log that have a weight, at a solution.
struct JointRows {
  std::vector<std::size_t> point;  ///< in the log
  Eigen::VectorXd residual_V;      ///< measured less predicted
  /// Of the predicted voltage: to the nonlinear parameters (RateSlots), then to the linear ones.
  Eigen::MatrixXd sensitivity;
};
[[nodiscard]] std::vector<JointRows> AllRows(const JointLogs& logs,
                                             const JointSetup& setup,
                                             const JointStructure& structure,
                                             const JointRates& rates,
                                             const Eigen::VectorXd& x,
                                             CurveSlope curve = CurveSlope::kOfSegments);

}  // namespace lipoid
