#include "identify/comparison/comparison_report.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/stages/staged_report.h"

namespace lipoid {
namespace {

Json ResultToJson(const OptimizerComparison& result, bool diffusion) {
  const OptimizationSummary& summary = result.summary;
  Json improvements = Json::array();
  for (const auto& i : summary.improvements) {
    improvements.push_back(
        {{"evaluations", i.evaluations}, {"wall_s", i.wall_s}, {"cost_V2", i.cost}});
  }
  return {{"optimizer", result.optimizer},
          {"mean_error_percent", NumberOrNull(result.errors.metrics.mean_error_percent)},
          {"max_error_percent", NumberOrNull(result.errors.metrics.max_error_percent)},
          {"rmse_V", NumberOrNull(result.errors.metrics.rmse)},
          {"cost_V2", NumberOrNull(summary.cost)},
          {"gap_percent", NumberOrNull(100.0 * result.gap)},
          {"wall_s", summary.wall_s},
          {"iterations", summary.iterations},
          {"evaluations", summary.evaluations},
          {"gradient_evaluations", summary.gradient_evaluations},
          {"termination", options_internal::ToText(summary.termination)},
          {"message", summary.message},
          {"parameters", SweepParametersToJson(result.parameters.sweep, diffusion)},
          {"starts", result.starts},
          {"successes", result.successes},
          {"success_rate", result.success_rate()},
          {"best_cost_V2", NumberOrNull(result.best_cost)},
          {"time_to_target_s", NumberOrNull(result.time_to_target_s)},
          {"evaluations_to_target", NumberOrNull(result.evaluations_to_target)},
          {"improvements", std::move(improvements)}};
}

}  // namespace

Json ComparisonToJson(const Comparison& comparison, bool diffusion) {
  Json problem = Json::array();
  for (std::size_t k = 0; k < comparison.variables.size(); ++k) {
    const PulseVariable& v = comparison.variables[k];
    problem.push_back({{"parameter", v.name},
                       {"unit", v.unit},
                       {"logarithmic", v.logarithmic},
                       {"start", Entry(comparison.start, v)},
                       {"lower", v.lower},
                       {"upper", NumberOrNull(v.upper)},
                       {"box_upper", comparison.boxed[k].upper}});
  }
  Json results = Json::array();
  for (const auto& result : comparison.results) results.push_back(ResultToJson(result, diffusion));
  return {
      {"problem", std::move(problem)},
      {"best",
       {{"optimizer", comparison.best_optimizer}, {"cost_V2", NumberOrNull(comparison.best_cost)}}},
      {"results", std::move(results)}};
}

std::string ComparisonToCsv(const Comparison& comparison, bool diffusion) {
  const char* const columns[] = {"mean_error_percent",
                                 "max_error_percent",
                                 "rmse_V",
                                 "cost_V2",
                                 "gap_percent",
                                 "wall_s",
                                 "iterations",
                                 "evaluations",
                                 "gradient_evaluations",
                                 "termination",
                                 "starts",
                                 "successes",
                                 "success_rate",
                                 "time_to_target_s",
                                 "evaluations_to_target"};
  std::string text = "optimizer";
  for (const char* column : columns) text += fmt::format(",{}", column);
  bool header = true;
  std::string rows;
  // null is an empty cell; names hold neither commas nor quotes.
  const auto cell = [](const Json& value) {
    return value.is_null() ? "" : value.is_string() ? value.get<std::string>() : value.dump();
  };
  for (const auto& result : comparison.results) {
    const Json json = ResultToJson(result, diffusion);
    rows += result.optimizer;
    for (const char* column : columns) rows += "," + cell(json.at(column));
    for (const auto& [name, value] : json.at("parameters").items()) {
      if (header) text += "," + name;
      rows += "," + cell(value);
    }
    header = false;
    rows += "\n";
  }
  return text + "\n" + rows;
}

}  // namespace lipoid
