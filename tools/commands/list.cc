// lipoid list WHAT: from the tables themselves.
#include <fmt/ranges.h>

#include "identify/logs/formats/formats.h"
#include "identify/optimizers/optimizers.h"
#include "identify/synthesis/protocols.h"
#include "model/battery/cell_file.h"
#include "model/core/errors.h"
#include "tools/cli/suggest.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"

namespace lipoid {
namespace {

using cli::Align;
using cli::Significant;

Json ListCells(cli::CommandLine& line) {
  cli::TextTable table({{"cell", Align::kLeft},
                        {"capacity / Ah"},
                        {"cut-off / V"},
                        {"alpha / C"},
                        {"beta / s^-0.5"},
                        {"r_s / Ohm"},
                        {"v_oc(A)", Align::kLeft}});
  Json rows = Json::array();
  for (const auto& name : ShippedCellNames()) {
    const Cell cell = LoadCell(name);
    const double beta = cell.diffusion ? cell.diffusion->beta_per_sqrt_s : 0.0;
    table.Row({name,
               fmt::format("{}", cell.capacity_Ah),
               fmt::format("{}", cell.cutoff_V),
               fmt::format("{}", cell.alpha_C()),
               cell.diffusion ? Significant(beta) : "none",
               Significant(cell.series_resistance_Ohm(1.0)),
               cell.open_circuit_voltage_assumed ? "assumed, a typical curve" : "measured"});
    rows.push_back(
        {{"name", name}, {"capacity_Ah", cell.capacity_Ah}, {"alpha_C", cell.alpha_C()}});
  }
  line.Print("{}", table.Text());
  return rows;
}

Json ListFormats(cli::CommandLine& line) {
  cli::TextTable table({{"format", Align::kLeft}, {"what it is", Align::kLeft}});
  Json rows = Json::array();
  for (const Layout* format : LogFormats()) {
    table.Row({std::string(format->name), std::string(format->summary)});
    rows.push_back({{"name", format->name}, {"summary", format->summary}});
  }
  line.Print("{}", table.Text());
  return rows;
}

Json ListOptimizers(cli::CommandLine& line) {
  cli::TextTable table(
      {{"optimizer", Align::kLeft}, {"library", Align::kLeft}, {"what it does", Align::kLeft}});
  Json rows = Json::array();
  std::string all_options;
  for (const auto& optimizer : Optimizers()) {
    table.Row({std::string(optimizer.name),
               std::string(optimizer.library),
               std::string(optimizer.summary)});
    Json options = Json::array();
    all_options += fmt::format("\nOptions of {}:\n", optimizer.name);
    for (const auto& option : optimizer.options()) {
      options.push_back({{"name", option.name},
                         {"default", option.default_text},
                         {"valid", option.valid},
                         {"help", option.help}});
      all_options += fmt::format("  {}: {}; {} (default {})\n",
                                 option.name,
                                 option.help,
                                 option.valid,
                                 option.default_text);
    }
    rows.push_back({{"name", optimizer.name},
                    {"library", optimizer.library},
                    {"summary", optimizer.summary},
                    {"options", std::move(options)}});
  }
  line.Print("{}{}", table.Text(), all_options);
  return rows;
}

Json ListProtocols(cli::CommandLine& line) {
  cli::TextTable table({{"protocol", Align::kLeft}, {"what the lab does", Align::kLeft}});
  Json rows = Json::array();
  for (const auto& protocol : kProtocols) {
    table.Row({std::string(protocol.name), std::string(protocol.summary)});
    rows.push_back({{"name", protocol.name}, {"summary", protocol.summary}});
  }
  line.Print("{}", table.Text());
  return rows;
}

struct Topic {
  std::string_view name;
  Json (*list)(cli::CommandLine&);
};
constexpr Topic kTopics[] = {
    {"cells", &ListCells},
    {"formats", &ListFormats},
    {"optimizers", &ListOptimizers},
    {"protocols", &ListProtocols},
};

}  // namespace

cli::ExitCode ListCommand(cli::CommandLine& line) {
  std::string what;
  std::vector<std::string> known;
  for (const auto& topic : kTopics) known.emplace_back(topic.name);
  line.Describe("Lists what lipoid knows by name.", "lipoid list cells");
  line.Argument("WHAT", what, "one of: " + fmt::format("{}", fmt::join(known, ", ")));
  if (!line.Parse()) return cli::ExitCode::kDone;
  for (const auto& topic : kTopics) {
    if (topic.name != what) continue;
    line.summary()[what] = topic.list(line);
    return cli::ExitCode::kDone;
  }
  throw OptionError(cli::UnknownName("list", what, known));
}

}  // namespace lipoid
