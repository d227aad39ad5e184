#include "model/analysis/stability_json.h"

#include <nlohmann/json.hpp>

namespace lipoid {

Json StabilityToJson(std::span<const HoverStability> hovers) {
  Json rows = Json::array();
  for (const HoverStability& hover : hovers) {
    for (const LoopStability& loop : hover.loops) {
      rows.push_back({{"loop", loop.loop},
                      {"when", hover.when},
                      {"xi", hover.xi},
                      {"stable", loop.stable()},
                      {"pole_per_s", {loop.pole.real(), loop.pole.imag()}},
                      {"quasistatic_per_s", loop.quasistatic_per_s},
                      {"frequency_rad_per_s", NumberOrNull(loop.frequency_rad_per_s)},
                      {"damping", loop.damping},
                      {"gain_margin_up", NumberOrNull(loop.gain_margin_up)},
                      {"gain_margin_down", NumberOrNull(loop.gain_margin_down)},
                      {"phase_margin_deg", NumberOrNull(loop.phase_margin_deg)}});
    }
  }
  return rows;
}

}  // namespace lipoid
