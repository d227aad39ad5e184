#pragma once

/// @file
/// Whether two logs hold the same rows, as a log and its copy under another name do. Tests:
/// tests/tools/health_test.cc.

#include "identify/logs/record.h"

namespace lipoid {

[[nodiscard]] inline bool HoldTheSameRows(const Record& one, const Record& other) {
  return one.size() == other.size() && one.time_s == other.time_s &&
         one.voltage_V == other.voltage_V && one.current_A == other.current_A;
}

}  // namespace lipoid
