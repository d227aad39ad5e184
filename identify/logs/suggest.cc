#include "identify/logs/suggest.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "identify/logs/discharge.h"
#include "model/core/counted.h"

namespace lipoid {

Suggestion SuggestKind(const std::vector<Segment>& segments,
                       const std::optional<Discharge>& discharge) {
  std::size_t loads = 0;
  std::size_t pulses = 0;
  std::size_t relaxations = 0;
  std::size_t varying = 0;
  double out_C = 0.0;
  double in_C = 0.0;
  for (std::size_t k = 0; k < segments.size(); ++k) {
    if (segments[k].kind == SegmentKind::kRest) continue;
    ++loads;
    (segments[k].charge_C > 0.0 ? out_C : in_C) += std::abs(segments[k].charge_C);
    if (segments[k].kind == SegmentKind::kVarying) ++varying;
    if (segments[k].kind != SegmentKind::kPulse) continue;
    ++pulses;
    const bool relaxes = k + 1 < segments.size() && segments[k + 1].kind == SegmentKind::kRest &&
                         segments[k + 1].rows() >= kRestRows;
    if (relaxes) ++relaxations;
  }
  if (loads == 0) return {{}, "only rest"};
  constexpr std::size_t kMostVarying = 4;  // for each pulse; a drive cycle has ten
  if (relaxations > 0 && varying <= kMostVarying * pulses) {
    return {
        LogKind::kPulses,
        fmt::format("{}, {} of them followed by a rest", Counted(pulses, "pulse"), relaxations)};
  }
  if (discharge) {
    const double charge_Ah = discharge->charge_C / 3600.0;
    const double rate_per_h = discharge->current_A / charge_Ah;
    const bool low = rate_per_h <= kMaxLowRate_per_h;
    return {low ? LogKind::kLowRate : LogKind::kConstantCurrent,
            fmt::format("one discharge of {:.4g} Ah at {:.4g} A, {:.2g} C of its own charge",
                        charge_Ah,
                        discharge->current_A,
                        rate_per_h)};
  }
  if (out_C == 0.0) {
    return {{},
            "only charging; a slow charge takes part in a campaign as `low-rate-charge`, with its "
            "`initial_soc`"};
  }
  if (in_C > 0.5 * out_C) {
    return {LogKind::kValidation,
            "charges and discharges; for another kind choose a part with steps, cycles or times"};
  }
  if (relaxations > 0) {
    return {LogKind::kValidation,
            fmt::format(
                "{}, {} of them varying, as in a drive cycle", Counted(loads, "load"), varying)};
  }
  return {LogKind::kValidation,
          fmt::format("{} without a pulse followed by a rest", Counted(loads, "load"))};
}

}  // namespace lipoid
