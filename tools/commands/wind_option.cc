#include "tools/commands/wind_option.h"

#include <fmt/format.h>

#include <array>

#include "model/core/errors.h"
#include "tools/cli/split.h"

namespace lipoid {

void ReadWind(const std::string& option, const std::string& text, WindOptions& wind) {
  if (text.empty()) return;
  const std::array<double*, 3> components{
      &wind.wind_x_m_per_s, &wind.wind_y_m_per_s, &wind.wind_z_m_per_s};
  const auto pieces = SplitAt(text, ',');
  if (pieces.size() > components.size()) {
    throw OptionError(
        fmt::format("option --{}: expected one to three numbers X,Y,Z, found '{}'", option, text));
  }
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    *components[k] =
        options_internal::ParseDouble("--" + option, pieces[k], WindOptions::kSpeedRange);
  }
}

}  // namespace lipoid
