#pragma once

/// @file
/// What is in a log: how it was read, what it covers, which segments it has, which kind it looks
/// like. Tests: tests/identify/logs/inspection_test.cc.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "identify/logs/discharge.h"
#include "identify/logs/log.h"
#include "identify/logs/suggest.h"
#include "model/core/errors.h"

namespace lipoid {

/// Least, median and largest of something.
struct Spread {
  double least = 0.0;
  double median = 0.0;
  double largest = 0.0;
};

/// Of a log that was read; the rows themselves are not kept.
struct Inspection {
  std::string file;
  LogReport report;
  double duration_s = 0.0;
  Spread sampling_s;
  Spread current_A;
  Spread voltage_V;
  std::optional<Spread> temperature_degC;
  double charge_out_C = 0.0;  ///< by discharging
  double charge_in_C = 0.0;   ///< by charging, positive
  std::vector<Segment> segments;
  std::optional<Discharge> discharge;  ///< WholeDischarge()
  double edge_resistance_Ohm =
      0.0;  ///< voltage step over current at its switch-on; NaN where not seen
  Suggestion suggestion;
};

[[nodiscard]] Inspection InspectRecord(const Record& record, const LogReport& report);

/// Either an inspection or what is wrong with the file.
struct InspectedFile {
  std::string file;
  std::optional<Inspection> inspection;
  std::vector<Diagnostic> problems;
};

/// Reads files by ReadLogs(); the results are in the order of the files.
[[nodiscard]] std::vector<InspectedFile> InspectLogs(const std::vector<std::string>& files,
                                                     const ReadOptions& options);

}  // namespace lipoid
