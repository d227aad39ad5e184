#include "tools/commands/wind_option.h"

#include <fmt/format.h>

#include <array>

#include "model/core/errors.h"
#include "tools/cli/split.h"

namespace lipoid {

void WindOption::AddTo(cli::CommandLine& line, WindOptions& wind, const std::string& directions) {
  line.Text("wind",
            text,
            "X[,Y[,Z]]",
            fmt::format("velocity of the air {}, m/s; {:g} .. {:g}",
                        directions,
                        WindOptions::kSpeedRange.lo,
                        WindOptions::kSpeedRange.hi));
  line.Option(
      "gusts",
      wind.gusts_m_per_s,
      Range{0.0, 60.0},
      "Dryden gusts, given by the wind speed at 20 ft in m/s: 7.7 light, 15.4 moderate, 23.2 severe");
}

void WindOption::ReadInto(WindOptions& wind) const {
  if (text.empty()) return;
  const std::array<double*, 3> components{
      &wind.wind_x_m_per_s, &wind.wind_y_m_per_s, &wind.wind_z_m_per_s};
  const auto pieces = SplitAt(text, ',');
  if (pieces.size() > components.size()) {
    throw OptionError(
        fmt::format("option --wind: expected one to three numbers X,Y,Z, found '{}'", text));
  }
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    *components[k] = options_internal::ParseDouble("--wind", pieces[k], WindOptions::kSpeedRange);
  }
}

}  // namespace lipoid
