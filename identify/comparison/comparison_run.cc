#include "identify/comparison/comparison_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

#include "identify/comparison/comparison_cautions.h"
#include "identify/comparison/comparison_report.h"
#include "identify/identification.h"
#include "model/core/errors.h"

namespace lipoid {

std::vector<std::string> ThesisOptimizers() {
  std::vector<std::string> names;
  for (const auto& entry : Optimizers()) {
    if (entry.in_thesis) names.emplace_back(entry.name);
  }
  return names;
}

std::vector<const OptimizerEntry*> FindOptimizers(const std::vector<std::string>& names) {
  if (names.empty()) throw OptionError("option --optimizers: expected at least one, found none");
  std::vector<const OptimizerEntry*> chosen;
  if (names.size() == 1 && names[0] == "all") {
    for (const auto& entry : Optimizers()) chosen.push_back(&entry);
    return chosen;
  }
  for (const std::string& name : names) {
    if (name == "all")
      throw OptionError("option --optimizers: all stands alone; leave the other names out");
    const OptimizerEntry& entry = FindOptimizer(name);
    if (std::find(chosen.begin(), chosen.end(), &entry) != chosen.end()) {
      throw OptionError(fmt::format("option --optimizers: {} stands there twice", entry.name));
    }
    chosen.push_back(&entry);
  }
  return chosen;
}

void ComparisonRequest::Resolve() {
  (void)FindOptimizers(optimizers);
  const GivenParameters& given = staged.given.parameters;
  const auto refuse = [&](const auto& words, std::string_view option) {
    for (const auto& [name, value] : words) {
      if (!time_constants || !name.starts_with("c_")) continue;
      throw OptionError(fmt::format(
          "--{} {} goes with capacitances, which --time-constants puts tau_{} in place of: say it of that",
          option,
          name,
          name.substr(2)));
    }
  };
  refuse(given.fixed, "fix");
  refuse(given.start, "start");
  refuse(given.bounds, "bounds");
  staged.Resolve();
}

ComparisonRunResult RunComparison(const Campaign& campaign,
                                  const std::vector<LoadedLog>& logs,
                                  const ComparisonRequest& request,
                                  const ComparisonProgress& progress) {
  PulseTask task = PreparePulses(campaign, logs, request.staged.options, request.staged.given);
  const PulseUnknowns unknowns =
      FindPulseUnknowns(task.sweep.setup(),
                        task.data,
                        {.branches = request.staged.options.pulses.branches,
                         .beta_start_per_sqrt_s = task.beta_start_per_sqrt_s,
                         .capacitances = !request.time_constants,
                         .scale = request.options.scaling},
                        request.staged.given.parameters);
  if (unknowns.variables.empty()) {
    throw OptionError("every parameter is held by --fix: there is nothing to compare");
  }
  Comparison comparison = CompareOptimizers(task.sweep,
                                            unknowns,
                                            FindOptimizers(request.optimizers),
                                            request.settings,
                                            request.starts,
                                            request.options,
                                            progress);
  return {std::move(task), std::move(comparison)};
}

Json ComparisonRunToJson(const Campaign& campaign,
                         const ComparisonRequest& request,
                         const ComparisonRunResult& result) {
  Json json = {{"campaign", campaign.name},
               {"rows", result.task.sweep.rows()},
               {"points", result.task.sweep.points()},
               {"alpha_C", result.task.found.alpha_C},
               {"alpha_source", result.task.found.alpha_source},
               {"done_instead", result.task.found.done_instead},
               {"options", OptionsToJson<Json>(request.options)}};
  json["options"].update(StagedOptionsToJson(request.staged.options, request.staged.given));
  for (const OptimizerEntry* optimizer : FindOptimizers(request.optimizers)) {
    Json& own = json["options"][std::string(optimizer->name)];
    for (const auto& [name, value] : optimizer->values(request.settings)) own[name] = value;
  }
  const std::string no_answer = WhyNoAnswer(result.comparison);
  json["no_answer_because"] = no_answer.empty() ? Json(nullptr) : Json(no_answer);
  json["cautions"] = ComparisonCautions(result.task, result.comparison, request.options.decades);
  json.update(ComparisonToJson(result.comparison, result.task.sweep.setup().diffusion));
  return json;
}

}  // namespace lipoid
