#pragma once

/// @file
/// Writes a record as plain CSV or as Battery Data Format, with the shortest digits that read back
/// to the same doubles. Both start at the record's own time; BDF counts charging as positive, plain
/// CSV discharging. Tests: tests/identify/logs/log_writer_test.cc.

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "identify/logs/record.h"
#include "model/core/csv_writer.h"

namespace lipoid {

enum class LogFileFormat { kCsv, kBdf };

constexpr std::array<std::pair<LogFileFormat, std::string_view>, 2> OptionNames(LogFileFormat) {
  return {{{LogFileFormat::kCsv, "csv"}, {LogFileFormat::kBdf, "bdf"}}};
}

/// Rows that come in blocks, each with the same columns. The file appears with Commit().
class LogWriter {
 public:
  /// With `states` a column says of each row whether it discharges, charges or rests: what readers know
  /// the sign of the current by, where its voltage does not settle it.
  LogWriter(std::string file, LogFileFormat format, bool states = false)
      : file_(std::move(file)), format_(format), states_(states) {}

  void Add(const Record& rows);
  /// OptionError where the file cannot be written.
  void Commit();

 private:
  std::string file_;
  LogFileFormat format_;
  bool states_ = false;
  bool has_temperature_ = false;
  std::optional<CsvWriter> csv_;  // from the first block on
};

/// time_s,current_A,voltage_V[,temperature_degC], or Test Time / s,Voltage / V,Current / A[,...].
/// The file appears whole or not at all; OptionError where it cannot be written.
void WriteLog(const Record& record,
              const std::string& file,
              LogFileFormat format = LogFileFormat::kCsv);

}  // namespace lipoid
