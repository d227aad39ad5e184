#include "identify/export/law_limits.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/battery/arrhenius.h"

namespace lipoid {

bool IsNegligible(const Cell& cell, const Cell::Branch& branch, double shortest_s) {
  constexpr double kLeastShare = 1e-3;
  if (branch.time_constant_s < shortest_s) return true;
  const auto small = [&](double soc) {
    return branch.resistance_Ohm(soc) < kLeastShare * cell.series_resistance_Ohm(soc);
  };
  if (branch.resistance_Ohm.constant() && cell.series_resistance_Ohm.constant()) return small(1.0);
  const auto all = [&](const std::vector<double>& nodes) {
    return std::all_of(nodes.begin(), nodes.end(), small);
  };
  return all(branch.resistance_Ohm.soc) && all(cell.series_resistance_Ohm.soc);
}

void SetCell(ExportRequest& request, const Cell& cell) {
  request.cell = cell;
  request.whole.reset();
  request.left_out.clear();
  if (cell.temperature) {
    request.left_out.push_back(
        fmt::format("Temperature: the cell's numbers change with it{}; these do not (the reference "
                    "of the cell is {:g} degC).",
                    cell.temperature->heat ? ", and it warms under load" : "",
                    CelsiusOf(cell.temperature->reference_K)));
    request.cell.temperature.reset();
  }
  if (cell.hysteresis) {
    request.left_out.emplace_back(
        "Hysteresis: this v_oc is that half-way between charge and discharge.");
    request.cell.hysteresis.reset();
  }
  if (!request.left_out.empty()) request.whole = cell;
}

std::vector<std::string> LeftOut(const ExportRequest& request, const LawTerms& law) {
  const Cell& cell = request.cell;
  constexpr double kShortest_s = 0.01;
  std::vector<std::string> sentences;
  if (cell.diffusion) {
    sentences.emplace_back(
        law.branches > 0
            ? "Diffusion: this law counts charge alone, so that its branches and tables stand for "
              "what the cell's diffusion does on such a mission, and other currents find them "
              "less right."
            : "Diffusion: this law counts charge alone, so that capacity and resistance stand for "
              "what the cell's diffusion does on such a mission; the voltage does not recover in "
              "rests.");
  }
  const auto lasting =
      std::count_if(cell.branches.begin(), cell.branches.end(), [&](const Cell::Branch& branch) {
        return !IsNegligible(cell, branch, kShortest_s);
      });
  if (lasting > law.branches) {
    sentences.push_back(
        fmt::format("{} of the cell's {} relaxation{}: the law has {}.",
                    lasting - law.branches,
                    lasting,
                    lasting == 1 ? "" : "s",
                    law.branches == 0 ? std::string("none") : fmt::format("{}", law.branches)));
  }
  if (!law.resistance_table && !cell.series_resistance_Ohm.constant())
    sentences.emplace_back("The resistance over the state of charge: the law has one number.");
  if (cell.charge_transfer)
    sentences.emplace_back(
        "Charge transfer: the cell's drop grows less than the current does, the law's in "
        "proportion.");
  if (cell.self_heating)
    sentences.emplace_back("Self-heating: the law's resistance does not fall under load.");
  if (!request.whole) sentences.emplace_back(kNoMoreTerms);
  return sentences;
}

}  // namespace lipoid
