#include "identify/joint/joint_drawn.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "identify/joint/structure_spread.h"
#include "identify/trust/cell_uncertainty.h"
#include "model/battery/cell_parameters.h"

namespace lipoid {
namespace {

// What is said of one branch alone has in it what stands for its neighbours too: cells drawn with that would have
// the resistance of all of them. A branch without neighbours is drawn with the errors that are reported.
BranchMatch MatchOf(const JointSolution& taken) {
  return taken.structure.branches > 1 ? BranchMatch::kEachOnce : BranchMatch::kNearest;
}

class Nodes {
 public:
  Nodes(const JointResult& result, Eigen::Index rates)
      : result_(result),
        layout_(result.choice.best.structure),
        rates_(rates),
        size_(rates + layout_.size()) {}

  // The unknowns are rises: a node is the sum of those up to it.
  void AddVoltages(std::vector<NamedCombination>& to) const {
    const auto& nodes = result_.choice.best.structure.voltage_soc;
    if (nodes.empty()) return;  // given
    const auto& in_cell = result_.cell.open_circuit_voltage.soc();
    const std::size_t first = First(nodes, in_cell.front());
    for (std::size_t k = 0; k < in_cell.size(); ++k) {
      Eigen::VectorXd of = Eigen::VectorXd::Zero(size_);
      of.segment(rates_, static_cast<Eigen::Index>(first + k) + 1).setOnes();
      to.push_back({fmt::format("v_oc[{}]", k), std::move(of), Spread([&](const auto& in) {
                      return OpenCircuitVoltageIn(
                          in, result_.setup.open_circuit_voltage, nodes[first + k]);
                    })});
    }
  }

  // The cell has the nodes that rows reached, on an axis of its own alpha. A table of one node is a
  // number, and among the quantities.
  void AddTable(const std::string& name,
                const std::vector<double>& in_cell,
                const std::vector<double>& nodes,
                int table,
                double per_unknown,
                std::vector<NamedCombination>& to) const {
    if (in_cell.empty() || nodes.size() == 1) return;
    const std::size_t first = First(nodes, in_cell.front());
    for (std::size_t k = 0; k < in_cell.size(); ++k) {
      Eigen::VectorXd of = Eigen::VectorXd::Zero(size_);
      of[rates_ + table + static_cast<Eigen::Index>(first + k)] = per_unknown;
      const std::string at = fmt::format("{}({})", name, nodes[first + k]);
      to.push_back({fmt::format("{}[{}]", name, k), std::move(of), Spread([&](const auto& in) {
                      return ValueIn(in,
                                     at,
                                     result_.logs.typical_A,
                                     result_.choice.best,
                                     {},
                                     MatchOf(result_.choice.best));
                    })});
    }
  }

 private:
  [[nodiscard]] Eigen::VectorXd Spread(
      const std::function<double(const JointSolution&)>& value) const {
    return SpreadOverStructures(result_.choice, value);
  }

  // The node of the fit that is the first of the cell.
  [[nodiscard]] std::size_t First(const std::vector<double>& nodes, double cell_soc) const {
    const double soc = result_.Axis()(cell_soc);
    const auto nearer = [soc](double a, double b) { return std::abs(a - soc) < std::abs(b - soc); };
    return static_cast<std::size_t>(std::min_element(nodes.begin(), nodes.end(), nearer) -
                                    nodes.begin());
  }

  const JointResult& result_;
  JointLayout layout_;
  Eigen::Index rates_;
  Eigen::Index size_;
};

}  // namespace

std::vector<NamedCombination> DrawnOfJoint(const JointResult& result,
                                           const std::vector<TrustedQuantity>& quantities,
                                           Eigen::Index rates) {
  const JointSolution& best = result.choice.best;
  const JointLayout layout(best.structure);
  const Nodes nodes(result, rates);
  std::vector<NamedCombination> drawn = CellParametersAmong(quantities);
  if (!SocFollowsAlpha(result) && !best.structure.free_alpha)
    std::erase_if(drawn, [](const NamedCombination& one) { return one.name == "alpha"; });
  const BranchMatch match = MatchOf(best);
  for (NamedCombination& one : drawn) {
    const auto parameter = FindCellParameter(one.name);
    const bool of_branch = parameter && parameter->kind->of_branch;
    if (!of_branch || match == BranchMatch::kNearest) continue;  // as it is reported
    one.added_spread = SpreadOverStructures(result.choice, [&](const JointSolution& in) {
      return ValueIn(in, one.name, result.logs.typical_A, best, result.Axis(), match);
    });
  }
  const Cell& cell = result.cell;
  const JointStructure& s = best.structure;
  const double per_A = 1.0 / result.logs.typical_A;
  int t = 0;  // tables stand in the order in which a cell names its resistances
  for (const std::string& name : CellResistanceNames(cell)) {
    const auto& in_cell = CellResistance(cell, name)->soc;
    nodes.AddTable(name, in_cell, s.resistance_soc, layout.table(t++), per_A, drawn);
  }
  if (layout.entropies() > 0) {
    const auto& in_cell = cell.temperature->entropy->soc;
    nodes.AddTable("dv_dT", in_cell, s.entropy_soc, layout.entropy(), 1.0 / kEntropyScale_K, drawn);
  }
  if (layout.hystereses() > 0)
    nodes.AddTable("M", cell.hysteresis->soc, s.hysteresis_soc, layout.hysteresis(), 1.0, drawn);
  nodes.AddVoltages(drawn);
  return drawn;
}

bool SocFollowsAlpha(const JointResult& result) {
  const JointStructure& best = result.choice.best.structure;
  if (best.voltage_soc.empty()) return false;  // given, or held over A
  return best.free_alpha || std::all_of(result.logs.logs.begin(),
                                        result.logs.logs.end(),
                                        [](const JointLog& log) { return log.delivered_C == 0.0; });
}

}  // namespace lipoid
