#include "identify/joint/structure_spread.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "identify/fit/cell_of_solution.h"
#include "model/battery/cell_parameters.h"
#include "model/core/special_values.h"

namespace lipoid {
namespace {

// The branch whose time constant is nearest to one of another solution; -1: there is none.
int BranchNear(const JointSolution& solution, double tau_s) {
  const auto& taus_s = solution.rates.time_constant_s;
  int nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (int j = 0; j < solution.structure.branches; ++j) {
    const double off = std::abs(std::log(taus_s[static_cast<std::size_t>(j)] / tau_s));
    if (off >= least) continue;
    least = off;
    nearest = j;
  }
  return nearest;
}

}  // namespace

double ValueIn(const JointSolution& solution,
               const std::string& name,
               double typical_A,
               const JointSolution& taken,
               double alpha_ratio) {
  if (solution.x.size() == 0) return kNaN;
  Cell cell;
  cell.diffusion = Cell::Diffusion{};
  PutInto(cell, solution, typical_A);
  const std::size_t bracket = name.find('(');
  std::string what = name.substr(0, bracket);
  if (what == "alpha") return kNaN;
  if (what == "i_off") {  // of the sensor, and of no cell; a structure without it says 0
    return solution.structure.current_offset ? solution.rates.current_offset_A : 0.0;
  }
  if (const auto known = FindCellParameter(what); known && known->kind->of_branch) {
    if (known->branch >= taken.rates.time_constant_s.size()) return kNaN;
    const int j = BranchNear(solution, taken.rates.time_constant_s[known->branch]);
    if (j < 0) return kNaN;
    what = fmt::format("{}_{}", known->kind->symbol, j + 1);
  }
  // A table where one number is asked for: its mean.
  std::vector<double> soc{0.2, 0.5, 0.8};
  if (bracket != std::string::npos) {
    soc = {1.0 - (1.0 - std::strtod(name.c_str() + bracket + 1, nullptr)) * alpha_ratio};
  }
  const auto mean = [&](const Resistance<double>& r) {
    double sum = 0.0;
    for (const double a : soc) sum += r(a) / static_cast<double>(soc.size());
    return sum;
  };
  if (what == "r_total") {
    double sum = 0.0;
    for (const std::string& one : CellResistanceNames(cell))
      sum += mean(*CellResistance(cell, one));
    return sum;
  }
  if (const Resistance<double>* r = CellResistance(cell, what)) return mean(*r);
  if (what == "M") {
    if (!cell.hysteresis) return 0.0;
    double sum_V = 0.0;
    for (const double a : soc)
      sum_V += cell.hysteresis->Voltage(a, 1.0) / static_cast<double>(soc.size());
    return sum_V;
  }
  if (what == "dv_dT") {
    if (!cell.temperature || !cell.temperature->entropy) return kNaN;
    double sum_V_per_K = 0.0;
    for (const double a : soc)
      sum_V_per_K += (*cell.temperature->entropy)(a) / static_cast<double>(soc.size());
    return sum_V_per_K;
  }
  if (const auto value = CellParameter(cell, what)) return *value;
  if (!what.starts_with("c_")) return kNaN;
  const std::string number = what.substr(2);
  return *CellParameter(cell, "tau_" + number) / mean(*CellResistance(cell, "r_" + number));
}

double OpenCircuitVoltageIn(const JointSolution& solution,
                            const OpenCircuitVoltage& reference,
                            double soc) {
  const auto& nodes = solution.structure.voltage_soc;
  if (nodes.empty() || solution.x.size() == 0) return kNaN;
  const NodeShare at = NodeFinder(nodes)(soc);
  const auto voltage_V = [&](int k) {
    return reference(nodes[static_cast<std::size_t>(k)]) + solution.x[k];
  };
  return (1.0 - at.share) * voltage_V(at.lower) + at.share * voltage_V(at.lower + 1);
}

Eigen::VectorXd SpreadOverStructures(const JointChoice& choice,
                                     const std::function<double(const JointSolution&)>& value) {
  const double estimate = value(choice.best);
  const auto off = [&](const JointSolution& other, double weight) {
    const double by = std::sqrt(weight) * (value(other) - estimate);
    return std::isfinite(by) ? by : 0.0;
  };
  Eigen::VectorXd spread(static_cast<Eigen::Index>(choice.tried.size()) + 1);
  spread[0] = off(choice.finer, 1.0);
  for (std::size_t m = 0; m < choice.tried.size(); ++m) {
    const TriedStructure& row = choice.tried[m];
    spread[static_cast<Eigen::Index>(m) + 1] = off(row.solution, row.weight);
  }
  return spread;
}

}  // namespace lipoid
