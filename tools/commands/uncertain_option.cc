#include "tools/commands/uncertain_option.h"

#include <string_view>

namespace lipoid {
namespace {

double ReadOne(const std::string& shown, std::string_view text, const Range& valid) {
  constexpr double kPercent = 0.01;
  if (!text.ends_with('%')) return options_internal::ParseDouble(shown, text, valid);
  text.remove_suffix(1);
  return kPercent * options_internal::ParseDouble(
                        shown, text, Range{valid.lo / kPercent, valid.hi / kPercent});
}

}  // namespace

Uncertain ReadUncertain(const std::string& option, const std::string& text, const Range& valid) {
  const std::string shown = "--" + option;
  for (const std::string_view sign : {"+-", "±"}) {
    const std::size_t at = text.find(sign);
    if (at == std::string::npos) continue;
    return {ReadOne(shown, std::string_view(text).substr(0, at), valid),
            ReadOne(shown + " (standard error)",
                    std::string_view(text).substr(at + sign.size()),
                    Range{.lo = 0.0})};
  }
  return {ReadOne(shown, text, valid), 0.0};
}

}  // namespace lipoid
