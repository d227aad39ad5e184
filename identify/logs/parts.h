#pragma once

/// @file
/// The tests within one record. Cyclers write a whole program into one file: charge, rest, discharge,
/// rest, charge again. Tests: tests/identify/logs/parts_test.cc.

#include <cstddef>
#include <vector>

#include "identify/logs/log.h"
#include "identify/logs/segments.h"

namespace lipoid {

/// Rows first .. last of a record, both included.
struct LogPart {
  std::size_t first = 0;
  std::size_t last = 0;
  bool after_gap = false;  ///< what flowed before it is not known
};

/// The parts of a record between recharges, and between gaps of unknown charge. A recharge puts back
/// a third of the charge that the record moves at least, so that a drive cycle with regeneration
/// and a random walk stay whole. Parts that take no charge out are left out. Empty where the record
/// is one test. `segments` are those of FindSegments(), `gaps` those of FindGaps().
[[nodiscard]] std::vector<LogPart> FindParts(const Record& record,
                                             const std::vector<Segment>& segments,
                                             const std::vector<Gap>& gaps);

/// These rows alone; time restarts at 0, as it does where ReadLog() is given start_s.
[[nodiscard]] Record RowsOf(const Record& record, const LogPart& part);

}  // namespace lipoid
