#include "identify/stages/pulse_fit.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <optional>

#include "identify/fit/grid.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Closer than this to a bound, in units of the parameter, no data would tell the difference.
constexpr double kTouching = 1e-6;

// min ||b + A y|| with lower <= y: few unknowns, so every set of those at their bound is tried.
Eigen::VectorXd NonNegativeLeastSquares(const Eigen::MatrixXd& a,
                                        const Eigen::VectorXd& b,
                                        double* norm) {
  const auto n = static_cast<int>(a.cols());
  Eigen::VectorXd best = Eigen::VectorXd::Zero(n);
  *norm = b.norm();
  for (unsigned free = 1; free < (1U << n); ++free) {
    std::vector<int> columns;
    for (int k = 0; k < n; ++k) {
      if (free & (1U << k)) columns.push_back(k);
    }
    Eigen::MatrixXd part(a.rows(), static_cast<Eigen::Index>(columns.size()));
    for (std::size_t k = 0; k < columns.size(); ++k)
      part.col(static_cast<Eigen::Index>(k)) = a.col(columns[k]);
    const Eigen::VectorXd y = part.colPivHouseholderQr().solve(-b);
    const double here = (part * y + b).norm();
    if (y.minCoeff() < 0.0 || !(here < *norm)) continue;
    *norm = here;
    best.setZero();
    for (std::size_t k = 0; k < columns.size(); ++k)
      best[columns[k]] = y[static_cast<Eigen::Index>(k)];
  }
  return best;
}

struct Candidate {
  PulseParameters parameters;
  double cost = kInfinity;
};

// For every (beta, tau_j) of a grid the best r_s, r_j follow by linear least squares.
std::vector<Candidate> SearchStarts(const VoltageSweep& coarse,
                                    const std::vector<double>& betas,
                                    const std::vector<std::vector<double>>& time_constants,
                                    const std::vector<PulseVariable>& variables,
                                    const PulseParameters& base) {
  std::vector<const PulseVariable*> linear;
  for (const PulseVariable& v : variables) {
    if (v.resistive()) linear.push_back(&v);
  }
  const auto column = [](const PulseVariable& v) {
    return v.kind == PulseVariable::Kind::kSeriesResistance
               ? Eigen::Index{1}
               : 2 + static_cast<Eigen::Index>(v.branch);
  };
  std::vector<Candidate> candidates;
  for (const double beta : betas) {
    for (const auto& taus : time_constants) {
      PulseParameters p = base;
      p.sweep.beta_per_sqrt_s = beta;
      p.sweep.time_constant_s = taus;
      for (const PulseVariable* v : linear) Entry(p, *v) = 0.0;
      const Eigen::MatrixXd factor = coarse.Factor(p.sweep, true);
      if (!factor.allFinite()) continue;
      Eigen::MatrixXd design(factor.rows(), static_cast<Eigen::Index>(linear.size()));
      for (std::size_t k = 0; k < linear.size(); ++k)
        design.col(static_cast<Eigen::Index>(k)) = factor.col(column(*linear[k]));
      Candidate candidate;
      const Eigen::VectorXd y =
          NonNegativeLeastSquares(design, factor.rightCols(1), &candidate.cost);
      for (std::size_t k = 0; k < linear.size(); ++k)
        Entry(p, *linear[k]) = y[static_cast<Eigen::Index>(k)];
      candidate.parameters = std::move(p);
      candidates.push_back(std::move(candidate));
    }
  }
  std::sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return a.cost < b.cost;
  });
  return candidates;
}

}  // namespace

