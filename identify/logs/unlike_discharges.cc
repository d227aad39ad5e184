#include "identify/logs/unlike_discharges.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lipoid {

std::string DoubtAboutDischarges(const std::vector<FullDischarge>& discharges) {
  constexpr double kSameCurrent = 1.03;
  constexpr double kSameCharge = 1.05;  // repeats of one cell are within a hundredth
  // A slower discharge delivers more, but in the cold, where a fast one warms the cell.
  constexpr double kSlower = 1.1;
  constexpr double kCold_degC = 15.0;
  constexpr double kSame_K = 5.0;
  const FullDischarge* least = nullptr;
  const FullDischarge* most = nullptr;
  double farthest = 1.0;
  for (const FullDischarge& a : discharges) {
    for (const FullDischarge& b : discharges) {
      if (a.current_A > kSameCurrent * b.current_A) continue;
      if (std::abs(a.start_degC - b.start_degC) > kSame_K) continue;
      const bool slower = b.current_A > kSameCurrent * a.current_A;
      if (slower && std::min(a.start_degC, b.start_degC) < kCold_degC) continue;
      const double more = b.charge_C / a.charge_C;
      if (!(more > std::max(farthest, slower ? kSlower : kSameCharge))) continue;
      farthest = more;
      least = &a;
      most = &b;
    }
  }
  if (least == nullptr) return "";
  return fmt::format(
      "at {:.3g} A {} delivers {:.4g} Ah until the cut-off and {}{} {:.4g} Ah: look whether both are of this cell, at "
      "one age and one temperature, and leave out what is not",
      most->current_A,
      most->file,
      most->charge_C / 3600.0,
      most->current_A > kSameCurrent * least->current_A
          ? fmt::format("at {:.3g} A only ", least->current_A)
          : "",
      least->file,
      least->charge_C / 3600.0);
}

}  // namespace lipoid
