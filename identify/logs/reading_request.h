#pragma once

/// @file
/// What a person may say of how logs are read, declared once: the options of every command that reads
/// logs, and keywords of lipoid.read_log(). Tests: tests/tools/predict_test.cc,
/// tests/python/test_options.py.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "identify/logs/log.h"
#include "model/battery/ranges.h"
#include "model/core/option_kinds.h"
#include "model/core/options.h"

namespace lipoid {

struct ReadingRequest {
  std::map<std::string, std::string> columns = {};
  std::vector<std::string> units = {};
  std::string current_sign = {};
  Hold hold = Hold::kBackward;
  std::optional<int> battery = {};
  std::optional<int> most_rows = static_cast<int>(kMostRowsKept);  ///< none: every row

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("columns",
      self.columns,
      Word{"KEY=NAME"},
      "the header's names of time_s, current_A, voltage_V, temperature_degC, where they are not "
      "found; numbers from 1 for a table without a header");
    v("units",
      self.units,
      Word{"s,A,V"},
      "units of time, current and voltage where the header states none");
    VisitOfColumns(self, v);
    v("battery",
      self.battery,
      Range{1, kMostBatteries},
      "which battery of a flight log, as the autopilot numbers it, where there are several");
    v("most_rows",
      self.most_rows,
      Range{1024, 1e9},
      "rows of a log that are kept as they are; where nothing happens in a longer log one row then "
      "stands for several");
  }

  /// Of these what can be said of columns in memory, too.
  template <class Self, class Visitor>
  static void VisitOfColumns(Self& self, Visitor&& v) {
    v("current_sign",
      self.current_sign,
      Word{"SIGN"},
      "auto, discharge-positive or discharge-negative: which sign a discharge has, where it cannot "
      "be found from the data");
    v("hold",
      self.hold,
      Names(),
      "whether a row's current holds since the row before or until the next");
  }

  /// OptionError where it is not right.
  [[nodiscard]] ReadOptions Resolve() const;
};

}  // namespace lipoid
