#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "identify/trust/trust.h"

namespace lipoid {
namespace {

// Time constants up to so many steps of the sampling show in the first rows of an edge alone.
constexpr double kNearSampling = 3.0;

// Of so many weak quantities the worst is named alone; more are a trait of the logs.
constexpr std::size_t kFew = 2;

// "tau_2" is the 2 of "tau".
struct Name {
  std::string_view family;
  std::string_view branch;
};

Name Split(std::string_view name) {
  const auto bar = name.find('_');
  if (bar == std::string_view::npos) return {name, ""};
  const auto rest = name.substr(bar + 1);
  const bool number = !rest.empty() && std::all_of(rest.begin(), rest.end(), [](char c) {
    return c >= '0' && c <= '9';
  });
  return number ? Name{name.substr(0, bar), rest} : Name{name, ""};
}

bool OfBranch(std::string_view name) { return !Split(name).branch.empty(); }

std::string Join(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t k = 0; k < names.size(); ++k)
    text += (k == 0 ? "" : k + 1 < names.size() ? ", " : " and ") + names[k];
  return text;
}

class Advisor {
 public:
  explicit Advisor(const TrustReport& report) : report_(report) {}

  std::string Sentence() {
    std::vector<std::string> parts;
    for (const auto& say : {&Advisor::BranchNotFound,
                            &Advisor::BranchTooFast,
                            &Advisor::OpenByModel,
                            &Advisor::NotToldApart,
                            &Advisor::AtBound,
                            &Advisor::Weak}) {
      if (auto part = (this->*say)()) parts.push_back(std::move(*part));
    }
    if (parts.empty()) return AllWell();
    // One thing to know, and at most one more.
    return parts.size() == 1 ? parts[0] : parts[0] + "; also, " + parts[1];
  }

 private:
  // Quantities of a branch, of which no more is to be said.
  void Done(std::string_view branch) {
    for (const auto& q : report_.quantities) {
      if (Split(q.name).branch == branch) done_.push_back(q.name);
    }
  }
  [[nodiscard]] bool Open(const std::string& name) const {
    return std::find(done_.begin(), done_.end(), name) == done_.end();
  }

  // A capacitance is as weak as the two that it is made of.
  [[nodiscard]] bool FollowsFromOthers(const QuantityTrust& q) const {
    const Name name = Split(q.name);
    return name.family == "c" &&
           FindQuantity(report_, "tau_" + std::string(name.branch)) != nullptr;
  }

  // The thesis' situation: r_j -> 0 leaves tau_j (or c_j) at its start.
  std::optional<std::string> BranchNotFound() {
    std::vector<std::string> gone;
    for (const auto& q : report_.quantities) {
      const Name name = Split(q.name);
      if (name.family != "r" || name.branch.empty()) continue;
      const std::string branch(name.branch);
      const auto* inertia = FindQuantity(report_, "tau_" + branch);
      if (inertia == nullptr) inertia = FindQuantity(report_, "c_" + branch);
      const bool at_zero = q.verdict == Verdict::kAtBound && !(q.estimate > 0.0);
      // Noise leaves a branch that is not there a little resistance.
      const bool maybe_zero = q.verdict == Verdict::kWeak && !(q.low > 0.0);
      if (!at_zero && !maybe_zero && !(inertia != nullptr && inertia->insensitive)) continue;
      gone.push_back(branch);
      Done(branch);
    }
    if (gone.empty()) return std::nullopt;
    return gone.size() == 1 ? fmt::format(
                                  "branch {0} was not found: r_{0} cannot be told from zero, and "
                                  "its time constant means nothing; a model with one branch less "
                                  "says the same",
                                  gone[0])
                            : fmt::format(
                                  "branches {} were not found: their resistances cannot be told "
                                  "from zero, and their time constants mean nothing; a model "
                                  "without them says the same",
                                  Join(gone));
  }

