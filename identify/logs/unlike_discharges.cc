#include "identify/logs/unlike_discharges.h"

#include <fmt/format.h>

#include <cmath>

namespace lipoid {

std::string DoubtAboutDischarges(const std::vector<FullDischarge>& discharges) {
  constexpr double kSameCurrent = 1.03;
  constexpr double kSameCharge = 1.05;  // repeats of one cell are within a hundredth
  constexpr double kSame_K = 5.0;
  const FullDischarge* least = nullptr;
  const FullDischarge* most = nullptr;
  double farthest = kSameCharge;
  for (const FullDischarge& a : discharges) {
    for (const FullDischarge& b : discharges) {
      if (a.current_A > kSameCurrent * b.current_A || b.current_A > kSameCurrent * a.current_A)
        continue;
      if (std::abs(a.start_degC - b.start_degC) > kSame_K) continue;
      if (!(b.charge_C > farthest * a.charge_C)) continue;
      farthest = b.charge_C / a.charge_C;
      least = &a;
      most = &b;
    }
  }
  if (least == nullptr) return "";
  return fmt::format(
      "at {:.3g} A {} delivers {:.4g} Ah until the cut-off and {} {:.4g} Ah: look whether both are of this cell, at "
      "one age and one temperature, and leave out what is not",
      most->current_A,
      most->file,
      most->charge_C / 3600.0,
      least->file,
      least->charge_C / 3600.0);
}

}  // namespace lipoid
