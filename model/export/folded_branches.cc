#include "model/export/folded_branches.h"

#include <fmt/format.h>

#include <algorithm>

namespace lipoid {

Resistance<double> Sum(const Resistance<double>& a, const Resistance<double>& b) {
  if (a.constant() && b.constant()) return a.resistance_Ohm[0] + b.resistance_Ohm[0];
  std::vector<double> soc = a.soc;
  soc.insert(soc.end(), b.soc.begin(), b.soc.end());
  std::sort(soc.begin(), soc.end());
  soc.erase(std::unique(soc.begin(), soc.end()), soc.end());
  std::vector<double> resistance_Ohm(soc.size());
  for (std::size_t k = 0; k < soc.size(); ++k) resistance_Ohm[k] = a(soc[k]) + b(soc[k]);
  return {std::move(soc), std::move(resistance_Ohm)};
}

FoldedCell FoldFastBranches(const Cell& cell) {
  FoldedCell folded{cell, {}};
  folded.cell.branches.clear();
  const auto& series = cell.series_resistance_Ohm.resistance_Ohm;
  const double least_series_Ohm = *std::min_element(series.begin(), series.end());
  for (std::size_t j = 0; j < cell.branches.size(); ++j) {
    const Cell::Branch& branch = cell.branches[j];
    const auto& ohms = branch.resistance_Ohm.resistance_Ohm;
    const double largest_Ohm = *std::max_element(ohms.begin(), ohms.end());
    const double tau_s = branch.time_constant_s;
    const bool fast = tau_s < kFoldedTimeConstant_s;
    const bool small =
        largest_Ohm < kFoldedShare * least_series_Ohm && tau_s < kFoldedSmallTimeConstant_s;
    if (!fast && !small) {
      folded.cell.branches.push_back(branch);
      continue;
    }
    folded.cell.series_resistance_Ohm =
        Sum(folded.cell.series_resistance_Ohm, branch.resistance_Ohm);
    folded.notes.push_back(fmt::format(
        "Branch {} of the cell (at most {:.4g} Ohm, {:.4g} s) is too fast to be seen and is part of "
        "the series resistance here.",
        j + 1,
        largest_Ohm,
        tau_s));
  }
  return folded;
}

}  // namespace lipoid
