#include "identify/joint/joint_profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "model/battery/cell_parameters.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Of the logarithms of the rates that are refitted: what it leaves of the cost is its square.
constexpr double kStep = 1e-3;

// A parameter as the run knows it.
struct Held {
  std::string unit;
  double estimate = 0.0;
  double lower = 0.0;
  double upper = kInfinity;
  double* (*entry)(JointRates&, int) = nullptr;  ///< of a rate
  int index = 0;
};

// Those that can be held at a value, by the names that users see, and those that cannot.
struct Offered {
  std::vector<std::pair<std::string, Held>> held;
  std::vector<std::string> fixed;
  std::vector<std::string> tables;

  [[nodiscard]] std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const auto& [name, ignored] : held) names.push_back(name);
    return names;
  }
};

Offered OfferedBy(const JointResult& result, const GivenParameters& known) {
  const JointSolution& best = result.choice.best;
  const JointLayout layout(best.structure);
  const JointFit fit(result.logs, result.setup, known);
  const auto searched = fit.Rates(best.structure);
  Offered all;
  const auto add_rate = [&](const std::string& name) {
    const auto found = std::find_if(
        searched.begin(), searched.end(), [&](const auto& other) { return other.name == name; });
    if (found == searched.end()) {
      all.fixed.push_back(name);
      return;
    }
    JointRates rates = best.rates;
    all.held.push_back({name,
                        {.unit = std::string(CellParameterUnit(name)),
                         .estimate = *found->entry(rates, found->index),
                         .lower = found->lower,
                         .upper = found->upper,
                         .entry = found->entry,
                         .index = found->index}});
  };
  const auto add_table = [&](const std::string& name, int at) {
    if (known.Fixed(name)) {
      all.fixed.push_back(name);
    } else if (layout.nodes() > 1) {
      all.tables.push_back(name);
    } else {
      Held held;
      held.unit = "Ohm";
      held.estimate = best.x[at] / result.logs.typical_A;
      all.held.push_back({name, held});
    }
  };
  if (result.setup.diffusion) add_rate("beta");
  add_table("r_s", layout.series());
  for (int j = 0; j < best.structure.branches; ++j) {
    add_table(fmt::format("r_{}", j + 1), layout.branch(j));
    add_rate(fmt::format("tau_{}", j + 1));
  }
  if (best.structure.self_heating) add_rate("tau_h");
  if (best.structure.charge_transfer) add_rate("i_0");
  return all;
}

// The fit with one parameter held, from the rates of the last one.
class HeldFit {
 public:
  HeldFit(std::string name, const Held& held, const JointResult& result, GivenParameters known)
      : name_(std::move(name)),
        held_(held),
        result_(result),
        known_(std::move(known)),
        last_(result.choice.best) {}

  ProfileCost operator()(double value) {
    known_.fixed[name_] = value;
    const JointFit fit(result_.logs, result_.setup, known_);
    JointRates rates = last_.rates;
    if (held_.entry != nullptr) *held_.entry(rates, held_.index) = value;
    JointSolution found =
        fit.Polish(fit.Solve(last_.structure, rates, last_.smoothness, last_.at_zero), kStep);
    if (found.x.size() == 0 || !std::isfinite(found.cost)) return {};
    last_ = std::move(found);
    return {.cost = last_.cost,
            .rmse_V = std::sqrt(std::max(last_.square, 0.0) / result_.logs.weight_sum)};
  }

 private:
  std::string name_;
  Held held_;
  const JointResult& result_;
  GivenParameters known_;
  JointSolution last_;
};

}  // namespace

void CheckJointProfile(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (name == "alpha") {
      throw OptionError(
          "option --profile: alpha is a convention of the joint method and moves no voltage; "
          "see its interval in the report");
    }
    if (name.rfind("c_", 0) == 0) {
      throw OptionError(
          fmt::format("option --profile: the joint method knows branches by their time constants; "
                      "profile tau_{} instead of {}",
                      name.substr(2),
                      name));
    }
  }
}

std::vector<Profile> ProfileJoint(const std::vector<std::string>& names,
                                  const JointResult& result,
                                  const TrustReport& trust,
                                  const std::map<std::string, std::pair<double, double>>& bounds) {
  CheckJointProfile(names);
  const GivenParameters known{.fixed = result.fixed, .bounds = bounds};
  const Offered offered = OfferedBy(result, known);
  for (const std::string& name : names) {
    if (std::find(offered.tables.begin(), offered.tables.end(), name) == offered.tables.end())
      continue;
    throw OptionError(
        fmt::format("option --profile: {} is a table over the state of charge here, and no single "
                    "value can be held; --set joint.resistance_nodes=1 makes it one number",
                    name));
  }
  CheckProfileNames(names, offered.Names(), offered.fixed);

  const QuantityTrust* series = FindQuantity(trust, "r_s");
  std::vector<ProfileTask> tasks;
  for (const std::string& name : names) {
    const auto& found = *std::find_if(offered.held.begin(),
                                      offered.held.end(),
                                      [&](const auto& other) { return other.first == name; });
    const Held& held = found.second;
    ProfileTask task;
    task.name = name;
    task.unit = held.unit;
    task.estimate = held.estimate;
    task.lower = held.lower;
    task.upper = held.upper;
    // A resistance at zero: as far as the series resistance is uncertain, which it would take from.
    if (series != nullptr) task.typical_reach = Reach95(*series);
    if (!std::isfinite(task.typical_reach)) task.typical_reach = 0.1 / result.logs.typical_A;
    task.begin = [&result, &known, name, held]() -> Refit {
      auto fit = std::make_shared<HeldFit>(name, held, result, known);
      return [fit](double value) { return (*fit)(value); };
    };
    tasks.push_back(std::move(task));
  }
  return FindProfiles(tasks, trust);
}

}  // namespace lipoid
