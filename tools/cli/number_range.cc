#include "tools/cli/number_range.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "model/core/errors.h"
#include "model/core/options.h"
#include "tools/cli/split.h"

namespace lipoid {

std::vector<double> ReadRange(const std::string& option,
                              const std::string& text,
                              const Range& valid) {
  constexpr double kMost = 1e6;
  constexpr double kHit =
      1e-9;  // of a step: what misses a number by so little, by rounding, has hit it
  const auto fail = [&](std::string_view what) {
    throw OptionError(fmt::format(
        "option --{}: expected FIRST:STEP:LAST or one number, found '{}'{}", option, text, what));
  };
  const auto parts = SplitAt(text, ':');
  const auto number = [&](const std::string& part, const Range& range) {
    return options_internal::ParseShare("--" + option, part, range);
  };
  if (text.find(',') != text.npos)
    fail(": a comma neither separates numbers nor parts their digits here");
  if (parts.size() == 1) return {number(parts[0], valid)};
  if (parts.size() != 3) fail("");
  const double first = number(parts[0], valid);
  const double step = number(parts[1], Range{});
  const double last = number(parts[2], valid);
  const double count = (last - first) / step;
  if (step == 0.0) fail(": a step of 0 leads nowhere");
  if (!(count >= 0.0)) fail(": the step does not lead from the first to the last");
  if (count > kHit && count < 1.0 - kHit) fail(": the first step leads beyond the last");
  if (!(count < kMost)) fail(": more than a million numbers");
  std::vector<double> values;
  const auto steps = static_cast<long>(std::floor(count + kHit));
  for (long k = 0; k <= steps; ++k) {
    // 0.8 + 2 * 0.01 is 0.82 to its reader.
    const double value = std::round((first + double(k) * step) * 1e12) / 1e12;
    values.push_back(std::abs(double(k) - count) < kHit ? last : value);
  }
  return values;
}

}  // namespace lipoid
