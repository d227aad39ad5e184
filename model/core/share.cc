#include "model/core/share.h"

#include <fmt/format.h>

#include "model/core/errors.h"

namespace lipoid {

double ParseShare(std::string_view name, std::string_view text, const Range& range) {
  constexpr double kPercent = 0.01;
  if (!text.ends_with('%')) return options_internal::ParseDouble(name, text, range);
  const double percent =
      options_internal::ParseDouble(name, text.substr(0, text.size() - 1), Range{});
  const double share = kPercent * percent;
  if (!range.Contains(share)) {
    throw OptionError(fmt::format("option {}: expected {:g}% .. {:g}%, found '{}'",
                                  name,
                                  range.lo / kPercent,
                                  range.hi / kPercent,
                                  text));
  }
  return share;
}

}  // namespace lipoid
