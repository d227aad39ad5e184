#include "tools/commands/uncertain_option.h"

#include <string_view>

#include "model/core/share.h"

namespace lipoid {

Uncertain ReadUncertain(const std::string& option, const std::string& text, const Range& valid) {
  const std::string shown = "--" + option;
  for (const std::string_view sign : {"+-", "±"}) {
    const std::size_t at = text.find(sign);
    if (at == std::string::npos) continue;
    return {ParseShare(shown, std::string_view(text).substr(0, at), valid),
            ParseShare(shown + " (standard error)",
                       std::string_view(text).substr(at + sign.size()),
                       Range{.lo = 0.0})};
  }
  return {ParseShare(shown, text, valid), 0.0};
}

}  // namespace lipoid
