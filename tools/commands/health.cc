// lipoid health --cell REFERENCE FLIGHT...: how old a pack is, by flights on it.
#include "identify/health/health.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "identify/health/health_report.h"
#include "identify/logs/read_logs.h"
#include "identify/logs/reading_request.h"
#include "identify/pack_request.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"
#include "tools/commands/loaded_cell.h"

namespace lipoid {
namespace {

// The flights in the order they were named.
std::vector<Log> ReadFlights(const std::vector<std::string>& files, const ReadOptions& read) {
  std::set<std::filesystem::path> named;
  for (const std::string& file : files) {
    if (!named.insert(std::filesystem::path(file).lexically_normal()).second)
      throw OptionError(fmt::format("'{}' is given twice; name each log once", file));
  }
  std::vector<LogToRead> to_read;
  for (const std::string& file : files) to_read.push_back({file, read});
  std::vector<Log> logs(files.size());
  const auto problems =
      ReadLogs(to_read, [&](std::size_t k, Log log) { logs[k] = std::move(log); });
  std::vector<Diagnostic> all;
  for (const auto& of_one : problems) all.insert(all.end(), of_one.begin(), of_one.end());
  if (!all.empty()) throw LoadError(all);
  return logs;
}

std::string Interval(const WithInterval& value, double factor) {
  if (!value.known()) return "-";
  return fmt::format("{} .. {}",
                     cli::Significant(factor * value.low, 3),
                     cli::Significant(factor * value.high, 3));
}

std::string Value(const WithInterval& value, double factor) {
  return value.known() ? cli::Significant(factor * value.value, 3) : "-";
}

}  // namespace

cli::ExitCode HealthCommand(cli::CommandLine& line) {
  std::string cell_name;
  std::vector<std::string> files;
  HealthOptions options;
  ReadingRequest reading;
  LoggedPackRequest pack;
  line.Describe(
      "Says how old a battery pack is from logs of flights on it: its capacity and its resistance "
      "now, and its state of charge at start and end, each with a 95 % interval, per flight and as "
      "a trend over flights. The reference is the cell when it was new: a cell file of the lab, or "
      "a shipped cell, whose curve is typical of its chemistry.",
      "lipoid health --cell gifi-600mAh-1 --capacity-Ah 1.5 --series 4 flight_*.bin");
  line.InputArguments("FLIGHT", files, "logs of flights on one pack, the oldest first");
  line.RequiredInput(
      "cell", cell_name, "REFERENCE", "the cell when new: a cell file, or a shipped cell's name");
  line.Each(options);
  line.Each(reading);
  line.Each(pack);
  line.ReportOption();
  if (!line.Parse()) return cli::ExitCode::kDone;

  const Cell cell = LoadCell(line, cell_name);
  std::vector<Log> logs = ReadFlights(files, reading.Resolve());
  options.series = SeriesOfPack(logs, pack.series);
  options.parallel = pack.parallel.value_or(1);
  for (const Log& log : logs) {
    for (const std::string& warning : log.report.warnings)
      line.Message("{}: {}", log.record.file, warning);
  }
  const HealthReport report = AssessHealth(cell, std::move(logs), options);
  line.summary() = HealthToJson(report);
  line.summary()["messages"] = line.messages();
  for (const std::string& first : FirstLines(report)) line.Print("{}\n", first);
  if (report.typical && std::isfinite(report.new_capacity_Ah)) {
    line.Print(
        "{}",
        cli::Wrapped(fmt::format(
            "The reference {} is a typical curve, not this pack: 'of new' means of the {:.3g} "
            "Ah that {}.\n",
            report.reference,
            report.new_capacity_Ah,
            report.capacity_told ? "the autopilot was told" : "were given")));
  } else if (report.typical) {
    line.Print("{}",
               cli::Wrapped(fmt::format("The reference {} is a typical curve, not this pack, and "
                                        "nobody says how large the pack was when new: give "
                                        "--capacity-Ah for narrower intervals.\n",
                                        report.reference)));
  }
  if (const std::string temperature = TemperatureSentence(report); !temperature.empty())
    line.Print("{}", cli::Wrapped(temperature + "\n"));
  cli::TextTable table({{"flight", cli::Align::kFile},
                        {"SOC from"},
                        {"95 %"},
                        {"to"},
                        {"95 %"},
                        {"capacity / Ah"},
                        {"95 %"},
                        {"resistance / mOhm"},
                        {"95 %"},
                        {"mean error / %"}},
                       "The pack in each flight, with intervals of 95 %.");
  for (const FlightHealth& flight : report.flights) {
    table.Row({flight.file,
               Value(flight.soc_start, 1.0),
               Interval(flight.soc_start, 1.0),
               Value(flight.soc_end, 1.0),
               Interval(flight.soc_end, 1.0),
               Value(flight.capacity_Ah, 1.0),
               Interval(flight.capacity_Ah, 1.0),
               Value(flight.resistance_Ohm, 1e3),
               Interval(flight.resistance_Ohm, 1e3),
               cli::Significant(flight.mean_error_percent, 2)});
  }
  line.Print("\n{}{}", table.Text(), cli::Bullets("Refused", FilesWithReasons(report.refused)));
  for (const FlightHealth& flight : report.flights) {
    std::vector<std::string> cautions = flight.cautions;
    if (std::string doubt = DoubtAbout(flight); !doubt.empty())
      cautions.insert(cautions.begin(), std::move(doubt));
    line.Print("{}", cli::Bullets(flight.file, cautions));
  }
  return IsDoubted(report) ? cli::ExitCode::kIncomplete : cli::ExitCode::kDone;
}

}  // namespace lipoid
