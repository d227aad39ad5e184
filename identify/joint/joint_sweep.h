#pragma once

/// @file
/// One pass over all logs for given rates: the normal equations of the linear unknowns, summed
/// apart for every group of rows that may be left out.
///
/// A row touches two nodes of each table and the few nodes of a branch whose share has not decayed,
/// so that a row costs tens of multiplications and not the square of the number of unknowns.
/// Tests: tests/identify/joint/joint_sweep_test.cc.

#include <Eigen/Core>
#include <vector>

#include "identify/fit/observations.h"
#include "identify/joint/joint_log.h"
#include "identify/joint/joint_model.h"

namespace lipoid {

/// A(t) of one log for one beta, E_d, offset and alpha: of each point, and of the start of the step
/// that leads to it under the step's current (CellModel takes r_j there); their slopes where they
/// were asked for and there are any.
struct LogTrace {
  std::vector<double> at;
  std::vector<double> start;
  std::vector<SocSlopes> at_slopes;
  std::vector<SocSlopes> start_slopes;
};
struct SocTrace {
  std::vector<LogTrace> logs;
  double lowest = 1.0;
  double highest = 0.0;
};
[[nodiscard]] SocTrace TraceSoc(const JointLogs& logs,
                                const JointSetup& setup,
                                const JointRates& rates,
                                bool slopes = false);

/// What is swept, and where; all of it must outlive this.
struct AtRates {
  const JointLogs& logs;
  const JointSetup& setup;
  const JointStructure& structure;
  const SocTrace& soc;  ///< of the same rates
  const JointRates& rates;
};

/// Of each group 0 .. by.groups - 1, then of the rows that are never left out. Unknowns as in
/// JointLayout; voltages are those of the nodes above the reference's at the nodes.
[[nodiscard]] std::vector<NormalEquations> SumGroups(const AtRates& sweep, const Grouping& by);

/// What of an error counts: its size times the weight of its row, or its size in percent of the
/// voltage, of every row the same.
enum class ErrorSize { kWeighted_V, kPercentOfRows };

/// Sums of the errors' sizes over the rows of each unit, for s = 0 .. candidates - 1, each
/// group predicted with unknowns of its own: unknowns[group][s]. An empty vector counts as
/// infinitely wrong. To `always`, one sum per log, what is in no group is added, by the first group's unknowns.
[[nodiscard]] std::vector<std::vector<double>> SumErrors(
    const AtRates& sweep,
    const Grouping& by,
    const std::vector<std::vector<Eigen::VectorXd>>& unknowns,
    ErrorSize size = ErrorSize::kWeighted_V,
    std::vector<double>* always = nullptr);

/// All logs of a campaign at their points.
class JointObservations : public Observations {
 public:
  /// Both must outlive this.
  JointObservations(const JointLogs& logs, const JointSetup& setup);

  [[nodiscard]] std::unique_ptr<AtBeta> At(const JointRates& rates, bool slopes) const override;
  /// With the slope of v_oc that `curve` says.
  [[nodiscard]] std::vector<FittedRows> Rows(const JointStructure& structure,
                                             const JointRates& rates,
                                             const Eigen::VectorXd& x,
                                             CurveSlope curve) const;
  /// With the smooth one. The straight lines' own slopes saw about it from node to node, and as no
  /// smooth term follows a saw, what it says of beta would count as known: the cost itself, whose
  /// kinks move along, does not rise by it.
  [[nodiscard]] std::vector<FittedRows> Rows(const JointStructure& structure,
                                             const JointRates& rates,
                                             const Eigen::VectorXd& x) const override {
    return Rows(structure, rates, x, CurveSlope::kSmooth);
  }
  [[nodiscard]] const JointSetup& setup() const override { return setup_; }
  [[nodiscard]] const FitScales& scales() const override { return scales_; }

 private:
  const JointLogs& logs_;
  const JointSetup& setup_;
  FitScales scales_;
};

}  // namespace lipoid
