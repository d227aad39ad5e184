#pragma once

/// @file
/// Cuts a record into stretches of rest and of load.
///
/// The current of a segment keeps to one level, up to noise and the resolution of the instrument; a
/// level ends where the deviations from its mean add up beyond what noise can do (Page's two-sided
/// cumulative sum test), so that a large step ends it at once and a step within the noise after a
/// few rows. Rows that keep to no level (a taper at constant voltage, a drive cycle) make one
/// segment together; the few rows of a slow edge belong to the level they lead to.
///
///   rest              no current
///   pulse             a level next to a rest, short against the record and moving a part of
///                     its charge
///   constant-current  any other level that is held
///   varying           no level is held, or one step in a row of steps without rests
///
/// Linear in the number of rows. Tests: tests/identify/logs/segments_test.cc.

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

/// Rows [first, last] of the record, both included. The current of the segment flows from start_s
/// to end_s: with backward hold start_s is the stamp of the row before `first`.
struct Segment {
  SegmentKind kind = SegmentKind::kRest;
  std::size_t first = 0;
  std::size_t last = 0;
  double start_s = 0.0;
  double end_s = 0.0;
  double current_A = 0.0;  ///< charge divided by time; discharge positive
  double charge_C = 0.0;

  [[nodiscard]] double duration_s() const { return end_s - start_s; }
  [[nodiscard]] std::size_t rows() const { return last - first + 1; }
  friend bool operator==(const Segment&, const Segment&) = default;
};

/// Segments in order; together they cover every row once. Empty for an empty record.
[[nodiscard]] std::vector<Segment> FindSegments(const Record& record);

/// The current below which a row is at rest: a small share of the record's largest current, above
/// the noise of its zero.
[[nodiscard]] double RestThreshold(const Record& record);

}  // namespace lipoid
