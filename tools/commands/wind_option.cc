#include "tools/commands/wind_option.h"

#include <fmt/format.h>

#include <array>
#include <string_view>

#include "model/core/errors.h"

namespace lipoid {

void ReadWind(const std::string& option, const std::string& text, WindOptions& wind) {
  if (text.empty()) return;
  constexpr std::array<std::string_view, 3> kNames{
      "wind_x_m_per_s", "wind_y_m_per_s", "wind_z_m_per_s"};
  std::string_view rest = text;
  for (std::size_t k = 0;; ++k) {
    if (k == kNames.size()) {
      throw OptionError(fmt::format(
          "option --{}: expected one to three numbers X,Y,Z, found '{}'", option, text));
    }
    const auto comma = rest.find(',');
    SetOption(wind, kNames[k], rest.substr(0, comma));
    if (comma == std::string_view::npos) return;
    rest.remove_prefix(comma + 1);
  }
}

}  // namespace lipoid
