#pragma once

/// @file
/// Rows whose voltage or current cannot be: a reading that failed, alone between two that did not.
/// Tests: tests/identify/logs/spikes_test.cc.

#include <cstddef>
#include <vector>

#include "identify/logs/record.h"

namespace lipoid {

/// Rows whose voltage leaves the range of all other rows by half that range and by 0.2 V at least,
/// while the rows beside them stay within it and the current does not change the other way, there and back; and runs of
/// at most five rows with less than a tenth of the usual voltage, whatever flows.
/// The first and the last row have a neighbour on one side only and are never among the former: a discharge
/// may well end on a cliff. Linear in the number of rows.
[[nodiscard]] std::vector<std::size_t> FindSpikes(const Record& record);

/// Rows whose current leaves the range of all other rows by half of it, while the rows beside them stay
/// within it and the voltage moves by less than a quarter of what other steps of the current make it move
/// (where there are none, by less than 5 mV under five times the largest current). Never the first or the
/// last row; none where they are more than five or carry all the load, and none of a record without voltages.
[[nodiscard]] std::vector<std::size_t> FindCurrentSpikes(const Record& record);

}  // namespace lipoid
