#include "model/battery/temperature_range.h"

#include <fmt/format.h>

#include "model/battery/cell.h"

namespace lipoid {

std::string DoubtAboutTemperature(const Cell& cell, double coldest_degC, double warmest_degC) {
  if (!cell.temperature || !cell.temperature_seen) return "";
  const TemperatureRange& seen = *cell.temperature_seen;
  const bool cold = coldest_degC < seen.coldest_degC - kNearRange_K;
  const bool warm = warmest_degC > seen.warmest_degC + kNearRange_K;
  if (!cold && !warm) return "";
  const std::string where = cold && warm
                                ? fmt::format("{:.3g} and {:.3g} degC", coldest_degC, warmest_degC)
                                : fmt::format("{:.3g} degC", cold ? coldest_degC : warmest_degC);
  return fmt::format(
      "{} was identified from logs between {:.3g} and {:.3g} degC: at {} its resistances and diffusion are "
      "extrapolated, and no interval counts that",
      cell.name,
      seen.coldest_degC,
      seen.warmest_degC,
      where);
}

}  // namespace lipoid
