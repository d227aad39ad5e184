// lipoid study WHAT CAMPAIGN: one stage done in several ways, as a table.
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "identify/logs/campaign.h"
#include "identify/stages/staged_request.h"
#include "identify/studies/studies.h"
#include "model/core/atomic_file.h"
#include "model/core/errors.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"
#include "tools/commands/campaign_options.h"
#include "tools/commands/log_options.h"
#include "tools/commands/staged_options.h"

namespace lipoid {
namespace {

std::string JoinedWords(const Json& array) {
  return fmt::format("{}", fmt::join(array.get<std::vector<std::string>>(), " "));
}

// A cell for people: numbers rounded, a dash for nothing.
std::string Shown(const Json& value, const StudyColumn& column) {
  if (value.is_number_float()) {
    const double number = value.get<double>() * column.scale;
    return number == 0.0 ? "0" : cli::Significant(number, column.digits);
  }
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_array()) return value.empty() ? "-" : JoinedWords(value);
  if (value.is_string()) return value.get<std::string>();
  return value.is_null() ? "-" : value.dump();
}

cli::TextTable TableOf(const StudyResult& result, std::string caption) {
  std::vector<cli::TextTable::Column> columns;
  for (const StudyColumn& column : result.columns) {
    const Json& first = result.rows.at(0).at(std::string(column.key));
    const bool words = first.is_string() || first.is_array() || first.is_boolean();
    columns.push_back({std::string(column.header), words ? cli::Align::kLeft : cli::Align::kRight});
  }
  cli::TextTable table(std::move(columns), std::move(caption));
  for (const Json& row : result.rows) {
    std::vector<std::string> cells;
    for (const StudyColumn& column : result.columns)
      cells.push_back(Shown(row.at(std::string(column.key)), column));
    table.Row(std::move(cells));
  }
  return table;
}

// A cell for programs: all digits; words that hold a comma are quoted.
std::string CsvCell(const Json& value) {
  if (value.is_null()) return "";
  if (!value.is_string() && !value.is_array()) return value.dump();
  const std::string text = value.is_array() ? JoinedWords(value) : value.get<std::string>();
  return text.find(',') == std::string::npos ? text : fmt::format("\"{}\"", text);
}

std::string CsvText(const StudyResult& result) {
  std::string text;
  const auto line = [&](auto&& cell) {
    for (std::size_t k = 0; k < result.columns.size(); ++k)
      text += (k > 0 ? "," : "") + cell(result.columns[k]);
    text += "\n";
  };
  line([](const StudyColumn& column) { return std::string(column.key); });
  for (const Json& row : result.rows)
    line([&](const StudyColumn& column) { return CsvCell(row.at(std::string(column.key))); });
  return text;
}

}  // namespace

cli::ExitCode StudyCommand(cli::CommandLine& line) {
  std::string what;
  std::vector<std::string> files;
  CampaignOptions campaign_options;
  std::string csv;
  StagedRequest request;
  std::string known;
  for (const Study& study : kStudies)
    known += fmt::format("{}{}: {}", known.empty() ? "" : "; ", study.name, study.summary);
  line.Describe("Does one stage of the identification in several ways and compares.",
                "lipoid study branches campaign.toml");
  line.Example("lipoid study ocv campaign.toml --csv forms.csv");
  line.Argument("WHAT", what, known);
  line.InputArguments(
      "CAMPAIGN", files, "a campaign file (TOML); none where logs are given by options", 0);
  line.OutputOption("csv", csv, "FILE", "write the table as CSV, with all digits");
  line.Each(request);
  campaign_options.AddTo(line);
  request.EachGroup([&](std::string_view name, auto& group) { line.Group(name, group); });
  line.Group("solver", request.options.solver);
  line.ReportOption();
  if (!line.Parse()) return cli::ExitCode::kDone;

  CheckSaidOnce(line, request);
  const Study& study = FindStudy(what);
  request.Resolve();
  const auto campaigns =
      campaign_options.Campaigns(line, files, request.given.open_circuit_voltage);
  if (campaigns.size() > 1) throw OptionError("one campaign at a time");
  const Campaign& campaign = campaigns[0];
  line.progress().Update(0.0, "reading logs");
  const auto logs = LoadLogs(line, campaign);
  if (const auto doubt = DoubtAboutOneTemperature(logs); !doubt.empty()) line.Message("{}", doubt);
  const StudyInput input{campaign, logs, request.options, request.given};
  const StudyResult result = study.run(input, [&](std::string_view doing, double share) {
    line.progress().Update(0.1 + 0.9 * share, doing);
  });

  line.summary()["study"] = study.name;
  line.summary().update(result.facts);
  line.summary()["rows"] = result.rows;
  if (!csv.empty()) WriteFileAtomically(csv, CsvText(result));
  line.Print("{}", TableOf(result, std::string(study.summary)).Text());
  line.summary()["messages"] = line.messages();
  line.summary()["remarks"] = result.remarks;
  for (const auto& remark : result.remarks) line.Message("{}", remark);
  const bool converged = result.facts.value("converged", true);
  return converged ? cli::ExitCode::kDone : cli::ExitCode::kIncomplete;
}

}  // namespace lipoid
