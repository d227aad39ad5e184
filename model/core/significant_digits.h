#pragma once

/// @file
/// Numbers as a person writes them: few digits, and no rest of a binary fraction behind them.
/// Tests: tests/model/core/significant_digits_test.cc.

namespace lipoid {

/// The double nearest to x with so many significant digits, at least 1: 6 * 0.6 is 3.6, not
/// 3.5999999999999996. NaN and infinities stay what they are. No locale has a say in it.
[[nodiscard]] double RoundToDigits(double x, int digits);

}  // namespace lipoid
