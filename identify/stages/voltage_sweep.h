#pragma once

/// @file
/// The residual of (4.60) and (4.61) and its exact sensitivities, in one pass over the logs.
///
///   r(k) = v_b(k) - v^_b(k | beta, r_s, r_j, tau_j)
///
/// Every state is a first-order mode (exact_hold.h), so its sensitivity to the mode's own rate
/// obeys a recurrence of the same shape,
///
///   x+  = p x  + g i
///   x'+ = p x' + p' x + g' i
///
/// and v_b is linear in r_s and r_j. Value and Jacobian therefore come from one sweep, and only the
/// triangular factor of [J r] is kept: see LeastSquaresProblem. alpha and v_oc(A) are given.
/// Tests: tests/identify/stages/voltage_sweep_test.cc (against Jets through CellModel).

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "identify/logs/record.h"
#include "model/battery/cell_model.h"

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
  double weight = 1.0;                  ///< of each row's square
  std::vector<double> row_weight = {};  ///< empty: 1 each
};

/// What stays as it is while parameters are searched.
struct SweepSetup {
  double alpha_C = 0.0;
  bool diffusion = true;
  int terms = 10;
  bool tail = true;
  OpenCircuitVoltage open_circuit_voltage;
};

class VoltageSweep {
 public:
  VoltageSweep(SweepSetup setup, std::vector<SweepLog> logs);

  /// Columns of the Jacobian: beta, r_s, r_1 .. r_n, tau_1 .. tau_n; the residual is the last
  /// column.
  [[nodiscard]] static int Columns(int branches) { return 2 + 2 * branches; }

  /// Upper triangular factor of [J r], Columns + 1 square. Without the Jacobian only its last
  /// column is filled: zeros, and the norm of r at the bottom.
  [[nodiscard]] Eigen::MatrixXd Factor(const SweepParameters& parameters, bool jacobian) const;

  [[nodiscard]] const SweepSetup& setup() const { return setup_; }
  [[nodiscard]] const std::vector<SweepLog>& logs() const { return logs_; }
  /// Rows in all logs.
  [[nodiscard]] std::size_t rows() const;

 private:
  [[nodiscard]] Eigen::MatrixXd LogFactor(const SweepLog& log,
                                          const SweepParameters& parameters,
                                          bool jacobian) const;

  SweepSetup setup_;
  std::vector<SweepLog> logs_;
};

}  // namespace lipoid
