#pragma once

/// @file
/// Multiples of a decimal number, each the double nearest to its decimal: 7 times 0.01 is the
/// double that prints as 0.07, which 7 * 0.01 is not. Tests:
/// tests/identify/synthesis/synthesize_test.cc.

#include <cmath>
#include <cstdint>
#include <optional>

namespace lipoid {

class DecimalStep {
 public:
  /// None where the step is not positive or has more than nine decimals.
  static std::optional<DecimalStep> Of(double step) {
    double scale = 1.0;
    for (int decimals = 0; decimals <= 9; ++decimals, scale *= 10.0) {
      const double numerator = std::round(step * scale);
      if (numerator >= 1.0 && numerator < 1e9 && numerator / scale == step) {
        return DecimalStep(numerator, scale);
      }
    }
    return std::nullopt;
  }

  /// count times the step; exact products and one rounding while |count| < 2^53 / 10^9 *
  /// 10^decimals.
  [[nodiscard]] double Times(std::int64_t count) const {
    return static_cast<double>(count) * numerator_ / scale_;
  }
  /// The multiple nearest to x.
  [[nodiscard]] std::int64_t Count(double x) const { return std::llround(x * scale_ / numerator_); }

 private:
  DecimalStep(double numerator, double scale) : numerator_(numerator), scale_(scale) {}
  double numerator_;  // the step is numerator_/scale_, a whole number over a power of ten
  double scale_;
};

}  // namespace lipoid
