#pragma once

/// @file
/// A share as a person writes it: 0.2 or 20%. Tests: tests/tools/endurance_test.cc,
/// tests/python/test_endurance.py.

#include <string_view>

#include "model/core/options.h"

namespace lipoid {

/// The number of a text, in percent where it ends in a percent sign. OptionError names the option,
/// what is wrong and the valid range.
[[nodiscard]] double ParseShare(std::string_view name, std::string_view text, const Range& range);

}  // namespace lipoid
