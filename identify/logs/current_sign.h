#pragma once

/// @file
/// Which way the current of a log counts: found, never assumed.
///
/// A cell has a resistance and a charge, so its voltage falls when more current leaves (edges of
/// the current), and falls while charge leaves (stretches of load). Both are looked at; where they
/// disagree with each other, or with themselves, or say too little against the noise, the answer is
/// "unclear". Tests: tests/identify/logs/current_sign_test.cc.

#include <cstdint>
#include <string>
#include <vector>

#include "identify/logs/record.h"

namespace lipoid {

enum class CurrentSign { kUnclear, kDischargePositive, kDischargeNegative, kUnsigned };

struct SignFinding {
  CurrentSign sign = CurrentSign::kUnclear;
  std::string reason = "FindSign was not called";  ///< one sentence, without a full stop
};

/// From the voltage alone. The record's currents count as in the file.
[[nodiscard]] SignFinding FindSignFromPhysics(const Record& record);

/// From the cycler's state column: +1 discharge, -1 charge, 0 neither, one entry per row; kUnclear
/// with a reason where it contradicts itself, or says nothing.
[[nodiscard]] SignFinding FindSignFromStates(const Record& record,
                                             const std::vector<std::int8_t>& directions);

}  // namespace lipoid
