// lipoid ageing CELL...: what changed between identified cells of several ages.
#include "identify/ageing.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "model/battery/cell_file.h"
#include "model/battery/fit_record.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"

namespace lipoid {
namespace {

std::string NameOf(ChangeVerdict verdict) { return options_internal::ToText(verdict); }

Json ValueToJson(const AgedValue& at) {
  return {{"value", NumberOrNull(at.value)},
          {"interval_95", {NumberOrNull(at.low), NumberOrNull(at.high)}},
          {"change_percent", NumberOrNull(at.change_percent)},
          {"change_interval_95_percent",
           {NumberOrNull(at.change_low_percent), NumberOrNull(at.change_high_percent)}},
          {"verdict", NameOf(at.verdict)}};
}

}  // namespace

cli::ExitCode AgeingCommand(cli::CommandLine& line) {
  std::vector<std::string> files;
  line.Describe(
      "Compares the cell files that `lipoid identify` made of one cell at several ages, the first "
      "named being the first: capacity, beta and the resistance at half charge after 1, 10 and 30 "
      "s, each with its change and whether these logs show that it changed.",
      "lipoid ageing new.json after_100_cycles.json after_300_cycles.json");
  line.InputArguments("CELL", files, "cell files of one cell, the youngest first");
  line.ReportOption();
  if (!line.Parse()) return cli::ExitCode::kDone;

  std::vector<Cell> cells;
  Json ages = Json::array();
  for (const std::string& file : files) {
    cells.push_back(LoadCell(file));
    const bool poor = IsOfPoorFit(cells.back());
    ages.push_back({{"file", file}, {"age", AgeOf(cells.back())}, {"poor_fit", poor}});
    if (poor) {
      line.Message(
          "{} does not describe its own logs, as lipoid identify said of it: nothing is compared with it",
          file);
    }
  }
  const auto quantities = CompareAges(cells);
  cli::TextTable table({{"quantity", cli::Align::kLeft},
                        {"cell", cli::Align::kLeft},
                        {"value"},
                        {"unit", cli::Align::kLeft},
                        {"change / %"},
                        {"95 % from"},
                        {"to"},
                        {"verdict", cli::Align::kLeft}},
                       "What changed from age to age.");
  Json rows = Json::array();
  for (const AgedQuantity& quantity : quantities) {
    Json at = Json::array();
    for (std::size_t k = 0; k < cells.size(); ++k) {
      const AgedValue& aged = quantity.at[k];
      const std::string age = AgeOf(cells[k]);
      table.Row({k == 0 ? quantity.what : "",
                 age.empty() ? files[k] : age,
                 cli::Significant(aged.value),
                 quantity.unit,
                 k == 0 ? "" : cli::Significant(aged.change_percent),
                 k == 0 ? "" : cli::Significant(aged.change_low_percent),
                 k == 0 ? "" : cli::Significant(aged.change_high_percent),
                 NameOf(aged.verdict)});
      at.push_back(ValueToJson(aged));
    }
    rows.push_back({{"name", quantity.name}, {"unit", quantity.unit}, {"at", std::move(at)}});
  }
  for (const auto& [k, doubt] : DoubtsAboutAges(quantities)) line.Message("{} {}", files[k], doubt);
  if (const auto doubt = DoubtAboutTemperatures(cells); !doubt.empty()) line.Message("{}", doubt);
  line.summary()["cells"] = std::move(ages);
  line.summary()["quantities"] = std::move(rows);
  line.summary()["messages"] = line.messages();
  line.Print("{}", table.Text());
  if (!quantities.empty() && quantities.back().unit == "Ohm")
    line.Print(
        "Resistances are those at half charge: the drop of the voltage that long after 1C is switched on, "
        "over the current.\n");
  return std::any_of(cells.begin(), cells.end(), &IsOfPoorFit) ? cli::ExitCode::kIncomplete
                                                               : cli::ExitCode::kDone;
}

}  // namespace lipoid
