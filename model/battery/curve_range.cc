#include "model/battery/curve_range.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/battery/cell.h"

namespace lipoid {

bool KnowsCurve(const Cell& cell, double lowest_soc, double highest_soc) {
  return DoubtAboutCurve(cell, lowest_soc, highest_soc).empty();
}

std::string DoubtAboutCurve(const Cell& cell, double lowest_soc, double highest_soc) {
  const OpenCircuitVoltage& curve = cell.open_circuit_voltage;
  const double low = std::clamp(lowest_soc, 0.0, 1.0);
  const double high = std::clamp(highest_soc, 0.0, 1.0);
  const bool below = low < curve.soc_lo() - kNearCurve_soc;
  const bool above = high > curve.soc_hi() + kNearCurve_soc;
  if (!below && !above) return "";
  const std::string where = below && above ? fmt::format("{:.3g} and at {:.3g}", low, high)
                                           : fmt::format("{:.3g}", below ? low : high);
  return fmt::format(
      "v_oc of {} is known between {:.3g} and {:.3g} of the charge: at {} it is its end slope drawn on, which no "
      "log has shown and no interval counts. Logs that go so far would tell",
      cell.name.empty() ? "the cell" : cell.name,
      curve.soc_lo(),
      curve.soc_hi(),
      where);
}

}  // namespace lipoid
