#pragma once

/// @file
/// How long a cell lasts at a constant current by its terminal voltage: everything that drops is in
/// it, unlike in the times of discharge_time.h, which know the diffusion alone.
/// Tests: tests/model/battery/time_to_cutoff_test.cc.

#include <optional>

#include "model/battery/prediction.h"

namespace lipoid {

/// When the terminal voltage first reaches the cut-off while current_A > 0, of the whole pack,
/// flows from a relaxed start among these surroundings, of which it takes no measured temperature: 0 where it is there at once, none where it is not within longest_s.
///
/// The states of the model are exact, the root is found to rounding. Where a branch has a table of
/// resistances, its r_j(A) is held over 1/30000 of longest_s.
[[nodiscard]] std::optional<double> TimeToCutoff(const Cell& cell,
                                                 double current_A,
                                                 double initial_soc,
                                                 double longest_s,
                                                 const Surroundings& surroundings = {});

}  // namespace lipoid
