#include "identify/gains/gain_design.h"

#include <ceres/jet.h>

#include <algorithm>
#include <cmath>

#include "identify/stages/row_factor.h"
#include "model/analysis/placed_gains.h"
#include "model/control/laws/control_laws.h"
#include "model/control/riccati.h"
#include "model/core/errors.h"
#include "model/core/parallel.h"
#include "model/flight/maneuvers/maneuvers.h"

namespace lipoid {
namespace {

// What a penalty aims at, so that it ends on the stable side of its bound.
constexpr double kSlowestDecay_per_s = 1e-3;

double ThesisBound(Loop loop) { return loop == Loop::kAltitude ? 10.0 : 1.0; }  // U of section 6.2

}  // namespace

double AttitudeDecayFor(const Vehicle& vehicle) {
  if (IsOfTheThesis(vehicle)) return 0.0;
  return kAttitudeDecayOfPlaced * PlaceGains(vehicle).attitude_rad_per_s;
}

void WidenBounds(GainDesign& design, const ErrorGains& start) {
  constexpr double kWider = 4.0;
  const double thesis = ThesisBound(design.loop);
  const double most = std::max({start.proportional, start.integral, start.derivative});
  if (most <= thesis) return;
  GainDesignOptions& options = design.options;
  for (const auto& [bound, gain] : {std::pair{&options.proportional_bound, start.proportional},
                                    std::pair{&options.integral_bound, start.integral},
                                    std::pair{&options.derivative_bound, start.derivative}}) {
    if (*bound == 0.0) *bound = std::max(thesis, kWider * gain);
  }
}

std::vector<FlightCommand> SampledCommands(const FlightPlan& plan) {
  std::vector<FlightCommand> sampled;
  const auto steps = static_cast<std::size_t>(std::llround(plan.duration_s / kControlStep_s));
  PlanFollower follower(plan);
  for (std::size_t k = 0; k < steps; ++k)
    sampled.push_back(follower.At(double(k) * kControlStep_s));
  return sampled;
}

std::vector<reduced::PitchGroup> reduced::PitchGroupsOf(const Vehicle& vehicle) {
  constexpr double kSame = 1e-9;  // sines of the same angle, but for rounding
  std::vector<PitchGroup> groups;
  for (const Rotor& rotor : RotorsOf(vehicle.layout)) {
    const auto same = std::find_if(groups.begin(), groups.end(), [&](const PitchGroup& group) {
      return std::abs(group.ahead - rotor.ahead) < kSame;
    });
    const double share = vehicle.ThrustShare(rotor);
    if (same == groups.end()) {
      groups.push_back({rotor.ahead, share});
    } else {
      same->shares += share;
    }
  }
  std::sort(groups.begin(), groups.end(), [](const PitchGroup& a, const PitchGroup& b) {
    return a.ahead > b.ahead;
  });
  return groups;
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
    : design_(design),
      regulator_(design.controller.law == "lqr"),
      stability_weight_(stability_weight) {
  (void)FindControlLaw(design.controller.law);
  Require(!design.xi.empty(), "at least one xi", {});
  const double thesis = ThesisBound(design.loop);
  const auto bound = [&](double given) { return given > 0.0 ? given : thesis; };
  bounds_ = {bound(design.options.proportional_bound),
             bound(design.options.integral_bound),
             bound(design.options.derivative_bound)};
  const FlightPlan plan = DesignPlan(design);
  commands_ = SampledCommands(plan);
  for (const auto& [xi, weight] : design.xi) {
    Require(xi > 0.0, "xi above 0", {{"xi", xi}});
    Require(weight >= 0.0, "a weight of at least 0", {{"weight", weight}});
    tasks_.push_back(
        {design.vehicle, xi, design.controller, plan, design.options.motor_lag, design.references});
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

GainProblem::Parameterised GainProblem::At(const Eigen::VectorXd& x) const {
  if (!regulator_) {
    return {{.proportional = x[0] * bounds_.proportional,
             .integral = x[1] * bounds_.integral,
             .derivative = x[2] * bounds_.derivative},
            {ErrorGains{.proportional = bounds_.proportional},
             ErrorGains{.integral = bounds_.integral},
             ErrorGains{.derivative = bounds_.derivative}}};
  }
  const RegulatorGains of =
      AxisRegulator({.error_per_s2 = std::sqrt(std::max(x[0], 0.0)) * bounds_.proportional,
                     .integral_per_s3 = x[1] * bounds_.integral,
                     .rate_per_s = std::sqrt(std::max(x[2], 0.0)) * bounds_.derivative});
  const auto times = [](const ErrorGains& gains, double factor) {
    return ErrorGains{.proportional = gains.proportional * factor,
                      .integral = gains.integral * factor,
                      .derivative = gains.derivative * factor};
  };
  return {of.gains,
          {times(of.per_error, bounds_.proportional * bounds_.proportional),
           times(of.per_integral, bounds_.integral),
           times(of.per_rate, bounds_.derivative * bounds_.derivative)}};
}

ErrorGains GainProblem::Gains(const Eigen::VectorXd& x) const { return At(x).gains; }

std::vector<GainBound> GainProblem::AtBound(const Eigen::VectorXd& x) const {
  constexpr double kNear = 1e-4;  // of the bound: local searches stop a little before it
  constexpr std::string_view kNames[] = {"proportional", "integral", "derivative"};
  const double bounds[] = {bounds_.proportional, bounds_.integral, bounds_.derivative};
  std::vector<GainBound> at;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const auto n = static_cast<std::size_t>(k);
    if (x[k] >= upper()[k] - kNear) {
      at.push_back({kNames[n], bounds[n], true});
    } else if (x[k] <= lower()[k] + kNear) {
      at.push_back({kNames[n], lower()[k] * bounds[n], false});
    }
  }
  return at;
}

Eigen::VectorXd GainProblem::Point(const ErrorGains& gains) const {
  Eigen::Vector3d x = Eigen::Vector3d(gains.proportional, gains.integral, gains.derivative)
                          .cwiseQuotient(Eigen::Vector3d(
                              bounds_.proportional, bounds_.integral, bounds_.derivative));
  if (regulator_) {
    // The nearest weights: not all gains are those of a regulator.
    const double error =
        gains.proportional * gains.proportional - 2.0 * gains.derivative * gains.integral;
    const double rate = gains.derivative * gains.derivative - 2.0 * gains.proportional;
    x[0] = std::max(error, 0.0) / (bounds_.proportional * bounds_.proportional);
    x[2] = std::max(rate, 0.0) / (bounds_.derivative * bounds_.derivative);
  }
  return x;
}

// How much faster the loop grows than it may.
Growth GainProblem::GrowthIn(const AxisResponse& response, const ErrorGains& gains) const {
  Growth growth = GrowthOf(response, gains);
  if (design_.loop == Loop::kAttitude) {
    growth.per_s += design_.attitude_decay_per_s;
    return growth;
  }
  // The pole of the integral, which the poles leave out where there is none.
  if (gains.integral == 0.0 && gains.proportional > 0.0 && growth.per_s < 0.0) {
    growth = {0.0, {.integral = -1.0 / gains.proportional}};
  }
  growth.per_s += kAltitudeDecay_per_s;
  return growth;
}

std::vector<Growth> GainProblem::Lacks(const ErrorGains& gains) const {
  std::vector<Growth> lacks;
  for (const AxisResponse& response : responses_) {
    Growth growth = GrowthIn(response, gains);
    growth.per_s += kSlowestDecay_per_s;
    if (growth.per_s > 0.0) lacks.push_back(growth);
  }
  return lacks;
}

bool GainProblem::Stable(const ErrorGains& gains) const {
  return std::all_of(responses_.begin(), responses_.end(), [&](const AxisResponse& response) {
    return GrowthIn(response, gains).per_s < 0.0;
  });
}

std::vector<double> GainProblem::CostsOf(const ErrorGains& gains) const {
  std::vector<double> costs(tasks_.size(), 0.0);
  ParallelFor(tasks_.size(), [&](std::size_t k) {
    double sum = 0.0;
    Run(k, gains, [&](std::size_t, double error) { sum += error * error; });
    costs[k] = sum * kControlStep_s;
  });
  return costs;
}

double GainProblem::CostOf(const ErrorGains& gains) const {
  const std::vector<double> costs = CostsOf(gains);
  double sum = 0.0;  // in order: the same bits for any number of threads
  for (std::size_t k = 0; k < costs.size(); ++k) sum += costs[k] * design_.xi[k].weight;
  return sum;
}

double GainProblem::Cost(const Eigen::VectorXd& x) const {
  const ErrorGains gains = Gains(x);
  double sum = CostOf(gains);
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
  const Parameterised at = At(x);
  const auto jet = [&](double ErrorGains::*gain) {
    Jet value(at.gains.*gain);
    for (int j = 0; j < 3; ++j) value.v[j] = at.slopes[std::size_t(j)].*gain;
    return value;
  };
  const BasicErrorGains<Jet> gains{
      jet(&ErrorGains::proportional), jet(&ErrorGains::integral), jet(&ErrorGains::derivative)};
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
    for (const Growth& lack : Lacks(at.gains)) {
      double* row = all.NextRow();
      for (std::size_t j = 0; j < 3; ++j) {
        const ErrorGains& slopes = at.slopes[j];
        row[Eigen::Index(j) * all.stride()] =
            scale *
            (lack.slopes.proportional * slopes.proportional +
             lack.slopes.integral * slopes.integral + lack.slopes.derivative * slopes.derivative);
      }
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
  // The first weight lets a lack of 0.01/s cost as much as the start, the others more.
  constexpr double kNoticed_per_s = 0.01;
  const double first = problem.CostOf(start) / (kNoticed_per_s * kNoticed_per_s);
  const auto search = [&](const OptimizerEntry& by,
                          const OptimizerSettings& with,
                          const Eigen::VectorXd& begin,
                          OptimizationSummary& ended) {
    FoundGains found;
    double weight = 0.0;
    for (int round = 0; round < 4 && !found.stable; ++round) {
      ended = by.Minimize(GainProblem(design, weight), begin, with);
      if (ended.x.size() != 3) ended.x = begin;
      found.gains = problem.Gains(ended.x);
      found.at_bound = problem.AtBound(ended.x);
      found.cost = 2.0 * problem.Cost(ended.x);
      found.stable = problem.Stable(found.gains);
      found.constrained = round > 0;
      weight = round == 0 ? first : 100.0 * weight;
    }
    return found;
  };
  GainDesignResult result;
  result.search = search(optimizer, settings, from, result.optimization);
  result.start_cost = problem.CostOf(start);
  // The usual options: those of the search may be what kept it from the answer.
  OptimizerSettings usual;
  usual.context = settings.context;
  OptimizationSummary ended;
  result.polished =
      search(FindOptimizer("levenberg-marquardt"), usual, result.optimization.x, ended);
  const bool better =
      ended.usable() && result.polished.stable && result.polished.cost < result.search.cost;
  if (!better) result.polished = result.search;
  return result;
}

}  // namespace lipoid
