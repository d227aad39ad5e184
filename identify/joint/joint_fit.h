#pragma once

/// @file
/// Variable projection for a given structure: the rates from a grid, so that the global optimum is
/// found and not hoped for, then polished; for each of them all linear unknowns exactly.
///
///   minimize sum_logs W_l sum_k w_k (v_k - v_b(t_k))² + lambda² sum_tables |D x|²
///   with  resistances >= 0, v_oc not falling with A
///
/// D takes second differences along the nodes, and a tenth of the first ones for resistances; of
/// v_oc it takes them from the reference curve. lambda, the smoothness, only decides where the data
/// do not. Tests: tests/identify/joint/joint_fit_test.cc.

#include <atomic>
#include <limits>
#include <string>
#include <vector>

#include "identify/fit/given.h"
#include "identify/joint/bounded_quadratic.h"
#include "identify/joint/joint_sweep.h"
#include "identify/optimizers/summary.h"

namespace lipoid {

struct JointSolution {
  JointStructure structure;
  JointRates rates;
  double smoothness = 0.0;
  Eigen::VectorXd x;          ///< as JointLayout has it
  std::vector<char> at_zero;  ///< bounds that hold: of v_oc's rises and of the resistances
  double cost = std::numeric_limits<double>::infinity();    ///< with the penalty
  double square = std::numeric_limits<double>::infinity();  ///< without it
  std::vector<std::string> at_bound;                        ///< rates that stand at a bound
  Termination termination = Termination::kNotRun;           ///< of the last polish
  std::string message;                                      ///< why that ended
};

/// The same solution with its branches by rising time constant: the order of the cell file.
void SortBranches(JointSolution& solution);

/// What leaving groups of rows out says of a structure at its rates. Weighted means of the errors'
/// sizes, since a few rows at the end of a discharge outweigh all others in a sum of squares, and
/// the sums of the units (paired_errors.h) behind the mean. NaN and empty without two groups.
struct LeftOutErrors {
  double smoothness = 0.0;
  double fitted_V = std::numeric_limits<double>::quiet_NaN();    ///< with the groups in the fit
  double left_out_V = std::numeric_limits<double>::quiet_NaN();  ///< each predicted by the others
  /// 0.368 fitted + 0.632 left out: what to expect of new rows (Efron 1983). A piece that is left
  /// out whole is harder to predict than a new log of the same cell is.
  double expected_V = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> unit_V = {};  ///< what is expected of each unit, times its weight
};

/// A smoothness that predicts rows left out no worse than the best one by this share is as good:
/// the least such is taken, as it follows the data most closely.
inline constexpr double kSmoothnessLoss = 0.02;

/// Where the last polish ends: steps of the logarithms of the rates.
inline constexpr double kFineStep = 1e-3;

/// Evaluations that a polish may take for each rate: it takes 10 to 20.
inline constexpr int kPolishIterationsPerVariable = 40;

/// Residuals' slopes in the rates that are searched, less what the free linear unknowns follow: J'J
/// and J'r with J = (I - A A^+) dr/drate (Kaufman 1975), r the weighted residuals and the penalty.
struct ProjectedSlopes {
  Eigen::MatrixXd square;
  Eigen::VectorXd with_residual;
};

class JointFit {
 public:
  JointFit(const JointLogs& logs, const JointSetup& setup, const GivenParameters& known);

  /// The whole search: over a grid, or, from the rates of a neighbouring structure, over a thin grid
  /// of beta and whatever that structure lacks.
  [[nodiscard]] JointSolution Search(const JointStructure& structure,
                                     double smoothness,
                                     const JointSolution* near = nullptr) const;
  /// From its rates to a minimum nearby, in a few steps of Gauss and Newton.
  [[nodiscard]] JointSolution Approach(JointSolution from) const;
  /// The same by direct search, until the logarithms of the rates move by less than the
  /// tolerance.
  [[nodiscard]] JointSolution Polish(
      JointSolution from,
      double step_tolerance,
      int iterations_per_variable = kPolishIterationsPerVariable) const;
  /// The linear unknowns at these rates.
  [[nodiscard]] JointSolution Solve(const JointStructure& structure,
                                    const JointRates& rates,
                                    double smoothness,
                                    const std::vector<char>& guess = {},
                                    ProjectedSlopes* slopes = nullptr) const;
  /// The least smoothness of the rising ladder that predicts rows left out as well as any, but for
  /// kSmoothnessLoss.
  [[nodiscard]] LeftOutErrors LeaveOut(const JointStructure& structure,
                                       const JointRates& rates,
                                       const std::vector<double>& ladder) const;
  /// Normal equations of the rates that were solved, and of the penalty: for standard errors.
  [[nodiscard]] Eigen::MatrixXd Penalty(const JointStructure& structure, double smoothness) const;

  [[nodiscard]] int evaluations() const { return evaluations_; }
  [[nodiscard]] double shortest_tau_s() const { return shortest_tau_s_; }
  [[nodiscard]] double longest_tau_s() const { return longest_tau_s_; }

  /// A rate that is searched: its name, and bounds.
  struct Rate {
    std::string name;
    double lower, upper;
    double* (*entry)(JointRates&, int);
    int index;
    int slot;  ///< in RateSlots
  };
  [[nodiscard]] std::vector<Rate> Rates(const JointStructure& structure) const;
  /// Beta and time constants that are not searched stand in the rates that this returns.
  [[nodiscard]] JointRates Base(const JointStructure& structure) const;

 private:
  template <class Minimize>
  [[nodiscard]] JointSolution Descend(JointSolution from, Minimize&& minimize) const;
  [[nodiscard]] std::vector<double> BetaGrid(const JointStructure& structure,
                                             const JointRates* near) const;
  [[nodiscard]] std::vector<JointRates> RatesGrid(const JointStructure& structure,
                                                  const JointRates* near) const;
  [[nodiscard]] JointSolution SolveSums(const JointStructure& structure,
                                        const JointRates& rates,
                                        double smoothness,
                                        const NormalEquations& sum,
                                        const std::vector<char>& guess,
                                        Eigen::MatrixXd* information = nullptr) const;

  const JointLogs& logs_;
  const JointSetup& setup_;
  const GivenParameters& known_;
  double shortest_tau_s_ = 0.0;
  double longest_tau_s_ = 0.0;
  mutable std::atomic<int> evaluations_ = 0;
};

}  // namespace lipoid
