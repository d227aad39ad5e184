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

#include "identify/joint/joint_log.h"
#include "identify/joint/joint_model.h"

namespace lipoid {

/// What does not change while rates are searched.
struct JointSetup {
  double alpha_C = 0.0;
  bool diffusion = true;
  int terms = 10;
  bool tail = true;
  OpenCircuitVoltage reference;  ///< of v_oc(A); the curve itself where it is given
};

/// A(t) of every log for one beta: of each point, and of the start of the step that leads to it
/// under the step's current (CellModel takes r_j there).
struct SocTrace {
  std::vector<std::vector<double>> at;
  std::vector<std::vector<double>> start;
  double lowest = 1.0;
  double highest = 0.0;
};
[[nodiscard]] SocTrace TraceSoc(const JointLogs& logs,
                                const JointSetup& setup,
                                double beta_per_sqrt_s);

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
  Eigen::MatrixXd sensitivity;     ///< of the predicted voltage to the linear unknowns
};
[[nodiscard]] std::vector<JointRows> LinearRows(const JointLogs& logs,
                                                const JointSetup& setup,
                                                const JointStructure& structure,
                                                const JointRates& rates,
                                                const Eigen::VectorXd& x);

}  // namespace lipoid
