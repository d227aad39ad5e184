#include "tools/commands/log_options.h"

#include <fmt/format.h>

#include <atomic>
#include <cstddef>
#include <nlohmann/json.hpp>

#include "model/battery/ranges.h"
#include "model/core/errors.h"
#include "tools/cli/split.h"

namespace lipoid {

namespace {

// Of what commands do with logs that they read.
constexpr double kShareOfReading = 0.2;

}  // namespace

void LogOptions::AddTo(cli::CommandLine& line) {
  line.Texts("columns",
             columns,
             "KEY=NAME",
             "the header's names of time_s, current_A, voltage_V, temperature_degC, where they are "
             "not found; numbers from 1 for a table without a header");
  line.Text(
      "units", units, "s,A,V", "units of time, current and voltage where the header states none");
  line.Text("current-sign",
            current_sign,
            "SIGN",
            "discharge-positive or discharge-negative, where it cannot be found from the data");
  line.Option("hold",
              hold,
              Names(),
              "whether a row's current holds since the row before or until the next");
  line.Option(
      "battery",
      battery,
      Range{1, kMostBatteries},
      "which battery of a flight log, as the autopilot numbers it, where there are several");
  line.Option("most-rows",
              most_rows,
              Range{1024, 1e9},
              "rows of a log that are kept as they are; where nothing happens in a longer log one "
              "row then stands for several");
}

ReadOptions LogOptions::ToReadOptions() const {
  ReadOptions read;
  read.hold = hold;
  for (const auto& column : columns) {
    const auto equals = column.find('=');
    if (equals == std::string::npos) {
      throw OptionError(
          fmt::format("option --columns: expected KEY=NAME (time_s=Zeit), found '{}'", column));
    }
    read.columns[column.substr(0, equals)] = column.substr(equals + 1);
  }
  if (!units.empty()) {
    read.units = SplitAt(units, ',');
    if (read.units.size() != 3) {
      throw OptionError(fmt::format(
          "option --units: expected three, of time, current and voltage (s,A,V), found '{}'",
          units));
    }
  }
  if (!current_sign.empty() && current_sign != "auto" && current_sign != "discharge-positive" &&
      current_sign != "discharge-negative") {
    throw OptionError(
        fmt::format("option --current-sign: expected auto, discharge-positive or "
                    "discharge-negative, found '{}'",
                    current_sign));
  }
  read.current_sign = current_sign;
  read.battery = battery.value_or(0);
  read.most_rows = static_cast<std::size_t>(most_rows);
  return read;
}

void PackOptions::AddTo(cli::CommandLine& line, std::string_view of) {
  line.Option("series", series, kPackSizes, fmt::format("cells in series {}", of));
  line.Option("parallel", parallel, kPackSizes, fmt::format("cells in parallel {}", of));
}

void PackOptions::ApplyTo(int& series_of, int& parallel_of) const {
  if (series) series_of = *series;
  if (parallel) parallel_of = *parallel;
}

std::vector<std::string> LogFiles(const std::vector<Campaign>& campaigns) {
  std::vector<std::string> files;
  for (const Campaign& campaign : campaigns) {
    for (const CampaignLog& log : campaign.logs) files.push_back(log.path);
  }
  return files;
}

std::vector<LoadedLog> LoadLogs(cli::CommandLine& line,
                                const Campaign& campaign,
                                const std::function<double(double)>& share_of_bar) {
  // A bar that grows with all the logs: each counts alike.
  Campaign told = campaign;
  std::vector<std::atomic<double>> shares(told.logs.size());
  for (std::size_t k = 0; k < told.logs.size(); ++k) {
    told.logs[k].read.progress = [&, k](double share) {
      shares[k] = share;
      double sum = 0.0;
      for (const auto& each : shares) sum += each;
      const double all = kShareOfReading * sum / static_cast<double>(shares.size());
      line.progress().Update(share_of_bar ? share_of_bar(all) : all, "reading logs");
    };
  }
  std::vector<LoadedLog> logs = LoadCampaign(told);
  for (LoadedLog& log : logs) log.entry.read.progress = {};  // of this call alone
  for (const std::string& note : NotesOnLogs(logs)) line.Message("{}", note);
  return logs;
}

}  // namespace lipoid
