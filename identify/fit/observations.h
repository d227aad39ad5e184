#pragma once

/// @file
/// Logs as a fit sees them: sums over their rows at given rates. Two kinds: the points of all logs of
/// a campaign (joint_sweep.h), and every row of some logs with v_oc(A) given (voltage_sweep.h).

#include <limits>
#include <memory>
#include <vector>

#include "identify/fit/sums.h"
#include "identify/joint/joint_model.h"
#include "identify/trust/trust.h"

namespace lipoid {

/// What scales the unknowns of a fit, and where its rates are searched.
struct FitScales {
  double typical_A = 1.0;   ///< linear unknowns are volts at this current (JointLayout)
  double largest_A = 0.0;   ///< of all currents
  double slowest_A = 0.0;   ///< of the currents of the logs, the least; only an offset asks
  double weight_sum = 0.0;  ///< of all rows
  double least_beta_per_sqrt_s = 1e-3;
  double shortest_tau_s = 0.0;  ///< time constants lie between these two
  double longest_tau_s = 0.0;
  double longest_start_tau_s = 0.0;  ///< none is looked for above it, but one may move there
  /// Between which states of charge loads were seen that tell a resistance.
  double lowest_loaded_soc = -std::numeric_limits<double>::infinity();
  double highest_loaded_soc = std::numeric_limits<double>::infinity();
};

class Observations {
 public:
  virtual ~Observations() = default;

  /// The logs with one beta (and E_d), and so with one A(t), which many time constants share.
  class AtBeta {
   public:
    virtual ~AtBeta() = default;
    [[nodiscard]] virtual NormalEquations Sum(const JointStructure& structure,
                                              const JointRates& rates) const = 0;
    /// At the linear unknowns x; v_oc's own slope between its nodes is that of a smooth curve.
    [[nodiscard]] virtual SlopeSums Slopes(const JointStructure& structure,
                                           const JointRates& rates,
                                           const Eigen::VectorXd& x) const = 0;
  };
  /// `slopes`: Slopes() will be asked for.
  [[nodiscard]] virtual std::unique_ptr<AtBeta> At(const JointRates& rates, bool slopes) const = 0;

  /// Rows, or means of rows, of each log, with the sensitivities of the voltage to the nonlinear
  /// parameters (RateSlots), then to the linear ones.
  [[nodiscard]] virtual std::vector<FittedRows> Rows(const JointStructure& structure,
                                                     const JointRates& rates,
                                                     const Eigen::VectorXd& x) const = 0;

  [[nodiscard]] virtual const JointSetup& setup() const = 0;
  [[nodiscard]] virtual const FitScales& scales() const = 0;
};

}  // namespace lipoid
