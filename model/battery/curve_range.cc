#include "model/battery/curve_range.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/battery/cell.h"

namespace lipoid {
namespace {

// Below 0 and above 1 nothing is asked.
struct Ends {
  double low;
  double high;
  bool below;
  bool above;
};

Ends EndsOf(const Cell& cell, double lowest_soc, double highest_soc) {
  const OpenCircuitVoltage& curve = cell.open_circuit_voltage;
  Ends ends{};
  ends.low = std::clamp(lowest_soc, 0.0, 1.0);
  ends.high = std::clamp(highest_soc, 0.0, 1.0);
  ends.below = ends.low < curve.soc_lo() - kNearCurve_soc;
  ends.above = ends.high > curve.soc_hi() + kNearCurve_soc;
  return ends;
}

}  // namespace

bool KnowsCurve(const Cell& cell, double lowest_soc, double highest_soc) {
  const Ends ends = EndsOf(cell, lowest_soc, highest_soc);
  return !ends.below && !ends.above;
}

std::string DoubtAboutCurve(const Cell& cell, double lowest_soc, double highest_soc) {
  const Ends ends = EndsOf(cell, lowest_soc, highest_soc);
  if (!ends.below && !ends.above) return "";
  const OpenCircuitVoltage& curve = cell.open_circuit_voltage;
  const std::string where = ends.below && ends.above
                                ? fmt::format("{:.3g} and at {:.3g}", ends.low, ends.high)
                                : fmt::format("{:.3g}", ends.below ? ends.low : ends.high);
  return fmt::format(
      "v_oc of {} is known between {:.3g} and {:.3g} of the charge: at {} it is its end slope drawn on, which no "
      "log has shown and no interval counts. Logs that go so far would tell",
      cell.name.empty() ? "the cell" : cell.name,
      curve.soc_lo(),
      curve.soc_hi(),
      where);
}

}  // namespace lipoid
