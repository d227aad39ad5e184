#include "model/battery/cell_comparison.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>
#include <vector>

#include "model/battery/arrhenius.h"
#include "model/battery/at_temperature.h"
#include "model/battery/cell_parameters.h"
#include "model/core/special_values.h"

namespace lipoid {
namespace {

// Numbers of a cell hold at its reference temperature: the truth at that of the estimate.
Cell AtReferenceOf(const Cell& estimate, const Cell& truth) {
  if (!truth.temperature || !estimate.temperature ||
      truth.temperature->reference_K == estimate.temperature->reference_K)
    return truth;
  Cell moved = AtOneTemperature(truth, CelsiusOf(estimate.temperature->reference_K));
  moved.temperature = truth.temperature;
  moved.temperature->reference_K = estimate.temperature->reference_K;
  return moved;
}

// The estimate with its branches where the truth has those of the nearest time constants, the closest two first and
// each once. Where it has none its branch is missing; what the truth has not comes behind.
Cell InOrderOf(const Cell& truth, const Cell& estimate) {
  Cell moved = estimate;
  moved.branches.assign(
      truth.branches.size(),
      {.resistance_Ohm = Resistance<double>(kNaN), .time_constant_s = kNaN, .capacitance_F = {}});
  std::vector<double> energies_J_per_mol(moved.branches.size(), kNaN);
  std::vector<std::size_t> left(estimate.branches.size());
  std::iota(left.begin(), left.end(), 0);
  const auto move = [&](std::vector<std::size_t>::iterator from, std::size_t to) {
    if (to == moved.branches.size()) {
      moved.branches.emplace_back();
      energies_J_per_mol.emplace_back();
    }
    moved.branches[to] = estimate.branches[*from];
    if (estimate.temperature)
      energies_J_per_mol[to] = estimate.temperature->branches_J_per_mol[*from];
    left.erase(from);
  };
  for (std::size_t pairs = std::min(left.size(), moved.branches.size()); pairs > 0; --pairs) {
    auto from = left.begin();
    std::size_t to = 0;
    double least = kInfinity;
    for (auto j = left.begin(); j != left.end(); ++j) {
      for (std::size_t k = 0; k < truth.branches.size(); ++k) {
        const double off = std::abs(
            std::log(estimate.branches[*j].time_constant_s / truth.branches[k].time_constant_s));
        if (!std::isnan(moved.branches[k].time_constant_s) || off >= least) continue;
        least = off;
        from = j;
        to = k;
      }
    }
    move(from, to);
  }
  while (!left.empty()) move(left.begin(), moved.branches.size());
  if (moved.temperature) moved.temperature->branches_J_per_mol = std::move(energies_J_per_mol);
  return moved;
}

}  // namespace

CellComparison CompareCells(const Cell& of_truth, const Cell& as_estimated) {
  const Cell truth = AtReferenceOf(as_estimated, of_truth);
  const Cell estimate = InOrderOf(truth, as_estimated);
  CellComparison result;
  auto names = CellParameterNames(truth);
  for (const auto& name : CellParameterNames(estimate)) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  for (const auto& name : names) {
    ParameterComparison one{name,
                            std::string(CellParameterUnit(name)),
                            CellParameter(truth, name),
                            CellParameter(estimate, name),
                            std::nullopt};
    if (one.truth && one.estimate && *one.truth != 0.0) {
      one.error_percent = 100.0 * (*one.estimate - *one.truth) / *one.truth;
    }
    result.parameters.push_back(std::move(one));
  }
  constexpr int kSteps = 1000;
  double squares = 0.0;
  for (int k = 0; k <= kSteps; ++k) {
    const double truth_soc = 1.0 - static_cast<double>(k) / kSteps;
    const double charge_C = truth.alpha_C() * (1.0 - truth_soc);
    const double estimate_soc = 1.0 - charge_C / estimate.alpha_C();
    const double difference_V =
        estimate.open_circuit_voltage(estimate_soc) - truth.open_circuit_voltage(truth_soc);
    squares += difference_V * difference_V;
    result.open_circuit_max_V = std::max(result.open_circuit_max_V, std::abs(difference_V));
  }
  result.open_circuit_rms_V = std::sqrt(squares / (kSteps + 1));
  return result;
}

Json ComparisonToJson(const CellComparison& comparison) {
  const auto number = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
  };
  Json parameters = Json::object();
  for (const auto& one : comparison.parameters) {
    parameters[one.name] = {{"truth", number(one.truth)},
                            {"estimate", number(one.estimate)},
                            {"error_percent", number(one.error_percent)}};
  }
  return {{"parameters", parameters},
          {"open_circuit_max_V", comparison.open_circuit_max_V},
          {"open_circuit_rms_V", comparison.open_circuit_rms_V}};
}

}  // namespace lipoid
