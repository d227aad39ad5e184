#include "identify/joint/held_shape.h"

#include <algorithm>

#include "model/battery/cell_parameters.h"
#include "model/core/errors.h"

namespace lipoid {

std::vector<double> HeldShape::ResistanceNodes() const {
  std::vector<double> nodes{0.5};
  for (const std::string& name : CellResistanceNames(cell)) {
    const auto& soc = CellResistance(cell, name)->soc;
    if (soc.size() > nodes.size()) nodes = soc;
  }
  return nodes;
}

double HeldShape::Resistance(int t, double soc) const {
  constexpr double kLeast = 0.05;
  const auto names = CellResistanceNames(cell);
  Require(t >= 0 && t < static_cast<int>(names.size()), "a table that the cell has");
  const auto& table = *CellResistance(cell, names[static_cast<std::size_t>(t)]);
  const double largest_Ohm =
      *std::max_element(table.resistance_Ohm.begin(), table.resistance_Ohm.end());
  // A branch that was not found has no shape.
  if (!(largest_Ohm > 0.0)) return 1.0;
  return std::max(table(soc), kLeast * largest_Ohm);
}

std::map<std::string, double> HeldShape::Rates() const {
  std::map<std::string, double> rates;
  for (const std::string& name : CellParameterNames(cell)) {
    const bool held = name == "tau_h" || name == "i_0" || name == "gamma" ||
                      name.starts_with("tau_") || name.starts_with("E_");
    if (held) rates[name] = *CellParameter(cell, name);
  }
  return rates;
}

std::vector<std::string> HeldShape::Names() const {
  std::vector<std::string> names{"v_oc(A)"};
  for (const auto& [name, value] : Rates()) names.push_back(name);
  if (cell.temperature && cell.temperature->entropy) names.emplace_back("dv_oc/dT(A)");
  if (cell.hysteresis) names.emplace_back("M(A)");
  if (cell.temperature && cell.temperature->heat) names.emplace_back("the heat balance");
  return names;
}

}  // namespace lipoid
