#pragma once

/// @file
/// Why a fit may be wrong although it predicts its own logs well: what stands in for a log that is not
/// there, what no log tests, a search that did not end, logs that contradict one another, a voltage that
/// is no cell's. Tests: tests/identify/fit_doubts_test.cc.

#include <string>
#include <vector>

#include "identify/identification.h"

namespace lipoid {

/// Each lowers the grade of found.quality to fair, or to poor.
void DoubtTheFit(Identification& found,
                 const Campaign& campaign,
                 const std::vector<LoadedLog>& logs,
                 const IdentifyOptions& options);

/// Nearly all of the resistance at half charge, which is not at once there but after a few rows; "" where it
/// is at once. `sampling_s` is the shortest usual step of the logs, 0 where it is not known.
[[nodiscard]] std::string DoubtAboutInstants(const Cell& cell, double sampling_s);

}  // namespace lipoid
