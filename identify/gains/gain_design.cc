#include "identify/gains/gain_design.h"

#include <ceres/jet.h>

#include <algorithm>
#include <cmath>

#include "identify/stages/row_factor.h"
#include "model/core/errors.h"
#include "model/core/parallel.h"
#include "model/flight/maneuvers/maneuvers.h"

namespace lipoid {
namespace {

// What a penalty aims at, so that it ends on the stable side of its bound.
constexpr double kSlowestDecay_per_s = 1e-3;

}  // namespace

std::vector<FlightCommand> SampledCommands(const FlightPlan& plan) {
  std::vector<FlightCommand> sampled;
  const auto steps = static_cast<std::size_t>(std::llround(plan.duration_s / kControlStep_s));
  PlanFollower follower(plan);
  for (std::size_t k = 0; k < steps; ++k)
    sampled.push_back(follower.At(double(k) * kControlStep_s));
  return sampled;
}

FlightPlan DesignPlan(const GainDesign& design) {
  FlightPlan plan;
  if (design.loop == Loop::kAltitude) {
    // The step is commanded with the first step of the controller: the flight starts at rest below.
    const FlightCommand low{.altitude_m = 1.1};
    FlightCommand high = low;
    high.altitude_m += design.options.step_m;
    plan = {.commands = {{0.0, low}, {kControlStep_s, high}}, .duration_s = 5.0};
  } else {
    plan = AttitudeDoublets().plan({});
  }
  if (design.options.duration_s > 0.0) plan.duration_s = design.options.duration_s;
  return plan;
}

GainProblem::GainProblem(const GainDesign& design, double stability_weight)
    : design_(design), stability_weight_(stability_weight) {
  Require(!design.xi.empty(), "at least one xi", {});
  const double thesis_bound = design.loop == Loop::kAltitude ? 10.0 : 1.0;  // U of section 6.2
  const auto bound = [&](double given) { return given > 0.0 ? given : thesis_bound; };
  bounds_ = {bound(design.options.proportional_bound),
             bound(design.options.integral_bound),
             bound(design.options.derivative_bound)};
  const FlightPlan plan = DesignPlan(design);
  commands_ = SampledCommands(plan);
  for (const auto& [xi, weight] : design.xi) {
    Require(xi > 0.0, "xi above 0", {{"xi", xi}});
    Require(weight >= 0.0, "a weight of at least 0", {{"weight", weight}});
    tasks_.push_back({design.vehicle, xi, design.controller, plan, design.options.motor_lag});
    const HoverResponse response = ResponseAtHover(design.vehicle, HoverAt(design.vehicle, xi));
    const AxisResponse& own = design.loop == Loop::kAltitude ? response.altitude : response.pitch;
    for (const double gain : {1.0 / kStabilityMargin, kStabilityMargin}) {
      for (const double lag : {0.0, 1.0, kStabilityMargin}) {
        responses_.push_back({.kappa = gain * own.kappa, .lag_s = lag * own.lag_s});
      }
    }
  }
}

template <class T, class Visit>
void GainProblem::Run(std::size_t k, const BasicErrorGains<T>& gains, Visit&& visit) const {
  if (design_.loop == Loop::kAltitude) {
    RunAltitudeLoop(tasks_[k], commands_, gains, visit);
  } else {
    RunPitchLoop(tasks_[k], commands_, design_.altitude_gains, gains, visit);
  }
}

ErrorGains GainProblem::Gains(const Eigen::VectorXd& x) const {
  return {x[0] * bounds_.proportional, x[1] * bounds_.integral, x[2] * bounds_.derivative};
}

Eigen::VectorXd GainProblem::Point(const ErrorGains& gains) const {
  return Eigen::Vector3d(gains.proportional / bounds_.proportional,
                         gains.integral / bounds_.integral,
                         gains.derivative / bounds_.derivative);
}

std::vector<Growth> GainProblem::Lacks(const ErrorGains& gains) const {
  std::vector<Growth> lacks;
  for (const AxisResponse& response : responses_) {
    Growth growth = GrowthOf(response, gains);
    growth.per_s += kSlowestDecay_per_s;
    if (growth.per_s > 0.0) lacks.push_back(growth);
  }
  return lacks;
}

bool GainProblem::Stable(const ErrorGains& gains) const {
  return std::all_of(responses_.begin(), responses_.end(), [&](const AxisResponse& response) {
    return GrowthOf(response, gains).per_s < 0.0;
  });
}

double GainProblem::Cost(const Eigen::VectorXd& x) const {
  std::vector<double> sums(tasks_.size(), 0.0);
  const ErrorGains gains = Gains(x);
  ParallelFor(tasks_.size(), [&](std::size_t k) {
    double sum = 0.0;
    Run(k, gains, [&](std::size_t, double error) { sum += error * error; });
    sums[k] = sum * kControlStep_s * design_.xi[k].weight;
  });
  double sum = 0.0;  // in order: the same bits for any number of threads
  for (const double one : sums) sum += one;
  if (stability_weight_ > 0.0) {
    for (const Growth& lack : Lacks(gains)) sum += stability_weight_ * lack.per_s * lack.per_s;
  }
  return 0.5 * sum;
}

Eigen::MatrixXd GainProblem::Factor(const Eigen::VectorXd& x, bool jacobian) const {
  if (!jacobian) {
    Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(4, 4);
    factor(3, 3) = std::sqrt(2.0 * Cost(x));
    return factor;
  }
  using Jet = ceres::Jet<double, 3>;
  const BasicErrorGains<Jet> gains{bounds_.proportional * Jet(x[0], 0),
                                   bounds_.integral * Jet(x[1], 1),
                                   bounds_.derivative * Jet(x[2], 2)};
  std::vector<Eigen::MatrixXd> factors(tasks_.size());
  ParallelFor(tasks_.size(), [&](std::size_t k) {
    const double scale = std::sqrt(kControlStep_s * design_.xi[k].weight);
    RowFactor rows(4);
    Run(k, gains, [&](std::size_t, const Jet& error) {
      double* row = rows.NextRow();
      for (Eigen::Index j = 0; j < 3; ++j) row[j * rows.stride()] = scale * error.v[j];
      row[3 * rows.stride()] = scale * error.a;
      rows.Push();
    });
    factors[k] = rows.Factor();
  });
  RowFactor all(4);
  for (const Eigen::MatrixXd& factor : factors) {
    for (Eigen::Index r = 0; r < 4; ++r) {
      double* row = all.NextRow();
      for (Eigen::Index j = 0; j < 4; ++j) row[j * all.stride()] = factor(r, j);
      all.Push();
    }
  }
  if (stability_weight_ > 0.0) {
    const double scale = std::sqrt(stability_weight_);
    for (const Growth& lack : Lacks(Gains(x))) {
      double* row = all.NextRow();
      row[0] = scale * lack.slopes.proportional * bounds_.proportional;
      row[all.stride()] = scale * lack.slopes.integral * bounds_.integral;
      row[2 * all.stride()] = scale * lack.slopes.derivative * bounds_.derivative;
      row[3 * all.stride()] = scale * lack.per_s;
      all.Push();
    }
  }
  return all.Factor();
}

GainDesignResult DesignGains(const GainDesign& design,
                             const ErrorGains& start,
                             const OptimizerEntry& optimizer,
                             const OptimizerSettings& settings) {
  const GainProblem problem(design);
  const Eigen::VectorXd from =
      problem.Point(start).cwiseMax(problem.lower()).cwiseMin(problem.upper());
  const auto& polisher = FindOptimizer("levenberg-marquardt");
  const auto minimize = [&](const GainProblem& of) {
    GainDesignResult result;
    result.optimization = optimizer.Minimize(of, from, settings);
    result.start_cost = 2.0 * problem.Cost(from);
    const Eigen::VectorXd& x = result.optimization.x.size() == 3 ? result.optimization.x : from;
    result.gains = problem.Gains(x);
    result.cost = 2.0 * problem.Cost(x);
    const auto polished = polisher.Minimize(of, x, settings);
    const bool better = polished.usable() && problem.Stable(problem.Gains(polished.x));
    result.polished_cost =
        better ? std::min(result.cost, 2.0 * problem.Cost(polished.x)) : result.cost;
    result.stable = problem.Stable(result.gains);
    return result;
  };
  GainDesignResult result = minimize(problem);
  // The first weight lets a lack of 0.01/s cost as much as the start, the others more.
  constexpr double kNoticed_per_s = 0.01;
  double weight = problem.CostOf(start) / (kNoticed_per_s * kNoticed_per_s);
  for (int round = 0; round < 3 && !result.stable; ++round, weight *= 100.0) {
    result = minimize(GainProblem(design, weight));
    result.constrained = true;
  }
  return result;
}

}  // namespace lipoid
