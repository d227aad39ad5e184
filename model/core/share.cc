#include "model/core/share.h"

namespace lipoid {

double ParseShare(std::string_view name, std::string_view text, const Range& range) {
  constexpr double kPercent = 0.01;
  if (!text.ends_with('%')) return options_internal::ParseDouble(name, text, range);
  text.remove_suffix(1);
  return kPercent *
         options_internal::ParseDouble(name, text, Range{range.lo / kPercent, range.hi / kPercent});
}

}  // namespace lipoid
