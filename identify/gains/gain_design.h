#pragma once

/// @file
/// Controller gains by optimization: the integral of the squared error over a maneuver, at xi = 1
/// (battery-unaware) or summed over several xi (battery-aware), (5.49)-(5.50) and (6.2)-(6.5).
/// Motor lag and saturation are included: without them the error at xi = 1 is zero for any gains.
/// Gains are bounded, their gradient is exact, and every optimizer of the table takes the problem.
///
/// A maneuver that the references alone fly well says little about the feedback: the least error may
/// be that of gains which grow more slowly than the maneuver lasts. Gains are therefore an answer
/// only where the loop would still be stable with kStabilityMargin times the gain or the lag. Where
/// the least error does not keep that margin, what it lacks becomes a part of the cost.
///
/// The altitude's maneuvers start where the integral holds the hover of their voltage, so that none
/// of them needs an integral gain; a battery that empties does. Without one hover at xi < 1 is no
/// equilibrium, and an altitude loop counts as stable only where it forgets a wrong hover by
/// kAltitudeDecay_per_s. Its maneuvers push nothing aside either: an attitude loop, other than that of
/// the thesis' vehicle and problem, must forget an error by a tenth of what gains placed for its motors
/// have.
/// Tests: tests/identify/gains/gain_design_test.cc.

#include <array>
#include <string_view>
#include <vector>

#include "identify/gains/reduced_loops.h"
#include "identify/optimizers/least_squares.h"
#include "identify/optimizers/optimizers.h"
#include "model/analysis/stability.h"

namespace lipoid {

/// How much higher or lower the loop's gain, and how much longer the motors' lag, may be.
inline constexpr double kStabilityMargin = 1.25;

/// The pole of the integral is about -K_eI/K_e: a wrong hover is gone after 20 s to 1/e.
inline constexpr double kAltitudeDecay_per_s = 0.05;

/// What an attitude loop must have of the distance at which gains are placed (placed_gains.h).
inline constexpr double kAttitudeDecayOfPlaced = 0.1;

struct GainDesignOptions {
  double proportional_bound = 0.0;
  double integral_bound = 0.0;
  double derivative_bound = 0.0;
  double step_m = 0.4;
  double duration_s = 0.0;
  bool motor_lag = true;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    const Range bound{0.0, 1e6};
    v("proportional_bound",
      self.proportional_bound,
      bound,
      "largest K_e in 1/s²; 0: 10 for the altitude, 1 for the attitude, as the thesis, or four times "
      "the start's");
    v("integral_bound", self.integral_bound, bound, "largest K_eI in 1/s³; 0: as for K_e");
    v("derivative_bound", self.derivative_bound, bound, "largest K_edot in 1/s; 0: as for K_e");
    v("step_m", self.step_m, Range{1e-6, 100.0}, "height of the commanded step of the altitude, m");
    v("duration_s",
      self.duration_s,
      Range{0.0, 1e4},
      "simulated time t_f, s; 0: 5 s for the altitude, 50 s for the attitude, as the thesis");
    v("motor_lag", self.motor_lag, Names(), "whether motors take time to change their speed");
  }
};

/// One xi of the sum, and its weight.
struct WeightedXi {
  double xi;
  double weight;
};

struct GainDesign {
  Loop loop = Loop::kAltitude;
  Vehicle vehicle;
  std::vector<WeightedXi> xi;
  ControllerOptions controller;
  GainDesignOptions options;
  ErrorGains altitude_gains;  ///< held while the attitude is designed
  References references = {};
  double attitude_decay_per_s =
      0.0;  ///< the slowest with which an attitude loop may forget an error
};

/// kAttitudeDecayOfPlaced of this vehicle; 0 for the thesis', whose bounds leave no such gains.
[[nodiscard]] double AttitudeDecayFor(const Vehicle& vehicle);

/// Fills in the bounds that were not given where the start is beyond the thesis' bounds, which are
/// those of its vehicle: four times the start.
void WidenBounds(GainDesign& design, const ErrorGains& start);

/// The maneuver of a design: a step up of the altitude, or Fig 6.9's pitch.
[[nodiscard]] FlightPlan DesignPlan(const GainDesign& design);

