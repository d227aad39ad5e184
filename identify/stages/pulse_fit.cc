#include "identify/stages/pulse_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <optional>

#include "identify/fit/grid.h"
#include "identify/stages/pulse_problem.h"

namespace lipoid {
namespace {

// Closer than this to zero, beside the typical series resistance, no data would tell the difference.
constexpr double kNothing = 1e-6;

// Without resistance one of several branches may have any time constant: the cost is flat along it, and no step
// leads away, though at another one the branch may have a part in the answer. From the best of such: the fit that
// costs less, or `found`. A single branch has no need of it: the grid that the search begins with is one of its
// time constants.
JointSolution WithGoneBranchesElsewhere(const JointFit& fit,
                                        const GivenParameters& held,
                                        const LevenbergMarquardtOptions& solver,
                                        JointSolution found) {
  constexpr int kTried = 16;
  constexpr double kNoGain = 1e-6;  // what the sums of a single solution may be off by, and more
  if (found.structure.branches < 2) return found;
  JointSolution best = found;
  for (const JointRate& rate : fit.Rates(found.structure)) {
    const auto j = static_cast<std::size_t>(rate.index);
    const bool of_branch = rate.name == fmt::format("tau_{}", j + 1);
    if (!of_branch || found.x.size() == 0 || found.x[rate.index + 1] > 0.0 ||
        held.Fixed(fmt::format("r_{}", j + 1)))
      continue;
    // Not at the ends, where a branch is one with r_s or with v_oc.
    const std::vector<double> taus_s = GeometricGrid(rate.lower, rate.upper, kTried + 2);
    for (auto tau_s = taus_s.begin() + 1; tau_s + 1 != taus_s.end(); ++tau_s) {
      JointRates rates = found.rates;
      rates.time_constant_s[j] = *tau_s;
      JointSolution other = fit.Solve(found.structure, rates, 0.0);
      if (other.cost >= 0.0 && other.cost < (1.0 - kNoGain) * best.cost) best = std::move(other);
    }
  }
  if (!(best.cost < found.cost)) return found;
  best = fit.Approach(std::move(best), solver);
  return best.cost < found.cost ? best : found;
}

}  // namespace

FitScales PulseFitScales(const VoltageSweep& sweep, const StartValues& data) {
  const PulseScales typical = FindPulseScales(data, sweep.setup().alpha_C);
  FitScales scales = sweep.scales();
  scales.shortest_tau_s = typical.shortest_tau_s;
  scales.longest_tau_s = typical.longest_tau_s;
  scales.longest_start_tau_s = typical.longest_tau_s;
  return scales;
}

PulseFitResult FitPulses(const VoltageSweep& sweep,
                         const PulseFitStart& start,
                         const PulseFitOptions& options,
                         const LevenbergMarquardtOptions& solver,
                         const GivenParameters& given) {
  const auto began = std::chrono::steady_clock::now();
  const bool diffusion = sweep.setup().diffusion;
  CheckGiven(given, FitParameterNames(diffusion, options.branches));
  PulseFitResult result;
  result.bounds = given.bounds;
  GivenParameters known = given;
  if (diffusion && start.hold_beta) known.fixed.try_emplace("beta", start.beta_per_sqrt_s);
  for (const std::string& name : FitParameterNames(diffusion, options.branches)) {
    if (known.Fixed(name)) result.fixed.push_back(name);
  }

  const PulseScales typical = FindPulseScales(start.data, sweep.setup().alpha_C);
  const FitScales scales = PulseFitScales(sweep, start.data);
  known.start.try_emplace("beta", start.beta_per_sqrt_s);
  JointStructure structure;
  structure.branches = options.branches;
  for (int j = 0; j < options.branches; ++j) {
    known.start.try_emplace(fmt::format("tau_{}", j + 1),
                            typical.TimeConstant(j, options.branches));
  }

  // Many starts on a coarse view of the logs; then all rows decide.
  std::optional<VoltageSweep> made;
  if (start.coarse == nullptr) made.emplace(sweep.setup(), sweep.logs(), Condensation::Coarse());
  const JointFit quick(start.coarse != nullptr ? *start.coarse : *made, known, scales);
  JointSolution best = quick.Search(structure, 0.0, nullptr, options.starts);
  result.starts = options.starts;
  if (start.previous != nullptr) {
    JointRates rates = quick.Base(structure);
    for (const JointRate& rate : quick.Rates(structure)) {
      JointRates previous = SolutionOf(*start.previous).rates;
      *rate.entry(rates, rate.index) = *rate.entry(previous, rate.index);
    }
    JointSolution again = quick.Approach(quick.Solve(structure, rates, 0.0));
    if (again.cost < best.cost) best = std::move(again);
    ++result.starts;
  }
  const auto fit_all_rows = [&](const GivenParameters& held) {
    const JointFit fit(sweep, held, scales);
    best = fit.Approach(std::move(best), solver);
    best = WithGoneBranchesElsewhere(fit, held, solver, std::move(best));
    result.evaluations += fit.evaluations();
  };
  fit_all_rows(known);

  // A branch that has no inertia left is a part of r_s, and one without resistance has no time
  // constant: either way it is gone. What it carried goes to r_s, and the rest is fitted without
  // it.
  GivenParameters rest = known;
  for (int j = 0; j < options.branches && best.x.size() > 0; ++j) {
    const auto r = fmt::format("r_{}", j + 1);
    const auto tau = fmt::format("tau_{}", j + 1);
    const auto c = fmt::format("c_{}", j + 1);
    if (known.Fixed(r) || known.Fixed(tau) || known.Fixed(c)) continue;
    const double tau_s = best.rates.time_constant_s[static_cast<std::size_t>(j)];
    const bool instant = !known.Fixed("r_s") && !known.Bounds(tau) && best.AtBound(tau) &&
                         tau_s < 2.0 * scales.shortest_tau_s;
    if (!instant && best.x[1 + j] > kNothing * typical.series_resistance_Ohm) continue;
    rest.bounds.erase(r);
    rest.bounds.erase(c);
    rest.fixed[r] = 0.0;
    rest.fixed[tau] = tau_s;
  }
  if (rest.fixed.size() > known.fixed.size()) fit_all_rows(rest);
  if (best.x.size() == 0) {  // no finite voltage anywhere
    best.x = Eigen::VectorXd::Zero(1 + options.branches);
    best.x[0] = typical.series_resistance_Ohm;
    best.rates = quick.Base(structure);
    best.active.assign(static_cast<std::size_t>(best.x.size()), 0);
    best.follows.assign(static_cast<std::size_t>(options.branches), 0);
    best.termination = Termination::kFailure;
    best.message = "The model has no finite voltage at these logs.";
  }
  if (!given.NamesABranch()) SortBranches(best);

  result.parameters = ParametersOf(best);
  if (!diffusion) result.parameters.beta_per_sqrt_s = 0.0;
  result.termination = best.termination;
  const std::size_t unknowns = (diffusion ? 2U : 1U) + 2U * best.structure.branches;
  result.message = result.fixed.size() == unknowns ? "Every parameter was given." : best.message;
  const auto at_bound = [&](const std::string& name, bool is) {
    if (is) result.at_bound.push_back(name);
  };
  at_bound("beta", best.AtBound("beta"));
  at_bound("r_s", best.active[0] && !known.Fixed("r_s"));
  for (int j = 0; j < options.branches; ++j) {
    const auto r = fmt::format("r_{}", j + 1);
    const auto tau = fmt::format("tau_{}", j + 1);
    const auto c = fmt::format("c_{}", j + 1);
    const bool follows = best.follows[static_cast<std::size_t>(j)];
    const bool free = !known.Fixed(r);
    at_bound(r, free && best.active[static_cast<std::size_t>(1 + j)] && !follows);
    at_bound(tau, best.x[1 + j] > 0.0 && best.AtBound(tau));
    at_bound(c, follows && !known.Fixed(c));
  }
  result.solution = std::move(best);
  const SweepErrors errors = sweep.Errors(result.parameters);
  result.errors = errors.metrics;
  result.rows_outside_curve = errors.rows_outside_curve;
  result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return result;
}

}  // namespace lipoid
