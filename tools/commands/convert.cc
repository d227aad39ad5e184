// lipoid convert LOG -o CSV: a log of any known format as plain CSV or Battery Data Format.
#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "identify/logs/all_rows.h"
#include "identify/logs/current_sign.h"
#include "identify/logs/inspection_report.h"
#include "identify/logs/log.h"
#include "identify/logs/log_writer.h"
#include "identify/logs/reading_request.h"
#include "identify/pack_request.h"
#include "model/core/counted.h"
#include "model/core/errors.h"
#include "tools/cli/split.h"
#include "tools/commands.h"

namespace lipoid {
namespace {

// Which part of the file to read.
struct Selection {
  std::vector<std::string> steps;
  std::vector<std::string> cycles;
  std::optional<double> start_s;
  std::optional<double> end_s;
  double lead_resistance_Ohm = 0.0;

  void AddTo(cli::CommandLine& line) {
    line.Texts("steps", steps, "N", "only rows of these steps of the cycler's program");
    line.Texts("cycles", cycles, "N", "only rows of these cycles");
    line.Option("start-s",
                start_s,
                Range{},
                "only rows from this time of the file on; time then restarts at 0");
    line.Option("end-s", end_s, Range{}, "only rows up to this time of the file");
    line.Option("lead-resistance-Ohm",
                lead_resistance_Ohm,
                Range{-1e3, 1e3},
                "resistance R of leads within the measured voltage: v + R i is written");
  }

  void ApplyTo(ReadOptions& read) const {
    read.steps = Numbers("steps", steps);
    read.cycles = Numbers("cycles", cycles);
    if (start_s) read.start_s = *start_s;
    if (end_s) read.end_s = *end_s;
    read.lead_resistance_Ohm = lead_resistance_Ohm;
  }

  static std::vector<int> Numbers(std::string_view option, const std::vector<std::string>& words) {
    std::vector<int> numbers;
    for (const auto& word : words) {
      for (const auto& piece : SplitAt(word, ',')) {
        numbers.push_back(
            options_internal::ParseInt(fmt::format("--{}", option), piece, Range{-1e9, 1e9}));
      }
    }
    return numbers;
  }
};

Json Describe(const std::string& file,
              const LogReport& report,
              double duration_s,
              const std::string& output,
              LogFileFormat format) {
  Json json = {{"file", file},
               {"format", report.format},
               {"output", output},
               {"output_format", options_internal::ToText(format)},
               {"rows", report.rows},
               {"duration_s", duration_s},
               {"current_sign", report.current_sign},
               {"current_sign_reason", report.current_sign_reason}};
  json.update(ReadingToJson(report));
  return json;
}

}  // namespace

cli::ExitCode ConvertCommand(cli::CommandLine& line) {
  std::string file;
  std::string output;
  std::optional<LogFileFormat> given_format;
  ReadingRequest reading;
  LoggedPackRequest pack;
  Selection selection;
  line.Describe(
      "Reads a log of any known format (`lipoid list formats`) and writes time, current and "
      "voltage in SI units. Plain CSV counts discharging as positive, Battery Data Format "
      "charging.",
      "lipoid convert cycler_export.txt -o discharge.csv");
  line.Example("lipoid convert cycler_export.txt --steps 7 -o discharge.bdf.csv");
  line.InputArgument("LOG", file, "the log to read");
  line.Output(output,
              "CSV",
              "the file to write; as Battery Data Format where its name ends in .bdf or .bdf.csv");
  line.Option("format", given_format, Names(), "format to write, whatever the name");
  line.Each(reading);
  line.Each(pack);
  selection.AddTo(line);
  if (!line.Parse()) return cli::ExitCode::kDone;

  ReadOptions read = reading.Resolve();
  selection.ApplyTo(read);
  const bool named_bdf = output.ends_with(".bdf") || output.ends_with(".bdf.csv");
  const LogFileFormat format =
      given_format.value_or(named_bdf ? LogFileFormat::kBdf : LogFileFormat::kCsv);
  read.progress = [&](double share) { line.progress().Update(share, "reading"); };
  Log log = ReadLog(file, read);
  read.progress = [&](double share) { line.progress().Update(share, "writing"); };
  // What the reader of this log knows, the reader of what is written has to know, too.
  const bool settled = log.record.voltage_V.empty() ||
                       FindSignFromPhysics(log.record).sign == CurrentSign::kDischargePositive;
  LogWriter writer(output, format, !settled);
  const Record& record = log.record;
  const double duration_s = record.time_s.back() - record.time_s.front();
  ForEachBlockOfRows(log, read, [&](Record& rows) {
    DivideByPack(rows, pack.series.value_or(1), pack.parallel.value_or(1));
    writer.Add(rows);
  });
  writer.Commit();

  line.summary()["files"] = Json::array({Describe(file, log.report, duration_s, output, format)});
  const std::string dropped = DroppedText(log.report);
  line.Message("{}: {}, {} kept{}{}; {} ({})",
               file,
               log.report.format,
               Counted(log.report.rows, "row"),
               dropped.empty() ? "" : ", but not ",
               dropped,
               log.report.current_sign,
               log.report.current_sign_reason);
  if (record.hold == Hold::kForward) {
    line.Message(
        "  rows are written as they are, and {} does not know their hold: say --hold forward "
        "wherever it is read",
        output);
  }
  for (const auto& warning : log.report.warnings) line.Message("  {}", warning);
  for (const auto& note : log.report.notes) line.Message("  {}", note);
  return cli::ExitCode::kDone;
}

}  // namespace lipoid
