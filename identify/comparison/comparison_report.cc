#include "identify/comparison/comparison_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/stages/staged_report.h"
#include "model/battery/cell_parameters.h"
#include "model/core/foreign_text.h"
#include "model/core/run_record.h"

namespace lipoid {
namespace {

// The share of the starts that reached the target within so many seconds or evaluations. With many
// starts every so-manieth success is there, and the last.
Json ReachedToJson(const OptimizerComparison& result) {
  constexpr std::size_t kMostPoints = 200;
  const std::size_t successes = result.reached_s.size();
  const std::size_t points = std::min(successes, kMostPoints);
  Json reached = Json::array();
  for (std::size_t n = 1; n <= points; ++n) {
    const std::size_t count = successes * n / points;
    reached.push_back(
        {{"success_rate", static_cast<double>(count) / static_cast<double>(result.starts)},
         {"wall_s", result.reached_s[count - 1]},
         {"evaluations", result.reached_evaluations[count - 1]}});
  }
  return reached;
}

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
          {"at_bound", result.at_bound},
          {"starts", result.starts},
          {"successes", result.successes},
          {"success_rate", result.success_rate()},
          {"best_cost_V2", NumberOrNull(result.best_cost)},
          {"time_to_target_s", NumberOrNull(result.time_to_target_s)},
          {"evaluations_to_target", NumberOrNull(result.evaluations_to_target)},
          {"reached", ReachedToJson(result)},
          {"improvements", std::move(improvements)}};
}

// A cell of words: RFC 4180.
std::string Quoted(const std::string& words) {
  std::string text = "\"";
  for (const char c : words) text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return text + "\"";
}

}  // namespace

Json ComparisonToJson(const Comparison& comparison, bool diffusion) {
  Json problem = Json::array();
  for (std::size_t k = 0; k < comparison.variables.size(); ++k) {
    const PulseVariable& v = comparison.variables[k];
    problem.push_back({{"parameter", v.name},
                       {"unit", std::string(CellParameterUnit(v.name))},
                       {"scale", v.unit},
                       {"logarithmic", v.logarithmic},
                       {"start", Entry(comparison.start, v)},
                       {"lower", v.lower},
                       {"upper", NumberOrNull(v.upper)},
                       {"box_upper", comparison.boxed[k].upper}});
  }
  Json results = Json::array();
  for (const auto& result : comparison.results) results.push_back(ResultToJson(result, diffusion));
  return {{"problem", std::move(problem)},
          {"best",
           {{"optimizer", comparison.best_optimizer},
            {"cost_V2", NumberOrNull(comparison.best_cost)},
            {"tied", comparison.tied},
            {"fit", FitToJson(comparison.best_fit)}}},
          {"results", std::move(results)}};
}

std::string ComparisonToCsv(const Comparison& comparison,
                            const std::string& campaign,
                            bool diffusion) {
  std::string text = fmt::format(
      "# lipoid {} ({}), lipoid compare {}: one row per optimizer and start; start 0 is "
      "the data's, cost is half the sum of squares; beta in s^-1/2, r in Ohm, c in F, "
      "tau in s\n",
      Version(),
      GitCommit(),
      ForeignText(campaign));
  text +=
      "optimizer,start,seed,cost_V2,gap_percent,reached,iterations,evaluations,"
      "gradient_evaluations,wall_s,termination,reason";
  bool header = true;
  std::string rows;
  // null is an empty cell; names hold neither commas nor quotes.
  const auto cell = [](const Json& value) { return value.is_null() ? "" : value.dump(); };
  for (const auto& run : comparison.runs) {
    const OptimizationSummary& summary = run.summary;
    rows += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}",
                        run.optimizer,
                        run.start,
                        run.seed,
                        cell(NumberOrNull(summary.cost)),
                        cell(NumberOrNull(100.0 * run.gap)),
                        run.reached ? "yes" : "no",
                        summary.iterations,
                        summary.evaluations,
                        summary.gradient_evaluations,
                        cell(NumberOrNull(summary.wall_s)),
                        options_internal::ToText(summary.termination),
                        Quoted(summary.message));
    const Json parameters = SweepParametersToJson(run.parameters.sweep, diffusion);
    for (const auto& [name, value] : parameters.items()) {
      if (header) text += "," + name;
      rows += "," + cell(value);
    }
    header = false;
    rows += "\n";
  }
  return text + "\n" + rows;
}

}  // namespace lipoid
