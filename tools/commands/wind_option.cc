#include "tools/commands/wind_option.h"

#include <fmt/format.h>

#include <array>
#include <string_view>

#include "model/core/errors.h"

namespace lipoid {

void ReadWind(const std::string& option, const std::string& text, WindOptions& wind) {
  if (text.empty()) return;
  const std::array<double*, 3> components{
      &wind.wind_x_m_per_s, &wind.wind_y_m_per_s, &wind.wind_z_m_per_s};
  std::string_view rest = text;
  for (std::size_t k = 0;; ++k) {
    if (k == components.size()) {
      throw OptionError(fmt::format(
          "option --{}: expected one to three numbers X,Y,Z, found '{}'", option, text));
    }
    const auto comma = rest.find(',');
    *components[k] = options_internal::ParseDouble(
        "--" + option, rest.substr(0, comma), WindOptions::kSpeedRange);
    if (comma == std::string_view::npos) return;
    rest.remove_prefix(comma + 1);
  }
}

}  // namespace lipoid
