#pragma once

/// @file
/// Cuts a record into stretches of rest and of load.
///
/// A segment is a run of rows whose current stays within a tolerance of one level. A constant-current
/// segment that ends in rest, or in another level, after a time short against the record is a pulse.
/// Tests: tests/identify/logs/segments_test.cc.

#include <array>
#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>

#include "identify/logs/record.h"

namespace lipoid {

enum class SegmentKind { kRest, kConstantCurrent, kPulse, kVarying };

constexpr std::array<std::pair<SegmentKind, std::string_view>, 4> OptionNames(SegmentKind) {
  return {{{SegmentKind::kRest, "rest"},
           {SegmentKind::kConstantCurrent, "constant-current"},
           {SegmentKind::kPulse, "pulse"},
           {SegmentKind::kVarying, "varying"}}};
}

/// Rows [first, last] of the record, both included. The current of the segment flows from start_s to end_s:
/// with backward hold start_s is the stamp of the row before `first`.
struct Segment {
  SegmentKind kind = SegmentKind::kRest;
  std::size_t first = 0;
  std::size_t last = 0;
  double start_s = 0.0;
  double end_s = 0.0;
  double current_A = 0.0;  ///< charge divided by time; discharge positive
  double charge_C = 0.0;

  [[nodiscard]] double duration_s() const { return end_s - start_s; }
};

/// Segments in order; together they cover every row once. Empty for an empty record.
[[nodiscard]] std::vector<Segment> FindSegments(const Record& record);

/// The current below which a row is at rest: a small share of the record's largest currents, above the
/// noise of its zero.
[[nodiscard]] double RestThreshold(const Record& record);

}  // namespace lipoid
