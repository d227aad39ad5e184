#pragma once

/// @file
/// Which way the current of a log counts: found, never assumed.
///
/// A cell has a resistance and a charge, so its voltage falls when more current leaves (edges of
/// the current), and falls while charge leaves. Both are weighed as log-likelihood ratios, which
/// add up: edges against the noise of current and voltage, falls by how many volts they go, where
/// the charge flows. Where the sum is not decisive, or too much stands against it, the answer is
/// "unclear". Tests: tests/identify/logs/current_sign_test.cc and current_sign_on_logs_test.cc.

#include <cstdint>
#include <string>
#include <vector>

#include "identify/logs/record.h"

namespace lipoid {

enum class CurrentSign { kUnclear, kDischargePositive, kDischargeNegative, kUnsigned };

struct SignFinding {
  CurrentSign sign = CurrentSign::kUnclear;
  std::string reason = "FindSign was not called";  ///< one sentence, without a full stop
  /// Of an unclear sign: the log speaks against either, as a current without a sign of its own
  /// does. Then no other log settles it.
  bool contradictory = false;
};

/// From the voltage alone. The record's currents count as in the file.
[[nodiscard]] SignFinding FindSignFromPhysics(const Record& record);

/// From the cycler's state column: +1 discharge, -1 charge, 0 neither, one entry per row; kUnclear
/// with a reason where it contradicts itself, or says nothing.
[[nodiscard]] SignFinding FindSignFromStates(const Record& record,
                                             const std::vector<std::int8_t>& directions);

/// Whether a current that never changes sign charges the cell as well as discharges it: under a steady
/// load the voltage rises by a fifth of its highest and under another it falls by as much.
[[nodiscard]] bool HasNoSign(const Record& record);

}  // namespace lipoid
