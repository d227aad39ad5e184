#pragma once

/// @file
/// Writes a record as plain CSV or as Battery Data Format, with the shortest digits that read back
/// to the same doubles. Both start at the record's own time; BDF counts charging as positive, plain
/// CSV discharging. Tests: tests/identify/logs/log_writer_test.cc.

#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "identify/logs/record.h"

namespace lipoid {

enum class LogFileFormat { kCsv, kBdf };

constexpr std::array<std::pair<LogFileFormat, std::string_view>, 2> OptionNames(LogFileFormat) {
  return {{{LogFileFormat::kCsv, "csv"}, {LogFileFormat::kBdf, "bdf"}}};
}

/// time_s,current_A,voltage_V[,temperature_degC], or Test Time / s,Voltage / V,Current / A[,...].
/// The file appears whole or not at all; OptionError where it cannot be written.
void WriteLog(const Record& record,
              const std::string& file,
              LogFileFormat format = LogFileFormat::kCsv);

}  // namespace lipoid
