#include "identify/fit/fit_profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "model/battery/cell_parameters.h"
#include "model/statistics/quantiles.h"

namespace lipoid {
namespace {

// A parameter of a solution, and within which bounds it is held.
struct Held {
  double estimate = std::numeric_limits<double>::quiet_NaN();
  double lower = 0.0;
  double upper = std::numeric_limits<double>::infinity();
};

Held HeldAt(const std::string& name, const ProfiledFit& of) {
  const JointLayout layout(of.solution.structure);
  const auto ohms = [&](int table) { return of.solution.x[table] / of.scales.typical_A; };
  Held held;
  for (const JointRate& rate :
       JointFit(of.seen, of.known, of.scales).Rates(of.solution.structure)) {
    if (rate.name != name) continue;
    JointRates rates = of.solution.rates;
    return {rate.In(rates), rate.lower, rate.upper};
  }
  if (name == "r_s") held.estimate = ohms(layout.series());
  for (int j = 0; j < of.solution.structure.branches; ++j) {
    const double r = ohms(layout.branch(j));
    if (name == fmt::format("r_{}", j + 1)) held.estimate = r;
    if (name == fmt::format("c_{}", j + 1) && r > 0.0)
      held.estimate = of.solution.rates.time_constant_s[j] / r;
  }
  if (const auto bounds = of.known.Bounds(name)) {
    held.lower = bounds->first;
    held.upper = bounds->second;
  }
  return held;
}

// The fit with one parameter held, from where the last one ended.
class HeldFit {
 public:
  HeldFit(std::string name, const ProfiledFit& of)
      : name_(std::move(name)), of_(of), known_(of.known), last_(of.solution) {
    known_.start.clear();
    known_.bounds.erase(name_);  // the grid stays within, but for a rounding
  }

  ProfileCost operator()(double value) {
    known_.fixed[name_] = value;
    const JointFit fit(of_.seen, known_, of_.scales);
    JointRates rates = fit.Base(last_.structure);
    for (const JointRate& rate : fit.Rates(last_.structure)) rate.In(rates) = rate.In(last_.rates);
    JointSolution found =
        of_.refit(fit, fit.Solve(last_.structure, rates, last_.smoothness, last_.active));
    if (found.x.size() == 0 || !std::isfinite(found.cost)) return {};
    last_ = std::move(found);
    return {.cost = last_.cost,
            .rmse_V = std::sqrt(std::max(last_.square, 0.0) / of_.scales.weight_sum)};
  }

 private:
  std::string name_;
  const ProfiledFit& of_;
  GivenParameters known_;
  JointSolution last_;
};

}  // namespace

Profiled ProfiledNames(const JointStructure& structure,
                       bool diffusion,
                       bool capacitances,
                       const GivenParameters& known) {
  Profiled names;
  const auto add = [&](const std::string& name, const std::string& twin = "") {
    const bool held = known.Fixed(name) || known.Mentions(twin);
    (held ? names.fixed : names.free).push_back(name);
  };
  const auto add_table = [&](const std::string& name) {
    if (structure.nodes() == 1 || known.Fixed(name)) {
      add(name);
    } else {
      names.tables.push_back(name);
    }
  };
  if (diffusion) add("beta");
  add_table("r_s");
  for (int j = 1; j <= structure.branches; ++j) {
    const auto c = fmt::format("c_{}", j);
    const auto tau = fmt::format("tau_{}", j);
    add_table(fmt::format("r_{}", j));
    add(tau, c);
    if (capacitances) add(c, tau);
  }
  // Those behind beta and the time constants. Neither the sensor nor the capacity reference is a
  // parameter of the voltage of a cell.
  JointSetup setup;
  setup.diffusion = diffusion;
  for (const JointRate& rate : AllRates(structure, setup, {})) {
    if (rate.slot > structure.branches && rate.name != "i_off" && rate.name != "alpha")
      add(rate.name);
  }
  return names;
}

std::vector<Profile> ProfileFit(const std::vector<std::string>& names,
                                const ProfiledFit& fit,
                                const TrustReport& trust) {
  const QuantityTrust* series = FindQuantity(trust, "r_s");
  std::vector<ProfileTask> tasks;
  for (const std::string& name : names) {
    const Held held = HeldAt(name, fit);
    ProfileTask task;
    task.name = name;
    task.unit = std::string(CellParameterUnit(name));
    task.estimate = held.estimate;
    task.lower = held.lower;
    task.upper = held.upper;
    // A resistance at zero: as far as the series resistance is uncertain, which it would take from.
    if (series != nullptr) task.typical_reach = Reach95(*series);
    if (!std::isfinite(task.typical_reach)) task.typical_reach = fit.typical_Ohm;
    task.begin = [&fit, name]() -> Refit {
      auto refit = std::make_shared<HeldFit>(name, fit);
      return [refit](double value) { return (*refit)(value); };
    };
    tasks.push_back(std::move(task));
  }
  return FindProfiles(tasks, trust);
}

}  // namespace lipoid
