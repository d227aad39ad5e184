#include "tools/commands/uncertain_option.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "model/core/errors.h"
#include "model/core/options.h"

namespace lipoid {
namespace {

bool InPercent(std::string_view text) { return text.ends_with('%'); }

}  // namespace

Uncertain ReadUncertain(const EnduranceVariable& variable, const std::string& text) {
  const std::string shown = fmt::format("--{}", variable.name);
  const auto refuse = [&](const std::string& expected) {
    throw OptionError(fmt::format("option {}: expected {}, found '{}'", shown, expected, text));
  };
  std::string_view value = text;
  std::string_view error;
  for (const std::string_view sign : {"+-", "±"}) {
    const std::size_t at = text.find(sign);
    if (at == std::string::npos) continue;
    value = std::string_view(text).substr(0, at);
    error = std::string_view(text).substr(at + sign.size());
    if (error.empty()) refuse("a standard error behind the sign");
  }
  const PercentSign percent = variable.percent;
  const bool has_unit = percent == PercentSign::kNone || percent == PercentSign::kOfValue;
  if (has_unit && InPercent(value)) refuse("a number in the unit of the option, none in percent");
  if (percent == PercentSign::kNone && InPercent(error))
    refuse("a standard error in the unit of the option, none in percent");
  if (percent == PercentSign::kShare && InPercent(value) && !error.empty() && !InPercent(error))
    refuse("a standard error in percent beside a share in percent, such as 80%+-5%");
  const double is = options_internal::ParseShare(shown, value, variable.valid);
  if (error.empty()) return {is, 0.0};
  const double off =
      options_internal::ParseShare(shown + " (standard error)", error, Range{.lo = 0.0});
  return {is, InPercent(error) && percent != PercentSign::kShare ? off * std::abs(is) : off};
}

}  // namespace lipoid
