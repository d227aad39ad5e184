#pragma once

/// @file
/// Which kind of log a record looks like.
///
///   low-rate           one constant discharge, no faster than kMaxLowRate_per_h
///   constant-current   one constant discharge, faster
///   pulses             loads of which at least one is a pulse followed by a rest
///   validation         any other load
///
/// A record of rest or charging alone is none of these. Tests: tests/identify/logs/suggest_test.cc.

#include <optional>
#include <string>
#include <vector>

#include "identify/logs/campaign.h"
#include "identify/logs/discharge.h"

namespace lipoid {

struct Suggestion {
  std::optional<LogKind> kind;
  std::string reason;  ///< one sentence without a full stop
};

/// `discharge` is that of WholeDischarge(), `segments` those of FindSegments(). The rate is that of the
/// discharge's own charge.
[[nodiscard]] Suggestion SuggestKind(const std::vector<Segment>& segments,
                                     const std::optional<Discharge>& discharge);

}  // namespace lipoid
