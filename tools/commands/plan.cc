// lipoid plan CELL: what an experiment would tell, before the lab is booked.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "identify/trust/experiment_plan.h"
#include "identify/trust/trust_report.h"
#include "model/battery/cell_file.h"
#include "model/core/errors.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"
#include "tools/commands/number_range.h"
#include "tools/commands/split.h"
#include "tools/commands/trust_text.h"

namespace lipoid {
namespace {

// "10,30,60", "10:10:60", or both.
std::vector<double> ReadNumbers(const std::string& option,
                                const std::string& text,
                                const Range& valid) {
  std::vector<double> all;
  for (const auto& piece : SplitAt(text, ',')) {
    const auto some = ReadRange(option, piece, valid);
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

}  // namespace

cli::ExitCode PlanCommand(cli::CommandLine& line) {
  const SynthesisOptions thesis;
  constexpr std::size_t kMostVariations = 1000;
  constexpr double kYear_s = 3.2e7;
  std::string cell_name;
  std::string pulse_s = fmt::format("{}", thesis.pulse_s);
  std::string rest_s = fmt::format("{}", thesis.rest_s);
  std::string rate_C;
  std::string sampling_s = "1";
  PlannedNoise noise;
  line.Describe(
      "Predicts the standard errors that a pulse experiment would give for a cell like this one, "
      "before the lab is booked: the thesis' protocol, and variations of its pulses. Lists "
      "(10,30,60) and ranges (10:10:60) are combined with one another, one row each.",
      "lipoid plan gifi-600mAh-1 --pulse-s 10,30,60 --rest-s 600,1770");
  line.Example("lipoid plan cell.json --rate-C 1:1:4 --sampling-s 0.1,1,10");
  line.InputArgument("CELL", cell_name, "a cell file or the name of a shipped cell");
  line.Text("pulse-s", pulse_s, "LIST", "length of a pulse");
  line.Text("rest-s", rest_s, "LIST", "rest after each pulse");
  line.Text("rate-C", rate_C, "LIST", "rate of the pulses; not given: what suits the cell");
  line.Text("sampling-s", sampling_s, "LIST", "time between rows");
  line.Option("voltage-noise-V", noise.white_V, Range{0.0, 1e3}, "independent from row to row");
  line.Option("coloured-noise-V", noise.coloured_V, Range{0.0, 1e3}, "slow errors of the voltage");
  line.Option("correlation-s", noise.correlation_s, Range{1e-6, kYear_s}, "how slow those are");
  line.ReportOption();
  if (!line.Parse()) return cli::ExitCode::kDone;

  const Cell cell = LoadCell(cell_name);
  const auto pulses = ReadNumbers("pulse-s", pulse_s, Range{1e-6, kYear_s});
  const auto rests = ReadNumbers("rest-s", rest_s, Range{0.0, kYear_s});
  const auto rates = rate_C.empty() ? std::vector<double>{HighestSuitableRate(cell)}
                                    : ReadNumbers("rate-C", rate_C, Range{1e-6, 1e4});
  const auto samplings = ReadNumbers("sampling-s", sampling_s, Range{1e-6, 1e6});
  const double shortest_s = *std::min_element(samplings.begin(), samplings.end());
  const Cell seen = AsSampled(cell, shortest_s);
  const std::size_t variations = pulses.size() * rests.size() * rates.size() * samplings.size();
  if (variations > kMostVariations) {
    throw OptionError(fmt::format(
        "{} variations; at most {} at a time, so shorten a list", variations, kMostVariations));
  }

  Json rows = Json::array();
  std::optional<cli::TextTable> table;
  std::string advice;
  std::size_t done = 0;
  for (const double rate : rates) {
    for (const double pulse : pulses) {
      for (const double rest : rests) {
        for (const double sampling : samplings) {
          line.progress().Update(static_cast<double>(done++) / static_cast<double>(variations),
                                 "planning");
          SynthesisOptions options;
          options.pulse_rate_C = rate;
          options.pulse_s = pulse;
          options.rest_s = rest;
          options.sampling_s = sampling;
          const PlannedExperiment plan = PlanExperiment(seen, options, noise);
          std::vector<std::string> cells{cli::Significant(rate, 3),
                                         cli::Significant(pulse, 3),
                                         cli::Significant(rest, 4),
                                         cli::Significant(sampling, 3),
                                         cli::Significant(plan.duration_s / 3600.0, 3),
                                         fmt::format("{}", plan.rows)};
          std::vector<cli::TextTable::Column> columns{
              {"rate_C"}, {"pulse_s"}, {"rest_s"}, {"sampling_s"}, {"hours"}, {"rows"}};
          std::string doubts;
          for (const auto& q : plan.trust.quantities) {
            columns.push_back({q.name + "_%"});
            cells.push_back(std::isinf(q.standard_error)
                                ? "unknown"
                                : cli::Significant(100.0 * q.relative_standard_error, 3));
            if (q.verdict != Verdict::kIdentified)
              doubts += fmt::format("{}{}: {}", doubts.empty() ? "" : "; ", q.name, VerdictText(q));
          }
          columns.push_back({"verdict", cli::Align::kLeft});
          cells.push_back(doubts.empty() ? "all identified" : doubts);
          if (!table) table.emplace(columns);
          table->Row(cells);
          rows.push_back({{"rate_C", rate},
                          {"current_A", plan.current_A},
                          {"pulse_s", pulse},
                          {"rest_s", rest},
                          {"sampling_s", sampling},
                          {"duration_s", plan.duration_s},
                          {"rows", plan.rows},
                          {"parameters", TrustedParametersToJson(plan.trust)},
                          {"sentence", plan.trust.sentence}});
          advice = plan.trust.sentence;
        }
      }
    }
  }
  const auto left_out = LeftOutOfPlan(cell, shortest_s);
  line.Print("Standard errors that the pulses would give, in % of each parameter\n\n{}\n",
             table->Text());
  if (variations == 1) line.Print("{}\n\n", advice);
  line.Print("{}", cli::Bullets("Left out", left_out));
  line.summary()["cell"] = cell.name;
  line.summary()["noise"] = {{"white_V", noise.white_V},
                             {"coloured_V", noise.coloured_V},
                             {"correlation_s", noise.correlation_s}};
  line.summary()["rows"] = std::move(rows);
  line.summary()["left_out"] = left_out;
  return cli::ExitCode::kDone;
}

}  // namespace lipoid
