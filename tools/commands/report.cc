// lipoid report SUMMARY...: results that are there already as one page.
#include "tools/report/report.h"

#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "model/core/atomic_file.h"
#include "model/core/errors.h"
#include "tools/commands.h"
#include "tools/commands/replay.h"
#include "tools/report/summary_schema.h"

namespace lipoid {

cli::ExitCode ReportCommand(cli::CommandLine& line) {
  std::vector<std::string> files;
  std::string output;
  line.Describe(
      fmt::format(
          "Writes results that are there already as one page with plots, to be opened in a browser: "
          "the files that --summary wrote, of {}. A summary holds no samples. Where its charts need "
          "some, they are made again from the files that the command had read, if each is still in "
          "its place with the same SHA-256; otherwise the page says which is not. Relative paths are those "
          "of the folder in which it runs: run it where the command ran.",
          fmt::join(CommandsWithReport(), ", ")),
      "lipoid report fit.json flight.json -o results.html");
  line.InputArguments("SUMMARY", files, "files that --summary wrote");
  line.Output(output, "HTML", "the page to write");
  if (!line.Parse()) return cli::ExitCode::kDone;
  RequireReport();

  // The logs and cells of the results are read again, and are no place for the page; nor is what the command wrote.
  std::vector<Json> summaries;
  for (const std::string& file : files) {
    const Json& summary = summaries.emplace_back(ReadSummary(file));
    if (!summary.contains("run")) continue;
    std::vector<std::string> read_again;
    for (const Json& input : summary["run"].at("inputs"))
      read_again.push_back(input.at("file").get<std::string>());
    const Json& words = summary["run"].at("arguments");
    for (std::size_t k = 1; k < words.size(); ++k) {
      const auto& word = words[k - 1].get_ref<const std::string&>();
      if (word == "-o" || word == "--output") read_again.push_back(words[k].get<std::string>());
    }
    line.AddInputs(read_again);
  }
  std::vector<ReportResult> results;
  Json shown = Json::array();
  for (std::size_t k = 0; k < files.size(); ++k) {
    line.progress().Update(static_cast<double>(k) / static_cast<double>(files.size()), files[k]);
    ReportResult result = Replayed(std::move(summaries[k]), kCommands);
    result.file = files[k];
    for (const std::string& note : result.notes) line.Message("{}: {}", files[k], note);
    shown.push_back({{"file", files[k]},
                     {"command", result.summary.at("command")},
                     {"series", result.series.size()},
                     {"notes", result.notes}});
    results.push_back(std::move(result));
  }
  WriteFileAtomically(output, ReportPage(results));
  line.summary()["file"] = output;
  line.summary()["results"] = std::move(shown);
  return cli::ExitCode::kDone;
}

}  // namespace lipoid