/// A parameter of the search that its answer has at the largest or the smallest value allowed.
struct GainBound {
  std::string_view gain;  ///< "proportional", as keys and options name it
  double value = 0.0;
  bool largest = false;
};

/// Parameters are the gains over their bounds; 1/2 ||r||² is half of the cost. For the control law
/// lqr they are the regulator's weights over the same bounds, from which the gains follow: w_I, and
/// the squares of w_e and w_d, for no gradient leaves a root that is 0.
class GainProblem : public LeastSquaresProblem {
 public:
  /// Each xi adds the square of what its loop lacks in stability, in 1/s, times this weight.
  explicit GainProblem(const GainDesign& design, double stability_weight = 0.0);

  [[nodiscard]] int size() const override { return 3; }
  [[nodiscard]] Eigen::VectorXd lower() const override {
    // A regulator has an integral.
    return Eigen::Vector3d(0.0, regulator_ ? kLeastIntegral : 0.0, 0.0);
  }
  [[nodiscard]] Eigen::VectorXd upper() const override { return Eigen::VectorXd::Ones(3); }
  [[nodiscard]] Eigen::MatrixXd Factor(const Eigen::VectorXd& x, bool jacobian) const override;
  [[nodiscard]] double Cost(const Eigen::VectorXd& x) const override;

  [[nodiscard]] const ErrorGains& bounds() const { return bounds_; }
  [[nodiscard]] ErrorGains Gains(const Eigen::VectorXd& x) const;
  [[nodiscard]] std::vector<GainBound> AtBound(const Eigen::VectorXd& x) const;
  [[nodiscard]] Eigen::VectorXd Point(const ErrorGains& gains) const;
  /// sum_i w_i integral of e² dt, (6.3): m² s, or rad² s.
  [[nodiscard]] double CostOf(const ErrorGains& gains) const;
  /// The same of each xi, without its weight.
  [[nodiscard]] std::vector<double> CostsOf(const ErrorGains& gains) const;
  /// Whether the loop keeps kStabilityMargin and its decay at every xi.
  [[nodiscard]] bool Stable(const ErrorGains& gains) const;

 private:
  template <class T, class Visit>
  void Run(std::size_t k, const BasicErrorGains<T>& gains, Visit&& visit) const;

  [[nodiscard]] Growth GrowthIn(const AxisResponse& response, const ErrorGains& gains) const;

  // What each loop that must be stable lacks in 1/s, with its slopes in the gains.
  [[nodiscard]] std::vector<Growth> Lacks(const ErrorGains& gains) const;

  // Gains and their slopes in the three parameters.
  struct Parameterised {
    ErrorGains gains;
    std::array<ErrorGains, 3> slopes;
  };
  [[nodiscard]] Parameterised At(const Eigen::VectorXd& x) const;

  static constexpr double kLeastIntegral = 1e-4;  // of its bound

  GainDesign design_;
  bool regulator_;
  double stability_weight_;
  std::vector<AxisResponse> responses_;  // of each xi, with all combinations of the margins
  ErrorGains bounds_;
  std::vector<LoopTask> tasks_;
  std::vector<FlightCommand> commands_;
};

/// Where a search ended.
struct FoundGains {
  ErrorGains gains;
  std::vector<GainBound> at_bound;  ///< of the control law lqr these are roots of weights
  double cost = 0.0;                ///< of gains, as CostOf
  bool stable = false;              ///< with kStabilityMargin at every xi; false: no answer
  bool constrained = false;         ///< the least error alone did not keep the margin
};

struct GainDesignResult {
  FoundGains search;  ///< what the optimizer found
  /// What Levenberg-Marquardt finds from there on; the same where that is nothing better.
  FoundGains polished;
  double start_cost = 0.0;  ///< of the gains it started from
  OptimizationSummary optimization;

  /// The search ended beside the least error: more than a hundredth of its cost was left.
  [[nodiscard]] bool missed() const { return polished.cost < 0.99 * search.cost; }
  [[nodiscard]] const FoundGains& answer() const { return missed() ? polished : search; }
};

[[nodiscard]] GainDesignResult DesignGains(const GainDesign& design,
                                           const ErrorGains& start,
                                           const OptimizerEntry& optimizer,
                                           const OptimizerSettings& settings);

}  // namespace lipoid