PulseFitResult FitPulses(const VoltageSweep& sweep,
                         const PulseFitStart& start,
                         const PulseFitOptions& options,
                         const LevenbergMarquardtOptions& solver,
                         const GivenParameters& given) {
  const auto began = std::chrono::steady_clock::now();
  const auto n = static_cast<std::size_t>(options.branches);
  PulseUnknowns unknowns = FindPulseUnknowns(sweep.setup(),
                                             start.data,
                                             {.branches = options.branches,
                                              .hold_beta = start.hold_beta,
                                              .beta_start_per_sqrt_s = start.beta_per_sqrt_s,
                                              .unknown = options.branch_unknown},
                                             given);
  auto& variables = unknowns.variables;
  PulseParameters base = unknowns.start;
  PulseFitResult result;
  result.fixed = unknowns.fixed;

  // Many starts on a coarse view of the logs.
  std::optional<VoltageSweep> made;
  if (start.coarse == nullptr) made.emplace(sweep.setup(), sweep.logs(), Condensation::Coarse());
  const VoltageSweep& coarse = start.coarse != nullptr ? *start.coarse : *made;
  std::vector<double> betas{base.sweep.beta_per_sqrt_s};
  if (unknowns.Free("beta")) {
    for (const double beta : GeometricGrid(0.03, 1.0, 7)) betas.push_back(beta);
  }
  // What stands beside r_j, if it is free.
  const auto free_inertia = [&](std::size_t j) -> std::optional<std::string> {
    for (const char* prefix : {"tau", "c"}) {
      auto name = fmt::format("{}_{}", prefix, j + 1);
      if (unknowns.Free(name)) return name;
    }
    return std::nullopt;
  };
  bool all_taus_free = true;
  for (std::size_t j = 0; j < n; ++j) all_taus_free = all_taus_free && free_inertia(j).has_value();
  std::vector<std::vector<double>> choices{base.sweep.time_constant_s};
  if (n > 0 && all_taus_free) {
    const StartValues& data = start.data;
    const auto grid = GeometricGrid(
        2.0 * data.shortest_s, std::max(data.longest_s, 4.0 * data.shortest_s), n <= 2 ? 8 : 6);
    for (auto& choice : Choices(grid, options.branches)) choices.push_back(std::move(choice));
  }
  auto candidates = SearchStarts(coarse, betas, choices, variables, base);
  candidates.resize(std::min(candidates.size(), static_cast<std::size_t>(options.starts)));
  candidates.push_back({base, 0.0});
  if (start.previous != nullptr) {
    PulseParameters previous = base;
    previous.sweep = *start.previous;
    candidates.push_back({std::move(previous), 0.0});
  }

  PulseParameters best = base;
  double best_cost = kInfinity;
  const PulseProblem quick(coarse, variables, base);
  for (auto& candidate : candidates) {
    MakeReady(candidate.parameters, unknowns);
    if (variables.empty()) break;
    const auto fit = MinimizeLevenbergMarquardt(quick, quick.Point(candidate.parameters), solver);
    ++result.starts;
    if (fit.usable() && fit.cost < best_cost) {
      best_cost = fit.cost;
      best = quick.Parameters(fit.x);
    }
  }

  // All rows decide.
  PulseParameters found = base;
  const auto fit_all_rows = [&] {
    const PulseProblem problem(sweep, variables, base);
    if (variables.empty()) {
      found = base;
      result.summary.termination = Termination::kConverged;
      result.summary.message = "Every parameter was given.";
      return;
    }
    result.summary = MinimizeLevenbergMarquardt(problem, problem.Point(best), solver);
    found = problem.Parameters(result.summary.x);
    result.evaluations += result.summary.evaluations;
  };
  fit_all_rows();

  // A branch that has no inertia left is a part of r_s, and one without resistance has no time
  // constant: either way it is gone. What it carried goes to r_s, and the rest is fitted without
  // it.
  std::vector<bool> gone(n, false);
  best = found;
  for (std::size_t j = 0; j < n; ++j) {
    const auto r = fmt::format("r_{}", j + 1);
    const auto inertia = free_inertia(j);
    if (!unknowns.Free(r) || !inertia) continue;
    const auto& p = found.sweep;
    const bool instant = unknowns.Free("r_s") &&
                         p.time_constant_s[j] <= unknowns.scales.shortest_tau_s * (1.0 + kTouching);
    if (!instant && p.resistance_Ohm[j] > kTouching * unknowns.scales.series_resistance_Ohm)
      continue;
    if (instant) best.sweep.series_resistance_Ohm += best.sweep.resistance_Ohm[j];
    best.sweep.resistance_Ohm[j] = 0.0;
    best.capacitance_F[j] = std::numeric_limits<double>::quiet_NaN();
    std::erase_if(variables,
                  [&](const PulseVariable& v) { return v.name == r || v.name == *inertia; });
    gone[j] = true;
  }
  if (std::find(gone.begin(), gone.end(), true) != gone.end()) {
    base = best;
    fit_all_rows();
  }

  std::vector<std::string> touched;
  for (const PulseVariable& v : variables) {
    double& p = Entry(found, v);
    const double lower_slack = v.logarithmic ? std::log(p / v.lower) : (p - v.lower) / v.unit;
    const double upper_slack = !std::isfinite(v.upper) ? kInfinity
                               : v.logarithmic         ? std::log(v.upper / p)
                                                       : (v.upper - p) / v.unit;
    if (lower_slack >= kTouching && upper_slack >= kTouching) continue;
    p = lower_slack < kTouching ? v.lower : v.upper;
    touched.push_back(v.name);
  }
  FollowCapacitances(found);
  const auto touches = [&](const std::string& name) {
    return std::find(touched.begin(), touched.end(), name) != touched.end();
  };

  // Branches come in any order: by rising time constant, those that are gone last, unless the user
  // named one.
  const std::vector<double>& taus = found.sweep.time_constant_s;
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (!given.NamesABranch()) {
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      if (gone[a] != gone[b]) return static_cast<bool>(gone[b]);
      return taus[a] < taus[b];
    });
  }
  result.parameters = found.sweep;
  for (const char* name : {"beta", "r_s"}) {
    if (touches(name)) result.at_bound.emplace_back(name);
  }
  for (std::size_t j = 0; j < n; ++j) {
    const std::size_t from = order[j];
    result.parameters.resistance_Ohm[j] = found.sweep.resistance_Ohm[from];
    result.parameters.time_constant_s[j] = taus[from];
    if (gone[from] || touches(fmt::format("r_{}", from + 1)))
      result.at_bound.push_back(fmt::format("r_{}", j + 1));
    for (const char* prefix : {"tau", "c"}) {
      if (touches(fmt::format("{}_{}", prefix, from + 1)))
        result.at_bound.push_back(fmt::format("{}_{}", prefix, j + 1));
    }
  }
  const SweepErrors errors = sweep.Errors(result.parameters);
  result.errors = errors.metrics;
  result.rows_outside_curve = errors.rows_outside_curve;
  result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return result;
}

}  // namespace lipoid
