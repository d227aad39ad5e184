#pragma once

/// @file
/// The least squares of (4.60) and (4.61) as an optimizer sees it: which parameters are free, how
/// each is scaled, where it starts and what bounds it.
///
/// Parameters are beta, r_s, r_j and, for every branch, its time constant tau_j = r_j c_j or its
/// capacitance c_j. With time constants v_b is linear in r_s and r_j, which is what FitPulses
/// moves; capacitances are the thesis' own unknowns. A branch goes by its capacitance where the
/// options say so, or where the user fixes or bounds c_j. Tests:
/// tests/identify/stages/pulse_problem_test.cc.

#include <array>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "identify/fit/given.h"
#include "identify/optimizers/least_squares.h"
#include "identify/stages/start_values.h"
#include "identify/stages/voltage_sweep.h"

namespace lipoid {

/// What the optimizer moves instead of a parameter p.
enum class ParameterScale {
  kNatural,  ///< p itself, in SI units
  kTypical,  ///< p over a value typical of the data
  kLog,      ///< log of that
  kMixed,    ///< resistances over the typical one, the others as logarithms
};
constexpr std::array<std::pair<ParameterScale, std::string_view>, 4> OptionNames(ParameterScale) {
  return {{{ParameterScale::kNatural, "none"},
           {ParameterScale::kTypical, "typical"},
           {ParameterScale::kLog, "log"},
           {ParameterScale::kMixed, "mixed"}}};
}

/// The parameters of stage 3. Of a branch either capacitance_F[j] is NaN or it decides, and
/// time_constant_s[j] follows.
struct PulseParameters {
  SweepParameters sweep;
  std::vector<double> capacitance_F;
};

/// One free parameter: x = p/unit or log(p/unit).
struct PulseVariable {
  enum class Kind { kBeta, kSeriesResistance, kResistance, kTimeConstant, kCapacitance };

  std::string name;
  Kind kind = Kind::kBeta;
  std::size_t branch = 0;
  bool logarithmic = false;
  double unit = 1.0;
  double lower = 0.0;  ///< of p
  double upper = std::numeric_limits<double>::infinity();

  [[nodiscard]] double ToX(double p) const;
  [[nodiscard]] double FromX(double x) const;
  [[nodiscard]] double Slope(double p) const { return logarithmic ? p : unit; }  ///< dp/dx
  [[nodiscard]] bool resistive() const {
    return kind == Kind::kSeriesResistance || kind == Kind::kResistance;
  }
};

/// The parameter that the variable stands for.
[[nodiscard]] double& Entry(PulseParameters& p, const PulseVariable& v);
[[nodiscard]] double Entry(const PulseParameters& p, const PulseVariable& v);
/// Lets the capacitances decide: tau_j = r_j c_j.
void FollowCapacitances(PulseParameters& p);

/// Values that are typical of the data: where the search starts, and in which units.
struct PulseScales {
  double series_resistance_Ohm;
  double recovery_Ohm;    ///< what all branches together may have
  double relaxation_s;    ///< the time constant that relaxes most
  double shortest_tau_s;  ///< time constants lie between these two
  double longest_tau_s;

  /// Where the search for that of branch j of so many begins: spread over the decades around what
  /// relaxes most.
  [[nodiscard]] double TimeConstant(int j, int branches) const;
};
[[nodiscard]] PulseScales FindPulseScales(const StartValues& data, double alpha_C);

struct PulseProblemOptions {
  int branches = 1;
  double beta_start_per_sqrt_s = 0.2;
  bool capacitances = false;  ///< c_j stands beside r_j, in place of tau_j
  ParameterScale scale = ParameterScale::kMixed;
};

/// Which parameters are free, and the values that all of them start from.
struct PulseUnknowns {
  std::vector<PulseVariable> variables;
  PulseParameters start;
};

/// Throws OptionError where `known` names a parameter that is not there or contradicts itself.
[[nodiscard]] PulseUnknowns FindPulseUnknowns(const JointSetup& setup,
                                              const StartValues& data,
                                              const PulseProblemOptions& options,
                                              const GivenParameters& known);

/// The sweep must outlive the problem.
class PulseProblem : public LeastSquaresProblem {
 public:
  PulseProblem(const VoltageSweep& sweep,
               std::vector<PulseVariable> variables,
               PulseParameters base)
      : sweep_(sweep), variables_(std::move(variables)), base_(std::move(base)) {}

  [[nodiscard]] int size() const override { return static_cast<int>(variables_.size()); }
  [[nodiscard]] Eigen::VectorXd lower() const override { return Bound(&PulseVariable::lower); }
  [[nodiscard]] Eigen::VectorXd upper() const override { return Bound(&PulseVariable::upper); }
  [[nodiscard]] Eigen::MatrixXd Factor(const Eigen::VectorXd& x, bool jacobian) const override;

  [[nodiscard]] PulseParameters Parameters(const Eigen::VectorXd& x) const;
  [[nodiscard]] Eigen::VectorXd Point(const PulseParameters& p) const;
  [[nodiscard]] const std::vector<PulseVariable>& variables() const { return variables_; }

 private:
  [[nodiscard]] Eigen::VectorXd Bound(double PulseVariable::*which) const;

  const VoltageSweep& sweep_;
  std::vector<PulseVariable> variables_;
  PulseParameters base_;
};

}  // namespace lipoid
