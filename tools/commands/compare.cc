// lipoid compare CAMPAIGN: optimizers on the same problem, side by side (Tables 4.4-4.6).
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/comparison/comparison_cautions.h"
#include "identify/comparison/comparison_report.h"
#include "identify/comparison/comparison_run.h"
#include "model/battery/cell_parameters.h"
#include "model/core/atomic_file.h"
#include "model/core/counted.h"
#include "model/core/errors.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"
#include "tools/commands/campaign_options.h"
#include "tools/commands/log_options.h"
#include "tools/commands/staged_options.h"

namespace lipoid {
namespace {

using cli::Align;
using cli::Significant;
using cli::TextTable;

std::string ProblemText(const PulseTask& task, const Comparison& comparison) {
  const bool is_beta_free = std::any_of(comparison.variables.begin(),
                                        comparison.variables.end(),
                                        [](const PulseVariable& v) { return v.name == "beta"; });
  std::string text = fmt::format("Problem {}: {} of {}, {} after condensing\n",
                                 !task.sweep.setup().diffusion ? "without diffusion"
                                 : is_beta_free                ? "(4.61)"
                                                               : "(4.60)",
                                 Counted(task.sweep.rows(), "row"),
                                 Counted(task.sweep.logs().size(), "log"),
                                 Counted(task.sweep.points(), "point"));
  TextTable table({{"unknown", Align::kLeft},
                   {"unit", Align::kLeft},
                   {"start"},
                   {"lower"},
                   {"upper"},
                   {"box up to"},
                   {"moved as", Align::kLeft}},
                  "The problem: what is free, where it starts and its bounds.");
  for (std::size_t k = 0; k < comparison.variables.size(); ++k) {
    const PulseVariable& v = comparison.variables[k];
    const std::string over = v.unit == 1.0 ? v.name : fmt::format("{}/{:.4g}", v.name, v.unit);
    table.Row({v.name,
               std::string(CellParameterUnit(v.name)),
               Significant(Entry(comparison.start, v)),
               fmt::format("{:.3g}", v.lower),
               std::isfinite(v.upper) ? fmt::format("{:.3g}", v.upper) : "none",
               Significant(comparison.boxed[k].upper),
               v.logarithmic ? fmt::format("log({})", over) : over});
  }
  return text + table.Text();
}

std::string ResultsText(const Comparison& comparison, int random_starts) {
  const std::string starts =
      random_starts > 0
          ? fmt::format("Of {}, the same for all", Counted(random_starts, "random start"))
          : "Of the data's start alone (--starts N tries random ones)";
  TextTable table({{"optimizer", Align::kLeft},
                   {"mean / %"},
                   {"max / %"},
                   {"rmse / mV"},
                   {"gap / %"},
                   {"time / s"},
                   {"evaluations"},
                   {"gradients"},
                   {"ended", Align::kLeft}},
                  "Optimizers on the same problem.");
  TextTable reached(
      {{"optimizer", Align::kLeft}, {"success"}, {"to target / s"}, {"evaluations to target"}},
      starts + ".");
  std::string why;
  for (const auto& r : comparison.results) {
    table.Row({r.optimizer,
               Significant(r.errors.metrics.mean_error_percent),
               Significant(r.errors.metrics.max_error_percent),
               Significant(1e3 * r.errors.metrics.rmse),
               std::isfinite(r.gap) ? fmt::format("{:.2g}", 100.0 * r.gap) : "-",
               Significant(r.summary.wall_s, 3),
               fmt::format("{}", r.summary.evaluations),
               fmt::format("{}", r.summary.gradient_evaluations),
               options_internal::ToText(r.summary.termination)});
    reached.Row({r.optimizer,
                 fmt::format("{}/{}", r.successes, r.starts),
                 Significant(r.time_to_target_s, 3),
                 Significant(r.evaluations_to_target, 4)});
    why += "  " + cli::Wrapped(fmt::format("{}: {}", r.optimizer, r.summary.message), 2) + "\n";
  }
  const std::string results = table.Text();
  return fmt::format("{}\nWhy each ended\n{}\n{}\n{}", results, why, starts, reached.Text());
}

std::string ParametersText(const Comparison& comparison) {
  std::vector<TextTable::Column> columns{{"optimizer", Align::kLeft}};
  for (const auto& v : comparison.variables) {
    columns.push_back({fmt::format("{} / {}", v.name, CellParameterUnit(v.name))});
  }
  TextTable table(std::move(columns), "What each optimizer found.");
  for (const auto& r : comparison.results) {
    std::vector<std::string> row{r.optimizer};
    for (const auto& v : comparison.variables)
      row.push_back(IsOfNoBranch(r, v) ? "-" : Significant(Entry(r.parameters, v), 6));
    table.Row(std::move(row));
  }
  return table.Text();
}

// "sqp", or all that found the same, and how well it fits.
std::string BestText(const Comparison& comparison) {
  const std::string cost = Significant(comparison.best_cost, 6);
  if (comparison.best_optimizer.empty()) return "Best: none\n";
  const bool started_at_random = comparison.runs.size() > comparison.results.size();
  std::string text = fmt::format("Best: {}, cost {} V².", comparison.best_optimizer, cost);
  if (!comparison.tied.empty()) {
    text = fmt::format(
        "A tie: {} and {} fit equally well{} (cost {} V²; their rms errors differ by "
        "less than a millionth).",
        comparison.best_optimizer,
        fmt::join(comparison.tied, ", "),
        started_at_random ? ", each from its best start, where the table is from the first" : "",
        cost);
  }
  return cli::Wrapped(
             fmt::format("{} The fit {}. Gap and success are against this best of the run.",
                         text,
                         comparison.best_fit.Sentence("these logs"))) +
         "\n";
}

}  // namespace

cli::ExitCode CompareCommand(cli::CommandLine& line) {
  std::vector<std::string> files;
  CampaignOptions campaign_options;
  ComparisonRequest request;
  std::string csv;

  line.Describe(
      "Runs optimizers on the same logs, from the same start, with the same objective: stage 3 of "
      "the thesis in its own unknowns beta, r_s, r_1 and c_1. Shows errors, time, evaluations, why "
      "each ended, and how far it is from the best; with --starts also how often it gets there "
      "from random starts.",
      "lipoid compare campaign.toml");
  line.Example("lipoid compare campaign.toml --optimizers levenberg-marquardt,sqp --starts 20");
  line.Example("lipoid compare campaign.toml --optimizers levenberg-marquardt --set scaling=none");
  line.InputArguments(
      "CAMPAIGN", files, "a campaign file (TOML); none where logs are given by options", 0);
  line.Each(request);
  line.OutputOption(
      "csv",
      csv,
      "CSV",
      "write one line per optimizer and start: start, seed, cost, time, why it ended");
  campaign_options.AddTo(line);
  request.EachGroup([&](std::string_view name, auto& group) { line.Group(name, group); });
  for (const auto& entry : Optimizers()) {
    line.Group(entry.name, entry.options(), [&](std::string_view name, std::string_view text) {
      entry.set(request.settings, name, text);
    });
  }
  line.ReportOption();
  if (!line.Parse()) return cli::ExitCode::kDone;

  CheckSaidOnce(line, request.staged);
  request.Resolve();
  const auto chosen = FindOptimizers(request.optimizers);
  for (const auto& entry : Optimizers()) {
    const bool runs = std::any_of(
        chosen.begin(), chosen.end(), [&](const auto* one) { return one->name == entry.name; });
    if (runs || !line.Sets(std::string(entry.name) + ".")) continue;
    line.Message(
        "options --set {}.* change nothing: {} is none of --optimizers {}; add it there, or leave "
        "them out",
        entry.name,
        entry.name,
        fmt::join(request.optimizers, ","));
  }
  const auto campaigns =
      campaign_options.Campaigns(line, files, request.staged.given.open_circuit_voltage);
  if (campaigns.size() > 1) throw OptionError("one campaign at a time");
  const Campaign& campaign = campaigns[0];
  request.settings.context.seed = line.seed();
  request.settings.context.threads = 0;  // as many as --threads lets run

  CheckCampaign(campaign, request.staged.given.open_circuit_voltage.has_value());
  line.progress().Update(0.0, "reading logs");
  const auto logs = LoadLogs(line, campaign);
  if (const auto doubt = DoubtAboutOneTemperature(logs); !doubt.empty()) line.Message("{}", doubt);
  const ComparisonRunResult result =
      RunComparison(campaign, logs, request, [&](auto what, double share) {
        line.progress().Update(0.1 + 0.9 * share, what);
      });
  const PulseTask& task = result.task;
  const Comparison& comparison = result.comparison;
  line.summary() = ComparisonRunToJson(campaign, request, result);
  line.summary()["messages"] = line.messages();
  const bool diffusion = task.sweep.setup().diffusion;
  if (!csv.empty()) WriteFileAtomically(csv, ComparisonToCsv(comparison, campaign.name, diffusion));

  for (const auto& done : task.found.done_instead) line.Print("Note: {}\n", done);
  const std::string problem = ProblemText(task, comparison);
  const std::string results = ResultsText(comparison, request.starts);
  const std::string parameters = ParametersText(comparison);
  const std::string no_fit = WhyNoAnswer(comparison);
  std::string cautions;
  for (const std::string& caution : ComparisonCautions(task, comparison, request.options.decades))
    cautions += cli::Wrapped(caution) + "\n";
  if (!no_fit.empty()) line.Message("{}", no_fit);
  line.Print("{}\n{}\n{}\n{}{}", problem, results, parameters, BestText(comparison), cautions);
  return no_fit.empty() ? cli::ExitCode::kDone : cli::ExitCode::kIncomplete;
}

}  // namespace lipoid
