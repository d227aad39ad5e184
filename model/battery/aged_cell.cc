#include "model/battery/aged_cell.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "model/core/errors.h"

namespace lipoid {

Cell Aged(Cell cell, double capacity_share, double resistance_factor) {
  Require(capacity_share > 0.0 && resistance_factor > 0.0,
          "a share of the capacity and a factor of the resistance above 0",
          {{"capacity_share", capacity_share}, {"resistance_factor", resistance_factor}});
  cell.uncertainty.reset();
  if (capacity_share == 1.0 && resistance_factor == 1.0) return cell;
  cell.capacity_Ah *= capacity_share;
  if (cell.diffusion) cell.diffusion->alpha_C *= capacity_share;
  cell.series_resistance_Ohm.Scale(resistance_factor);
  for (Cell::Branch& branch : cell.branches) {
    branch.resistance_Ohm.Scale(resistance_factor);
    if (branch.capacitance_F) *branch.capacitance_F /= resistance_factor;
  }
  if (cell.charge_transfer) cell.charge_transfer->resistance_Ohm.Scale(resistance_factor);
  if (cell.self_heating) cell.self_heating->resistance_drop_Ohm_per_A2 *= resistance_factor;
  return cell;
}

Cell Resized(Cell cell, double factor) {
  cell = Aged(std::move(cell), factor, 1.0 / factor);
  if (cell.charge_transfer) cell.charge_transfer->current_A *= factor;
  // Of the thermal state, which goes with the square of the current.
  if (cell.self_heating) cell.self_heating->resistance_drop_Ohm_per_A2 /= factor * factor;
  if (cell.temperature && cell.temperature->heat) {
    cell.temperature->heat->heat_capacity_J_per_K *= factor;
    cell.temperature->heat->thermal_resistance_K_per_W /= factor;
  }
  return cell;
}

std::string DoubtAboutSize(const Cell& cell, double factor) {
  constexpr double kUsual = 0.1;  // by which labels and cells differ
  const double share = cell.alpha_C() / 3600.0 / cell.capacity_Ah;
  if (factor == 1.0 || std::abs(share - 1.0) <= kUsual) return "";
  const double given_Ah = factor * cell.capacity_Ah;
  return fmt::format(
      "{} gives {:.3g} % of its nominal capacity, and so a cell of {:.4g} Ah is taken to give {:.3g} Ah: of one "
      "that gives {:.4g} Ah, say --capacity-Ah {:.3g}, or take another cell file",
      cell.name,
      100.0 * share,
      given_Ah,
      share * given_Ah,
      given_Ah,
      given_Ah / share);
}

}  // namespace lipoid
