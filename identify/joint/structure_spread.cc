#include "identify/joint/structure_spread.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/fit/cell_of_solution.h"
#include "model/battery/cell_parameters.h"
#include "model/core/special_values.h"

namespace lipoid {
namespace {

// The time constant that is nearest to one of another solution; none: -1.
int BranchNear(const std::vector<double>& taus_s, double tau_s) {
  int nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t j = 0; j < taus_s.size(); ++j) {
    const double off = std::abs(std::log(taus_s[j] / tau_s));
    if (off >= least) continue;
    least = off;
    nearest = static_cast<int>(j);
  }
  return nearest;
}

// How much of each branch of a solution stands for one of the solution that was taken: the nearest
// one, and of the others that have no nearer one there what e^{-t/tau} of both has in common,
//   <e_a, e_b>/(|e_a| |e_b|) = 2 sqrt(tau_a tau_b)/(tau_a + tau_b).
// The halves into which a branch was split are one again. Empty: there is none.
std::vector<double> SharesIn(const JointSolution& solution,
                             const JointSolution& taken,
                             std::size_t branch,
                             BranchMatch match) {
  const auto& taus_s = solution.rates.time_constant_s;
  const auto& of_taken_s = taken.rates.time_constant_s;
  if (match == BranchMatch::kEachOnce) {
    std::vector<double> shares;
    for (const double tau_s : taus_s)
      shares.push_back(BranchNear(of_taken_s, tau_s) == static_cast<int>(branch) ? 1.0 : 0.0);
    return shares;
  }
  const int nearest = BranchNear(taus_s, of_taken_s[branch]);
  if (nearest < 0) return {};
  const double tau_s = taus_s[static_cast<std::size_t>(nearest)];
  std::vector<double> shares(taus_s.size(), 0.0);
  for (std::size_t j = 0; j < taus_s.size(); ++j) {
    if (BranchNear(of_taken_s, taus_s[j]) == static_cast<int>(branch))
      shares[j] = 2.0 * std::sqrt(tau_s * taus_s[j]) / (tau_s + taus_s[j]);
  }
  shares[static_cast<std::size_t>(nearest)] = 1.0;
  return shares;
}

}  // namespace

double ValueIn(const JointSolution& solution,
               const std::string& name,
               double typical_A,
               const JointSolution& taken,
               const FitAxis& axis,
               BranchMatch match) {
  if (solution.x.size() == 0) return kNaN;
  Cell cell;
  cell.diffusion = Cell::Diffusion{};
  PutInto(cell, solution, typical_A);
  auto [what, of_cell] = SplitQuantity(name);
  if (what == "alpha") return kNaN;
  if (what == "i_off") {  // of the sensor, and of no cell; a structure without it says 0
    return solution.structure.current_offset ? solution.rates.current_offset_A : 0.0;
  }
  // A table where one number is asked for: its mean.
  std::vector<double> soc{0.2, 0.5, 0.8};
  if (of_cell) soc = {axis(*of_cell)};
  const auto mean = [&](const auto& at) {
    double sum = 0.0;
    for (const double a : soc) sum += at(a) / static_cast<double>(soc.size());
    return sum;
  };
  if (what == "r_total") {
    double sum = 0.0;
    for (const std::string& one : CellResistanceNames(cell))
      sum += mean(*CellResistance(cell, one));
    return sum;
  }
  if (const auto known = FindCellParameter(what); known && known->kind->of_branch) {
    if (known->branch >= taken.rates.time_constant_s.size()) return kNaN;
    const std::vector<double> shares = SharesIn(solution, taken, known->branch, match);
    if (match == BranchMatch::kEachOnce &&
        std::count(shares.begin(), shares.end(), 0.0) == static_cast<std::ptrdiff_t>(shares.size()))
      return what.starts_with("r_") ? 0.0 : kNaN;
    if (shares.empty()) return kNaN;
    const auto nearest =
        static_cast<std::size_t>(std::max_element(shares.begin(), shares.end()) - shares.begin());
    double resistance_Ohm = 0.0;
    double log_tau = 0.0;  // weighed by the resistances
    for (std::size_t j = 0; j < shares.size(); ++j) {
      const double part_Ohm = shares[j] * mean(cell.branches[j].resistance_Ohm);
      resistance_Ohm += part_Ohm;
      log_tau += part_Ohm * std::log(cell.branches[j].time_constant_s);
    }
    const double nearest_s = cell.branches[nearest].time_constant_s;
    const bool alone = std::count(shares.begin(), shares.end(), 0.0) + 1 ==
                       static_cast<std::ptrdiff_t>(shares.size());
    const double tau_s =
        alone || !(resistance_Ohm > 0.0) ? nearest_s : std::exp(log_tau / resistance_Ohm);
    if (what.starts_with("r_")) return resistance_Ohm;
    if (what.starts_with("tau_")) return tau_s;
    if (what.starts_with("c_")) return tau_s / resistance_Ohm;
    what = fmt::format("{}_{}", known->kind->symbol, nearest + 1);
  }
  if (const Resistance<double>* r = CellResistance(cell, what)) return mean(*r);
  if (what == "M") {
    if (!cell.hysteresis) return 0.0;
    return mean([&](double a) { return cell.hysteresis->Voltage(a, 1.0); });
  }
  if (what == "dv_dT") {
    if (!cell.temperature || !cell.temperature->entropy) return kNaN;
    return mean(*cell.temperature->entropy);
  }
  return CellParameter(cell, what).value_or(kNaN);
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
  Eigen::VectorXd spread(static_cast<Eigen::Index>(choice.tried.size()) + 2);
  spread[0] = off(choice.finer, 1.0);
  spread[1] = off(choice.half_as_warm, 1.0);
  for (std::size_t m = 0; m < choice.tried.size(); ++m) {
    const TriedStructure& row = choice.tried[m];
    spread[static_cast<Eigen::Index>(m) + 2] = off(row.solution, row.weight);
  }
  return spread;
}

}  // namespace lipoid
