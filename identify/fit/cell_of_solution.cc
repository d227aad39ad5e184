#include "identify/fit/cell_of_solution.h"

#include <cmath>

namespace lipoid {

std::pair<std::size_t, std::size_t> ReachedSoc::Of(const std::vector<double>& nodes,
                                                   std::size_t least) const {
  std::size_t first = 0;
  std::size_t last = nodes.size() - 1;
  while (first + least <= last && nodes[first + 1] <= lowest) ++first;
  while (first + least <= last && nodes[last - 1] >= highest) --last;
  return {first, last};
}

OpenCircuitVoltage CurveOf(const JointSolution& solution,
                           const OpenCircuitVoltage& reference,
                           const ReachedSoc& reached) {
  const auto& nodes = solution.structure.voltage_soc;
  const auto [first, last] = reached.Of(nodes, 2);
  std::vector<double> at;
  std::vector<double> voltage_V;
  for (std::size_t k = first; k <= last; ++k) {
    at.push_back(nodes[k]);
    voltage_V.push_back(reference(nodes[k]) + solution.x[static_cast<Eigen::Index>(k)]);
  }
  return OpenCircuitVoltage::Linear(std::move(at), std::move(voltage_V));
}

void PutInto(Cell& cell,
             const JointSolution& solution,
             double typical_A,
             const ReachedSoc& reached) {
  const JointStructure& structure = solution.structure;
  const JointLayout layout(structure);
  const JointRates& rates = solution.rates;
  const double per_A = 1.0 / typical_A;
  const auto table = [&](int at) -> Resistance<double> {
    const auto& nodes = structure.resistance_soc;
    if (nodes.size() == 1) return {solution.x[at] * per_A};
    const auto [first, last] = reached.Of(nodes, 1);
    std::vector<double> soc(nodes.begin() + static_cast<std::ptrdiff_t>(first),
                            nodes.begin() + static_cast<std::ptrdiff_t>(last) + 1);
    std::vector<double> resistance_Ohm;
    for (std::size_t k = first; k <= last; ++k)
      resistance_Ohm.push_back(solution.x[at + static_cast<int>(k)] * per_A);
    return {std::move(soc), std::move(resistance_Ohm)};
  };
  if (cell.diffusion) cell.diffusion->beta_per_sqrt_s = rates.beta_per_sqrt_s;
  cell.series_resistance_Ohm = table(layout.series());
  cell.branches.clear();
  for (int j = 0; j < structure.branches; ++j) {
    Cell::Branch branch;
    branch.resistance_Ohm = table(layout.branch(j));
    branch.time_constant_s = rates.time_constant_s[static_cast<std::size_t>(j)];
    const double r = branch.resistance_Ohm.resistance_Ohm[0];
    if (branch.resistance_Ohm.constant() && r > 0.0)
      branch.capacitance_F = branch.time_constant_s / r;
    cell.branches.push_back(std::move(branch));
  }
  cell.charge_transfer.reset();
  if (structure.charge_transfer) {
    cell.charge_transfer = Cell::ChargeTransfer{.current_A = rates.charge_transfer_A,
                                                .resistance_Ohm = table(layout.transfer())};
  }
  cell.temperature.reset();
  if (structure.temperature) {
    Cell::Temperature& term = cell.temperature.emplace();
    term.series_J_per_mol = rates.Series();
    for (std::size_t j = 0; j < cell.branches.size(); ++j)
      term.branches_J_per_mol.push_back(rates.Branch(j));
    if (std::isfinite(rates.Diffusion())) term.diffusion_J_per_mol = rates.Diffusion();
    if (structure.charge_transfer) term.charge_transfer_J_per_mol = rates.Transfer();
    if (layout.entropies() > 0) {
      const auto slopes =
          solution.x.segment(layout.entropy(), layout.entropies()) / kEntropyScale_K;
      term.entropy = EntropySlope<double>{structure.entropy_soc, {slopes.begin(), slopes.end()}};
    }
  }
  cell.hysteresis.reset();
  if (layout.hystereses() > 0) {
    const auto half_V = solution.x.segment(layout.hysteresis(), layout.hystereses());
    cell.hysteresis = Cell::Hysteresis{
        .folds = rates.hysteresis_folds,
        .soc = layout.hystereses() > 1 ? structure.hysteresis_soc : std::vector<double>{},
        .half_V = {half_V.begin(), half_V.end()}};
  }
  cell.self_heating.reset();
  if (structure.self_heating) {
    cell.self_heating = Cell::SelfHeating{
        .time_constant_s = rates.heating_time_constant_s,
        .resistance_drop_Ohm_per_A2 = solution.x[layout.heating()] * std::pow(per_A, 3)};
  }
}

}  // namespace lipoid
