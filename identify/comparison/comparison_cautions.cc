#include "identify/comparison/comparison_cautions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace lipoid {
namespace {

// What the optimizers that found a fit left at a bound; "": nothing.
std::string AtBounds(const Comparison& comparison, double decades) {
  std::vector<std::string> sentences;
  for (std::size_t k = 0; k < comparison.variables.size(); ++k) {
    const PulseVariable& v = comparison.variables[k];
    for (const bool lower : {true, false}) {
      std::vector<std::string> who;
      double value = 0.0;
      for (const auto& r : comparison.results) {
        const double found = Entry(r.parameters, v);
        if (std::count(r.at_bound.begin(), r.at_bound.end(), v.name) == 0 || IsOfNoBranch(r, v) ||
            lower != (found - v.lower < comparison.boxed[k].upper - found))
          continue;
        who.push_back(r.optimizer);
        value = lower ? v.lower : comparison.boxed[k].upper;
      }
      if (who.empty()) continue;
      std::string what;
      if (lower && v.kind == PulseVariable::Kind::kResistance) what = ", which is no such branch,";
      if (!lower && std::isinf(v.upper)) {
        what = fmt::format(
            ", the end of the box that is searched (more than --set decades={:g} widens it),",
            decades);
      }
      sentences.push_back(fmt::format("{} ended at its bound of {:.6g}{} with {}",
                                      v.name,
                                      value,
                                      what,
                                      who.size() == comparison.results.size() && who.size() > 1
                                          ? "every optimizer"
                                          : fmt::format("{}", fmt::join(who, ", "))));
    }
  }
  return sentences.empty()
             ? ""
             : fmt::format("{}: such a value is no finding.", fmt::join(sentences, "; "));
}

// Where a branch is slower than any that the logs can show: "" where none is.
std::string SlowBranches(const PulseTask& task, const Comparison& comparison) {
  const double longest_s = FindPulseScales(task.data, task.sweep.setup().alpha_C).longest_tau_s;
  std::vector<std::string> sentences;
  for (std::size_t j = 0; j < comparison.start.sweep.resistance_Ohm.size(); ++j) {
    std::vector<std::string> who;
    for (const auto& r : comparison.results) {
      const SweepParameters& found = r.parameters.sweep;
      if (found.resistance_Ohm[j] > 0.0 && found.time_constant_s[j] > longest_s)
        who.push_back(r.optimizer);
    }
    if (who.empty()) continue;
    sentences.push_back(fmt::format(
        "tau_{0} = r_{0} c_{0} of {1} is beyond {2:.5g} s, the longest that these logs can show: the branch is "
        "a capacitor there, and its r_{0} is no finding",
        j + 1,
        fmt::join(who, ", "),
        longest_s));
  }
  return sentences.empty() ? "" : fmt::format("{}.", fmt::join(sentences, "; "));
}

}  // namespace

bool IsOfNoBranch(const OptimizerComparison& result, const PulseVariable& v) {
  if (v.kind != PulseVariable::Kind::kCapacitance && v.kind != PulseVariable::Kind::kTimeConstant)
    return false;
  return std::count(result.gone.begin(), result.gone.end(), v.branch) > 0;
}

std::string WhyNoAnswer(const Comparison& comparison) {
  if (comparison.best_optimizer.empty())
    return "no optimizer found a finite cost; the table says why";
  std::vector<std::string> reasons;
  for (const ComparisonRun& run : comparison.runs) {
    if (!run.is_best) continue;
    std::string reason = FindOptimizer(run.optimizer).WhyNoAnswer(run.summary);
    if (reason.empty()) {
      if (comparison.best_fit.grade != FitGrade::kPoor) return "";
      return fmt::format(
          "the best fit of this run {}: no success, whatever its gap; try random starts (--starts "
          "20), or another start (--start)",
          comparison.best_fit.Sentence("these logs"));
    }
    if (std::find(reasons.begin(), reasons.end(), reason) == reasons.end())
      reasons.push_back(std::move(reason));
  }
  return fmt::format("the best is where an optimizer was stopped, and no answer: {}",
                     fmt::join(reasons, "; "));
}

std::vector<std::string> ComparisonCautions(const PulseTask& task,
                                            const Comparison& comparison,
                                            double decades) {
  std::vector<std::string> cautions{AtBounds(comparison, decades), SlowBranches(task, comparison)};
  std::erase(cautions, "");
  return cautions;
}

}  // namespace lipoid