  std::optional<std::string> BranchTooFast() {
    for (const auto& q : report_.quantities) {
      const Name name = Split(q.name);
      if (name.family != "tau" || !Open(q.name) || q.verdict == Verdict::kIdentified) continue;
      if (!(q.estimate < report_.sampling_s)) continue;
      const std::string branch(name.branch);
      Done(branch);
      done_.emplace_back("r_s");
      return fmt::format(
          "branch {0} (tau_{0} = {1:.2g} s) is faster than the sampling ({2:.2g} s), so that r_{0} "
          "cannot be told from r_s; faster sampling at the edges of the pulses would tell them "
          "apart",
          branch,
          q.estimate,
          report_.sampling_s);
    }
    return std::nullopt;
  }

  // No experiment of the same kind would tell: more of its rows only lower the noise.
  std::optional<std::string> OpenByModel() {
    std::vector<std::string> names;
    const QuantityTrust* worst = nullptr;
    for (const auto& q : report_.quantities) {
      if (!q.open_by_model || q.verdict != Verdict::kWeak || !Open(q.name) || FollowsFromOthers(q))
        continue;
      names.push_back(q.name);
      if (worst == nullptr || q.relative_standard_error > worst->relative_standard_error)
        worst = &q;
    }
    if (worst == nullptr) return std::nullopt;
    done_.insert(done_.end(), names.begin(), names.end());
    const double of_noise = std::sqrt(
        std::max(0.0, 1.0 - std::pow(worst->model_standard_error / worst->standard_error, 2)));
    return fmt::format(
        "the noise of these logs leaves {} open to {:.2g} %, other structures of the cell that "
        "predict them nearly as well, or what was held, to {:.2g} % (one standard error); give the "
        "structure if you know it, or add logs at other currents and with other rests",
        names.size() <= kFew ? Join(names) : worst->name,
        100.0 * of_noise * worst->relative_standard_error,
        100.0 * worst->relative_standard_error);
  }

  std::optional<std::string> NotToldApart() {
    // The widest of them, with its partners.
    const QuantityTrust* worst = nullptr;
    for (const auto& q : report_.quantities) {
      if (q.verdict != Verdict::kOnlyInCombination || !Open(q.name)) continue;
      // A partner of which all is said already tells nothing new.
      const auto is_open = [&](const auto& name) { return Open(name); };
      if (std::none_of(q.with.begin(), q.with.end(), is_open)) continue;
      if (worst == nullptr || q.relative_standard_error > worst->relative_standard_error)
        worst = &q;
    }
    if (worst == nullptr) return std::nullopt;
    std::vector<std::string> group{worst->name};
    group.insert(group.end(), worst->with.begin(), worst->with.end());
    for (const auto& q : report_.quantities) {
      const bool related = std::any_of(q.with.begin(), q.with.end(), [&](const auto& name) {
        return std::find(group.begin(), group.end(), name) != group.end();
      });
      if (related && std::find(group.begin(), group.end(), q.name) == group.end() && Open(q.name))
        group.push_back(q.name);
    }
    done_.insert(done_.end(), group.begin(), group.end());
    return fmt::format(
        "{} cannot be told apart by these logs; {}", Join(group), WhatWouldTell(group));
  }

  [[nodiscard]] std::string WhatWouldTell(const std::vector<std::string>& group) const {
    const auto has = [&](std::string_view name) {
      return std::find(group.begin(), group.end(), name) != group.end();
    };
    std::vector<std::string> branches;
    for (const auto& name : group) {
      const std::string branch(Split(name).branch);
      if (!branch.empty() && std::find(branches.begin(), branches.end(), branch) == branches.end())
        branches.push_back(branch);
    }
    // Diffusion goes on long after a branch has relaxed: rests show which of the two it was.
    if (has("beta") && !branches.empty()) return "longer rests would";
    if (has("r_s") && !branches.empty()) {
      const auto* tau = FindQuantity(report_, "tau_" + branches[0]);
      if (tau != nullptr && tau->estimate < kNearSampling * report_.sampling_s)
        return "faster sampling at the edges of the pulses would";
      return "faster sampling at the edges, or longer pulses, would";
    }
    // The modes beyond the sampling act as a resistance.
    if (has("beta") && has("r_s")) return "longer pulses and rests would";
    if (branches.size() > 1) return "longer rests would, or one branch less";
    if (branches.size() == 1) {
      const auto* tau = FindQuantity(report_, "tau_" + branches[0]);
      const bool fast = tau != nullptr && tau->estimate < kNearSampling * report_.sampling_s;
      return fast ? "faster sampling at the edges of the pulses would"
                  : "pulses and rests of several time constants would";
    }
    if (has("alpha")) return "discharges at currents further apart would";
    return "pulses of other lengths and rates would";
  }

