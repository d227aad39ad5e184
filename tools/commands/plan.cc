// lipoid plan CELL: what an experiment would tell, before the lab is booked.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/trust/plan_grid.h"
#include "model/battery/cell_file.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"
#include "tools/commands/trust_text.h"

namespace lipoid {

cli::ExitCode PlanCommand(cli::CommandLine& line) {
  std::string cell_name;
  PlanGrid grid;
  line.Describe(
      "Predicts the standard errors that a pulse experiment would give for a cell like this one, "
      "before the lab is booked: the thesis' protocol, and variations of its pulses. Lists "
      "(10,30,60) and ranges (10:10:60) are combined with one another, one row each.",
      "lipoid plan gifi-600mAh-1 --pulse-s 10,30,60 --rest-s 600,1770");
  line.Example("lipoid plan cell.json --rate-C 1:1:4 --sampling-s 0.1,1,10");
  line.InputArgument("CELL", cell_name, "a cell file or the name of a shipped cell");
  line.Each(grid);
  line.ReportOption();
  if (!line.Parse()) return cli::ExitCode::kDone;

  const Cell cell = LoadCell(cell_name);
  const PlanGridResult result =
      PlanVariations(cell, grid, [&](double share) { line.progress().Update(share, "planning"); });

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
    if (!table) table.emplace(columns, "What each experiment would tell: standard errors in %.");
    table->Row(cells);
  }
  line.Print("Standard errors that the pulses would give, in % of each parameter\n\n{}\n",
             table->Text());
  if (result.variations.size() == 1) line.Print("{}\n\n", result.variations[0].plan.trust.sentence);
  line.Print("{}", cli::Bullets("Left out", result.left_out));
  line.summary() = PlanGridToJson(cell, grid, result);
  return cli::ExitCode::kDone;
}

}  // namespace lipoid
