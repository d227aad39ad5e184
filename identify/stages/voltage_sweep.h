#pragma once

/// @file
/// The residual of (4.60) and (4.61) and its exact sensitivities, in one pass over the logs.
///
///   r(k) = v_b(k) - v^_b(k | beta, r_s, r_j, tau_j)
///
/// Rows and slopes are those of every fit (identify/fit/cell_rows.h), with constant resistances and
/// alpha and v_oc(A) given. Value and Jacobian come from one sweep, and only the triangular factor
/// of [J r] is kept: see LeastSquaresProblem. Stretches of constant current are condensed
/// (condensed_log.h): the sums are those of all rows, at a fraction of the evaluations. Tests:
/// tests/identify/stages/voltage_sweep_test.cc (against Jets through CellModel).

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "identify/fit/observations.h"
#include "identify/logs/record.h"
#include "identify/stages/condensed_log.h"
#include "model/battery/cell_model.h"
#include "model/battery/error_metrics.h"
#include "model/battery/ranges.h"

namespace lipoid {

/// The parameters of stage 3. Time constants stand for capacitances: tau_j = r_j c_j.
struct SweepParameters {
  double beta_per_sqrt_s = 0.0;
  double series_resistance_Ohm = 0.0;
  std::vector<double> resistance_Ohm;
  std::vector<double> time_constant_s;
};

/// One log that takes part. The record must outlive the sweep.
struct SweepLog {
  const Record* record = nullptr;
  double initial_soc = 1.0;
  double weight = 1.0;  ///< of each row's square
};

/// Errors of a prediction over the rows of all logs, each row once.
struct SweepErrors {
  ErrorMetrics metrics;
  std::size_t rows_outside_curve = 0;  ///< rows whose A lies outside the range of v_oc(A)
};

/// The same as a solution of a fit: one node for every resistance, in Ohm.
struct JointSolution;
[[nodiscard]] JointSolution SolutionOf(const SweepParameters& parameters);
[[nodiscard]] SweepParameters ParametersOf(const JointSolution& solution);

class VoltageSweep : public Observations {
 public:
  VoltageSweep(JointSetup setup,
               std::vector<SweepLog> logs,
               const Condensation& how = Condensation::Exact());

  /// The same logs, condensed already.
  [[nodiscard]] VoltageSweep With(JointSetup setup) const;
  [[nodiscard]] VoltageSweep With(OpenCircuitVoltage curve) const;

  /// Columns of the Jacobian: beta, r_s, r_1 .. r_n, tau_1 .. tau_n; the residual is the last
  /// column.
  [[nodiscard]] static int Columns(int branches) { return 2 + 2 * branches; }

  /// Upper triangular factor of [J r], Columns + 1 square. Without the Jacobian only its last
  /// column is filled: zeros, and the norm of r at the bottom.
  [[nodiscard]] Eigen::MatrixXd Factor(const SweepParameters& parameters, bool jacobian) const;

  /// Not of a coarse sweep.
  [[nodiscard]] SweepErrors Errors(const SweepParameters& parameters) const;

  /// Residuals and sensitivities of every log, as Rows() has them, as means of rows over which
  /// little changes: short after a step of the current, longer the longer ago it was. All logs
  /// together have about `most` such rows, more only where the current itself changes as often:
  /// then means reach over its steps, and say less than the rows did. Not of a coarse sweep.
  [[nodiscard]] std::vector<FittedRows> Means(const JointStructure& structure,
                                              const JointRates& rates,
                                              const Eigen::VectorXd& x,
                                              std::size_t most) const;

  [[nodiscard]] std::unique_ptr<AtBeta> At(const JointRates& rates, bool slopes) const override;
  /// Means of rows: so many tell everything there is to know, in a few milliseconds.
  [[nodiscard]] std::vector<FittedRows> Rows(const JointStructure& structure,
                                             const JointRates& rates,
                                             const Eigen::VectorXd& x) const override {
    return Means(structure, rates, x, 8000);
  }
  [[nodiscard]] const FitScales& scales() const override { return scales_; }
  [[nodiscard]] const JointSetup& setup() const override { return setup_; }
  [[nodiscard]] const std::vector<SweepLog>& logs() const { return logs_; }
  /// Rows in all logs.
  [[nodiscard]] std::size_t rows() const;
  /// Points in all logs at which the model is evaluated, knots aside.
  [[nodiscard]] std::size_t points() const;

 private:
  class RowsAtBeta;
  template <class Visitor>
  void Sweep(std::size_t log,
             const JointStructure& structure,
             const JointRates& rates,
             const Eigen::VectorXd* x,
             Visitor& visitor) const;
  template <class Sum, class Add>
  [[nodiscard]] Sum SumOverLogs(const JointStructure& structure,
                                const JointRates& rates,
                                const Eigen::VectorXd* x,
                                const Sum& zero,
                                Add add) const;

  JointSetup setup_;
  FitScales scales_{.least_beta_per_sqrt_s = kLeastBeta_per_sqrt_s};
  std::vector<SweepLog> logs_;
  Condensation how_;
  std::shared_ptr<const std::vector<CondensedLog>> condensed_;  // the expensive part
};

}  // namespace lipoid