  // That the logs would be fitted as well or better beyond the limit is among the caveats.
  std::optional<std::string> AtBound() {
    std::vector<std::string> names;
    for (const auto& q : report_.quantities) {
      if (q.verdict == Verdict::kAtBound && Open(q.name)) names.push_back(q.name);
    }
    if (names.empty()) return std::nullopt;
    return names.size() == 1
               ? fmt::format(
                     "{} is at a limit of its range, which suggests an effect that the model lacks",
                     names[0])
               : fmt::format(
                     "{} are at limits of their ranges, which suggests an effect that the model "
                     "lacks",
                     Join(names));
  }

  std::optional<std::string> Weak() {
    const QuantityTrust* worst = nullptr;
    std::size_t weak = 0;
    for (const auto& q : report_.quantities) {
      if (q.verdict == Verdict::kIdentified || q.verdict == Verdict::kAtBound || !Open(q.name))
        continue;
      if (q.verdict == Verdict::kOnlyInCombination) continue;  // said, or its partner was
      if (FollowsFromOthers(q)) continue;
      ++weak;
      if (worst == nullptr || q.relative_standard_error > worst->relative_standard_error)
        worst = &q;
    }
    if (worst == nullptr) return std::nullopt;
    const std::string which = weak <= kFew
                                  ? fmt::format("{} is weak", worst->name)
                                  : fmt::format("{} of {} quantities are weak, {} the most",
                                                weak,
                                                report_.quantities.size(),
                                                worst->name);
    return fmt::format("{} ({}); {}", which, HowWeak(*worst), WhatWouldHelp(*worst));
  }

  static std::string HowWeak(const QuantityTrust& q) {
    if (!std::isfinite(q.relative_standard_error)) return "these logs do not show it at all";
    const double share = q.relative_standard_error;
    if (share < 0.995) return fmt::format("standard error {:.2g} %", 100.0 * share);
    // More than the value itself is easier read in multiples of it.
    if (share < 99.5) return fmt::format("standard error {:.2g} times its value", share);
    return "standard error over a hundred times its value";
  }

  [[nodiscard]] std::string WhatWouldHelp(const QuantityTrust& q) const {
    const Name name = Split(q.name);
    if (q.name == "alpha")
      return "discharges at currents further apart, or more of them, would help";
    if (q.name == "beta") return "longer pulses and rests at a higher rate would help";
    if (q.name == "r_s") return "a higher rate, or faster sampling at the edges, would help";
    if (name.family == "tau" && q.estimate < kNearSampling * report_.sampling_s)
      return "faster sampling at the edges of the pulses would help";
    if (OfBranch(q.name)) return "longer rests, or a higher rate, would help";
    return "longer logs that excite it more would help";
  }

  [[nodiscard]] std::string AllWell() const {
    const QuantityTrust* worst = nullptr;
    for (const auto& q : report_.quantities) {
      if (worst == nullptr || q.relative_standard_error > worst->relative_standard_error)
        worst = &q;
    }
    if (worst == nullptr) return "every parameter was given";
    return fmt::format(
        "every parameter is identified; the least certain is {}, to {:.2g} % (one "
        "standard error)",
        worst->name,
        100.0 * worst->relative_standard_error);
  }

  const TrustReport& report_;
  std::vector<std::string> done_;
};

}  // namespace

std::string TrustSentence(const TrustReport& report) { return Advisor(report).Sentence(); }

}  // namespace lipoid
