#include "identify/stages/staged_profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace lipoid {
namespace {

// The family and the place of "tau_2"; of "beta" and "r_s" the place is none.
struct Name {
  std::string family;
  std::size_t branch = 0;
  bool of_branch = false;
};

Name Split(const std::string& name) {
  const auto bar = name.find('_');
  if (name == "beta" || name == "r_s" || bar == std::string::npos) return {name};
  return {name.substr(0, bar), std::stoul(name.substr(bar + 1)) - 1, true};
}

// Every name of the fit, and which of them the user left free. tau_j and c_j are one unknown seen
// twice: where either is given, or kept within bounds, the other cannot be held beside it.
struct Offered {
  std::vector<std::string> free;
  std::vector<std::string> fixed;
};

Offered OfferedBy(const PulseFitOptions& options, const GivenParameters& given) {
  Offered names;
  const auto add = [&](const std::string& name, const std::string& twin = "") {
    const bool held = given.fixed.count(name) > 0 || given.fixed.count(twin) > 0 ||
                      given.bounds.count(twin) > 0;
    (held ? names.fixed : names.free).push_back(name);
  };
  if (options.diffusion) add("beta");
  add("r_s");
  for (int j = 1; j <= options.branches; ++j) {
    const auto c = fmt::format("c_{}", j);
    const auto tau = fmt::format("tau_{}", j);
    add(fmt::format("r_{}", j));
    add(tau, c);
    add(c, tau);
  }
  return names;
}

double Value(const SweepParameters& p, const Name& name) {
  if (name.family == "beta") return p.beta_per_sqrt_s;
  if (name.family == "r_s") return p.series_resistance_Ohm;
  const double r = p.resistance_Ohm[name.branch];
  const double tau = p.time_constant_s[name.branch];
  if (name.family == "r") return r;
  if (name.family == "tau") return tau;
  return r > 0.0 ? tau / r : std::numeric_limits<double>::quiet_NaN();
}

std::string Unit(const Name& name) {
  if (name.family == "beta") return "s^-1/2";
  if (name.family == "tau") return "s";
  return name.family == "c" ? "F" : "Ohm";
}

// The fit with one parameter held, from the parameters of the last one.
class HeldFit {
 public:
  HeldFit(std::string name,
          const VoltageSweep& sweep,
          const StartValues& data,
          const PulseFitResult& fit,
          const PulseFitOptions& options,
          const LevenbergMarquardtOptions& solver,
          GivenParameters known)
      : name_(std::move(name)),
        sweep_(sweep),
        data_(data),
        options_(options),
        solver_(solver),
        known_(std::move(known)),
        last_(fit.parameters) {
    known_.start.clear();        // the last parameters are the start
    known_.bounds.erase(name_);  // the grid stays within, but for a rounding
    for (const SweepLog& log : sweep.logs())
      weight_ += log.weight * static_cast<double>(log.record->size());
  }

  ProfileCost operator()(double value) {
    known_.fixed[name_] = value;
    const PulseUnknowns unknowns = FindPulseUnknowns(
        sweep_.setup(),
        data_,
        {.branches = options_.branches, .unknown = options_.branch_unknown},
        known_);
    PulseParameters p = unknowns.start;
    if (!unknowns.variables.empty()) {
      const PulseProblem problem(sweep_, unknowns.variables, unknowns.start);
      p.sweep = last_;
      MakeReady(p, unknowns);
      const auto found = MinimizeLevenbergMarquardt(problem, problem.Point(p), solver_);
      if (!found.usable()) return {};
      p = problem.Parameters(found.x);
    }
    last_ = p.sweep;
    const double cost = std::pow(sweep_.Factor(p.sweep, false).bottomRightCorner<1, 1>()(0), 2);
    return {.cost = cost, .rmse_V = std::sqrt(cost / weight_)};
  }

 private:
  std::string name_;
  const VoltageSweep& sweep_;
  const StartValues& data_;
  const PulseFitOptions& options_;
  const LevenbergMarquardtOptions& solver_;
  GivenParameters known_;
  SweepParameters last_;
  double weight_ = 0.0;
};

}  // namespace

void CheckStagedProfile(const std::vector<std::string>& names,
                        const PulseFitOptions& options,
                        const GivenParameters& given) {
  const Offered all = OfferedBy(options, given);
  CheckProfileNames(names, all.free, all.fixed);
}

std::vector<Profile> ProfileStaged(const std::vector<std::string>& names,
                                   const VoltageSweep& sweep,
                                   const StartValues& data,
                                   const PulseFitResult& fit,
                                   const TrustReport& trust,
                                   const PulseFitOptions& options,
                                   const LevenbergMarquardtOptions& solver,
                                   const GivenParameters& given) {
  CheckStagedProfile(names, options, given);
  const PulseScales scales = FindPulseScales(data, sweep.setup().alpha_C);
  const QuantityTrust* series = FindQuantity(trust, "r_s");
  std::vector<ProfileTask> tasks;
  for (const std::string& name : names) {
    const Name split = Split(name);
    ProfileTask task;
    task.name = name;
    task.unit = Unit(split);
    task.estimate = Value(fit.parameters, split);
    if (split.family == "beta") task.upper = 1.0;
    if (split.family == "tau") {
      task.lower = scales.shortest_tau_s;
      task.upper = scales.longest_tau_s;
    }
    if (const auto bounds = given.bounds.find(name); bounds != given.bounds.end()) {
      task.lower = std::max(task.lower, bounds->second.first);
      task.upper = std::min(task.upper, bounds->second.second);
    }
    // A resistance at zero: as far as the series resistance is uncertain, which it would take from.
    if (series != nullptr) task.typical_reach = Reach95(*series);
    if (!std::isfinite(task.typical_reach)) task.typical_reach = scales.series_resistance_Ohm;
    task.begin = [&, name]() -> Refit {
      auto held = std::make_shared<HeldFit>(name, sweep, data, fit, options, solver, given);
      return [held](double value) { return (*held)(value); };
    };
    tasks.push_back(std::move(task));
  }
  return FindProfiles(tasks, trust);
}

}  // namespace lipoid
