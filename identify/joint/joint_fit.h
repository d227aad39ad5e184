#pragma once

/// @file
/// Variable projection for a given structure: the rates from a grid, so that the global optimum is
/// found and not hoped for, then polished; for each of them all linear unknowns exactly.
///
///   minimize sum_logs W_l sum_k w_k (v_k - v_b(t_k))² + lambda² sum_tables |D x|²
///   with  resistances >= 0, v_oc not falling with A
///
/// A capacitance that is given or bounded holds r_j = tau_j/c_j: a bound that moves with tau_j.
/// D takes second differences along the nodes, and a tenth of the first ones for resistances; of
/// v_oc it takes them from the reference curve. lambda, the smoothness, only decides where the data
/// do not. Tests: tests/identify/joint/joint_fit_test.cc.

#include <algorithm>
#include <atomic>
#include <limits>
#include <string>
#include <vector>

#include "identify/fit/given.h"
#include "identify/fit/observations.h"
#include "identify/joint/joint_terms.h"
#include "identify/optimizers/levenberg_marquardt.h"
#include "identify/optimizers/summary.h"

namespace lipoid {

struct JointSolution {
  JointStructure structure;
  JointRates rates;
  double smoothness = 0.0;
  Eigen::VectorXd x;          ///< as JointLayout has it
  std::vector<char> active;   ///< bounds that hold, of v_oc's rises and of the resistances: 1 the
                              ///< lower, 2 the upper
  std::vector<char> follows;  ///< of each branch: c_j is held, so that r_j moves with tau_j
  double cost = std::numeric_limits<double>::infinity();    ///< with the penalty
  double square = std::numeric_limits<double>::infinity();  ///< without it
  std::vector<std::string> at_bound;                        ///< rates that stand at a bound
  Termination termination = Termination::kNotRun;           ///< of the last polish
  std::string message;                                      ///< why that ended

  [[nodiscard]] bool AtBound(const std::string& rate) const {
    return std::find(at_bound.begin(), at_bound.end(), rate) != at_bound.end();
  }
};

/// The same solution with its branches by rising time constant, those without resistance last: the
/// order of the cell file.
void SortBranches(JointSolution& solution);

/// Where the last polish ends: steps of the logarithms of the rates.
inline constexpr double kFineStep = 1e-3;

/// Where an approach ends: its step is one of the logarithms of the rates, which are some units.
inline constexpr LevenbergMarquardtOptions kApproach{.step_tolerance = 3e-4, .max_iterations = 20};

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
  /// Both must outlive the fit.
  JointFit(const Observations& seen, const GivenParameters& known)
      : JointFit(seen, known, seen.scales()) {}
  JointFit(const Observations& seen, const GivenParameters& known, const FitScales& scales)
      : seen_(seen), setup_(seen.setup()), known_(known), scales_(scales) {}

  /// The whole search: over a grid, or, from the rates of a neighbouring structure, over a thin grid
  /// of beta and whatever that structure lacks. So many of the best of the grid are followed down,
  /// each from a valley of its own unless v_oc is given; then tables also go on from constants that cost less.
  [[nodiscard]] JointSolution Search(const JointStructure& structure,
                                     double smoothness,
                                     const JointSolution* near = nullptr,
                                     int followed = 2) const;
  /// From its rates to a minimum nearby, in a few steps of Gauss and Newton.
  [[nodiscard]] JointSolution Approach(JointSolution from,
                                       const LevenbergMarquardtOptions& stop = kApproach) const;
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
  /// The linear unknowns that belong to these sums; `sum` need not be that of all rows.
  [[nodiscard]] JointSolution SolveSums(const JointStructure& structure,
                                        const JointRates& rates,
                                        double smoothness,
                                        const NormalEquations& sum,
                                        const std::vector<char>& guess,
                                        Eigen::MatrixXd* information = nullptr) const;
  /// Normal equations of the rates that were solved, and of the penalty: for standard errors.
  [[nodiscard]] Eigen::MatrixXd Penalty(const JointStructure& structure, double smoothness) const;

  [[nodiscard]] int evaluations() const { return evaluations_; }
  [[nodiscard]] const Observations& seen() const { return seen_; }

  /// Those that are searched, within the bounds that were given.
  [[nodiscard]] std::vector<JointRate> Rates(const JointStructure& structure) const;
  /// Rates that are not searched stand in what this returns.
  [[nodiscard]] JointRates Base(const JointStructure& structure) const;

 private:
  template <class Minimize>
  [[nodiscard]] JointSolution Descend(JointSolution from, Minimize&& minimize) const;
  [[nodiscard]] std::vector<double> BetaGrid(const JointStructure& structure,
                                             const JointRates* near) const;
  [[nodiscard]] std::vector<JointRates> RatesGrid(const JointStructure& structure,
                                                  const JointRates* near) const;
  static void Refine(const std::vector<int>& free,
                     const Eigen::MatrixXd& part,
                     SlopeSums& sums,
                     JointSolution& solution);

  const Observations& seen_;
  const JointSetup& setup_;
  const GivenParameters& known_;
  FitScales scales_;
  mutable std::atomic<int> evaluations_ = 0;
};

}  // namespace lipoid
