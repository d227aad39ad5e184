// lipoid plan CELL: what an experiment would tell, before the lab is booked.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/trust/plan_grid.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"
#include "tools/commands/loaded_cell.h"
#include "tools/commands/trust_text.h"

namespace lipoid {
namespace {

std::string ErrorText(const QuantityTrust& q) {
  return std::isinf(q.standard_error) ? "unknown"
                                      : cli::Significant(100.0 * q.relative_standard_error, 3);
}

// "r_1, c_1 weak; the others identified".
std::string DoubtsOf(const TrustReport& trust, bool whole) {
  std::vector<std::pair<std::string, std::vector<std::string>>> doubts;  // by verdict, as they come
  std::size_t doubted = 0;
  for (const auto& q : trust.quantities) {
    if (q.verdict == Verdict::kIdentified) continue;
    ++doubted;
    const std::string verdict = VerdictText(q);
    auto same = std::find_if(
        doubts.begin(), doubts.end(), [&](const auto& one) { return one.first == verdict; });
    if (same == doubts.end()) same = doubts.insert(same, {verdict, {}});
    same->second.push_back(q.name);
  }
  if (doubts.empty()) return whole ? "all identified" : "all identified but what is left out";
  std::vector<std::string> words;
  for (const auto& [verdict, names] : doubts)
    words.push_back(fmt::format("{} {}", fmt::join(names, ", "), verdict));
  if (doubted < trust.quantities.size()) words.emplace_back("the others identified");
  return fmt::format("{}", fmt::join(words, "; "));
}

// What the rows of the table would leave open, rows that leave the same together.
std::string Verdicts(const PlanGridResult& result) {
  std::vector<std::pair<std::string, std::vector<std::size_t>>> verdicts;
  for (std::size_t k = 0; k < result.variations.size(); ++k) {
    const std::string verdict =
        DoubtsOf(result.variations[k].plan.trust, result.terms_left_out.empty());
    auto same = std::find_if(
        verdicts.begin(), verdicts.end(), [&](const auto& one) { return one.first == verdict; });
    if (same == verdicts.end()) same = verdicts.insert(same, {verdict, {}});
    same->second.push_back(k + 1);
  }
  std::string text;
  for (const auto& [verdict, rows] : verdicts) {
    const bool every = rows.size() == result.variations.size();
    text += cli::Wrapped(every ? fmt::format("Verdict: {}.", verdict)
                         : rows.size() == 1
                             ? fmt::format("Row {}: {}.", rows[0], verdict)
                             : fmt::format("Rows {}: {}.", fmt::join(rows, ", "), verdict)) +
            "\n";
  }
  return text;
}

// One row each.
std::string TableOfExperiments(const PlanGridResult& result) {
  std::optional<cli::TextTable> table;
  for (const PlannedVariation& one : result.variations) {
    const PlannedExperiment& plan = one.plan;
    std::vector<std::string> cells{cli::Significant(one.rate_C, 3),
                                   cli::Significant(one.pulse_s, 3),
                                   cli::Significant(one.rest_s, 4),
                                   cli::Significant(one.sampling_s, 3),
                                   cli::Significant(plan.duration_s / 3600.0, 3),
                                   fmt::format("{}", plan.rows)};
    std::vector<cli::TextTable::Column> columns{
        {"rate_C"}, {"pulse_s"}, {"rest_s"}, {"sampling_s"}, {"hours"}, {"rows"}};
    for (const auto& q : plan.trust.quantities) {
      columns.push_back({q.name + "_%"});
      cells.push_back(ErrorText(q));
    }
    if (!table) table.emplace(columns, "What each experiment would tell: standard errors in %.");
    table->Row(cells);
  }
  return table->Text() + "\n" + Verdicts(result);
}

// One column each: a campaign, and what a second temperature adds to it. `from` is the campaign.
std::string TableOfTemperatures(const std::vector<PlannedVariation>& all, std::size_t from) {
  const std::string ambient = fmt::format("{} degC", fmt::join(all[from].ambient_degC, ", "));
  std::vector<cli::TextTable::Column> columns{
      {"parameter", cli::Align::kLeft}, {"estimate"}, {"unit", cli::Align::kLeft}, {ambient}};
  std::size_t to = from + 1;
  for (; to < all.size() && all[to].second != SecondPulses::kNone; ++to) {
    columns.push_back(
        {fmt::format("{} {:g} degC",
                     all[to].second == SecondPulses::kOne ? "+ one pulse at" : "+ pulses at",
                     all[to].second_degC)});
  }
  cli::TextTable table(columns, "What a second temperature would tell: standard errors in %.");
  const auto row = [&](const std::string& name, const std::string& estimate, const auto& text) {
    std::vector<std::string> cells{name, estimate, ""};
    for (std::size_t k = from; k < to; ++k) cells.push_back(text(all[k]));
    return cells;
  };
  for (const QuantityTrust& q : all[to - 1].plan.trust.quantities) {
    auto cells = row(q.name, cli::Significant(q.estimate), [&](const PlannedVariation& one) {
      const QuantityTrust* found = FindQuantity(one.plan.trust, q.name);
      return found == nullptr ? std::string("-") : ErrorText(*found);
    });
    cells[2] = q.unit;
    table.Row(cells);
  }
  table.Row(row("hours", "", [](const PlannedVariation& one) {
    return cli::Significant(one.plan.duration_s / 3600.0, 3);
  }));
  return table.Text();
}

}  // namespace

cli::ExitCode PlanCommand(cli::CommandLine& line) {
  std::string cell_name;
  PlanGrid grid;
  line.Describe(
      "Predicts the standard errors that a pulse experiment would give for a cell like this one, "
      "before the lab is booked: the thesis' protocol, and variations of its pulses. Lists "
      "(10,30,60) and ranges (10:10:60) are combined with one another, one row each. Of a cell that "
      "knows temperature, or with --ambient-degC, the whole protocol is planned as the joint fit would "
      "use it, with activation energies and heat balance, and beside it what a second temperature would "
      "add.",
      "lipoid plan gifi-600mAh-1 --pulse-s 10,30,60 --rest-s 600,1770");
  line.Example("lipoid plan cell.json --rate-C 1:1:4 --sampling-s 0.1,1,10");
  line.Example("lipoid plan cell.json --ambient-degC 25 --second-degC 0,-10");
  line.InputArgument("CELL", cell_name, "a cell file or the name of a shipped cell");
  line.Each(grid);
  line.ReportOption();
  if (!line.Parse()) return cli::ExitCode::kDone;

  const Cell cell = LoadCell(line, cell_name);
  const PlanGridResult result =
      PlanVariations(cell, grid, [&](double share) { line.progress().Update(share, "planning"); });

  if (!result.temperature && line.Given("temperature-noise-degC")) {
    line.Message(
        "option --temperature-noise-degC changes nothing here: this plan has no thermometer; "
        "--ambient-degC plans with one");
  }
  const std::vector<PlannedVariation>& all = result.variations;
  if (result.temperature) {
    for (std::size_t k = 0; k < all.size(); ++k) {
      const PlannedVariation& one = all[k];
      if (one.second == SecondPulses::kNone) {
        line.Print(
            "Standard errors that a campaign would give, in % of each parameter:\n"
            "pulses of {:g} s at {:g}C, rests of {:g} s, rows every {:g} s\n\n{}\n",
            one.pulse_s,
            one.rate_C,
            one.rest_s,
            one.sampling_s,
            TableOfTemperatures(all, k));
      }
      const std::string where = one.second == SecondPulses::kNone
                                    ? fmt::format("{} degC", fmt::join(one.ambient_degC, ", "))
                                    : "Added";
      line.Print("{}\n\n", cli::Wrapped(fmt::format("{}: {}", where, one.plan.trust.sentence)));
    }
  } else {
    line.Print("Standard errors that the pulses would give, in % of each parameter\n\n{}\n",
               TableOfExperiments(result));
    if (all.size() == 1) line.Print("{}\n\n", cli::Wrapped(all[0].plan.trust.sentence));
  }
  line.Print("{}\n\n", cli::Wrapped(NoiseSentence(result)));
  line.Print("{}", cli::Bullets("Left out", result.left_out));
  line.summary() = PlanGridToJson(cell, result);
  line.summary()["messages"] = line.messages();
  return cli::ExitCode::kDone;
}

}  // namespace lipoid
