#pragma once

/// @file
/// What is in a log: how it was read, what it covers, which segments it has, which kind it looks
/// like.
///
///   low-rate           one constant discharge, no faster than kMaxLowRate_per_h
///   constant-current   one constant discharge, faster
///   pulses             loads of which at least one is a pulse followed by a rest
///   validation         any other load
///
/// A record of rest or charging alone is none of these. Tests:
/// tests/identify/logs/inspection_test.cc.

#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "identify/logs/campaign.h"
#include "identify/logs/discharge.h"
#include "identify/logs/log.h"
#include "identify/logs/parts.h"
#include "model/core/errors.h"

namespace lipoid {

/// Least, median and largest of something.
struct Spread {
  double least = 0.0;
  double median = 0.0;
  double largest = 0.0;
};

struct Suggestion {
  std::optional<LogKind> kind;
  std::string reason;  ///< one sentence without a full stop
};

/// `discharge` is that of WholeDischarge(), `segments` those of FindSegments(). The rate is that of the
/// discharge's own charge.
[[nodiscard]] Suggestion SuggestKind(const std::vector<Segment>& segments,
                                     const std::optional<Discharge>& discharge);

/// Of a log that was read; the rows themselves are not kept.
struct Inspection {
  std::string file;
  LogReport report;
  double duration_s = 0.0;
  Spread sampling_s;
  Spread current_A;
  std::optional<Spread> voltage_V;  ///< none: the log is a current alone
  std::optional<Spread> temperature_degC;
  double charge_out_C = 0.0;  ///< by discharging
  double charge_in_C = 0.0;   ///< by charging, positive
  std::vector<Segment> segments;
  std::optional<Discharge> discharge;  ///< WholeDischarge()
  /// The voltage before the first load, of a log that begins with a rest; else NaN.
  double start_voltage_V = std::numeric_limits<double>::quiet_NaN();
  /// Of `discharge`: the share of its charge that is still to come, from 1 to 0, and the voltage.
  std::vector<std::pair<double, double>> discharge_curve;
  double edge_resistance_Ohm =
      0.0;  ///< voltage step over current at its switch-on; NaN where not seen
  Suggestion suggestion;
  std::optional<LogPart> part;  ///< which rows of the file this is about; none: all
  double part_start_s = 0.0;    ///< in the time of the file
  double part_end_s = 0.0;
  std::vector<Inspection> parts;  ///< the tests within, where there are several (FindParts)
};

/// How many lithium cells in series its voltage is that of, or as its autopilot was told.
[[nodiscard]] int CellsInSeries(const Inspection& log);

[[nodiscard]] Inspection InspectRecord(const Record& record, const LogReport& report);

/// Either an inspection or what is wrong with the file.
struct InspectedFile {
  std::string file;
  std::optional<Inspection> inspection;
  std::vector<Diagnostic> problems;
  bool no_log = false;  ///< not one that cannot be read, but no log at all
};

/// Called with the number of a file and its rows, which are not kept; several at once.
using SeenRecord = std::function<void(std::size_t file, const Record& record)>;

/// Reads files by ReadLogs(); the results are in the order of the files.
[[nodiscard]] std::vector<InspectedFile> InspectLogs(const std::vector<std::string>& files,
                                                     const ReadOptions& options,
                                                     const SeenRecord& seen = {});

}  // namespace lipoid
