#include "model/battery/cell_parameters.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <cmath>
#include <limits>

#include "model/core/errors.h"

namespace lipoid {
namespace {

// A parameter that is still to come.
constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

std::optional<double> UnlessMissing(double value) {
  return std::isnan(value) ? std::nullopt : std::optional<double>(value);
}

std::optional<double> UnlessMissing(const Resistance<double>& resistance) {
  return resistance.constant() ? UnlessMissing(resistance.resistance_Ohm[0]) : std::nullopt;
}

// "tau_2" is {"tau", 1}.
struct BranchName {
  std::string_view symbol;
  std::size_t index = 0;
};

std::optional<BranchName> ParseBranchName(std::string_view name) {
  for (const std::string_view symbol : {"r", "c", "tau"}) {
    if (!name.starts_with(symbol) || name.substr(symbol.size(), 1) != "_") continue;
    const auto digits = name.substr(symbol.size() + 1);
    std::size_t number = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (error == std::errc{} && end == digits.data() + digits.size() && number >= 1) {
      return BranchName{symbol, number - 1};
    }
  }
  return std::nullopt;
}

// "r_s[3]" is {"r_s", 3}.
struct NodeName {
  std::string_view table;
  std::size_t index = 0;
};

std::optional<NodeName> ParseNodeName(std::string_view name) {
  const auto bracket = name.find('[');
  if (bracket == std::string_view::npos || !name.ends_with(']')) return std::nullopt;
  const auto digits = name.substr(bracket + 1, name.size() - bracket - 2);
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
  if (error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
  return NodeName{name.substr(0, bracket), index};
}

// The resistance that may be a table: r_s, r_1, ..., r_ct; null where the cell has none of that
// name.
template <class AnyCell>
auto* FindResistance(AnyCell& cell, std::string_view name) {
  decltype(&cell.series_resistance_Ohm) found = nullptr;
  const auto branch_name = ParseBranchName(name);
  if (name == "r_s") {
    found = &cell.series_resistance_Ohm;
  } else if (name == "r_ct" && cell.charge_transfer) {
    found = &cell.charge_transfer->resistance_Ohm;
  } else if (branch_name && branch_name->symbol == "r" &&
             branch_name->index < cell.branches.size()) {
    found = &cell.branches[branch_name->index].resistance_Ohm;
  }
  return found;
}

// Nodes of a table of this name: none where the cell has no such table.
std::size_t CountNodes(const Cell& cell, std::string_view table) {
  if (table == "v_oc") return cell.open_circuit_voltage.voltage_V().size();
  const auto* resistance = FindResistance(cell, table);
  return resistance && !resistance->constant() ? resistance->resistance_Ohm.size() : 0;
}

void Check(bool holds, std::string_view name, std::string_view expected, double value) {
  if (!holds || !std::isfinite(value)) {
    throw OptionError(fmt::format("{}: expected {}, found {}", name, expected, value));
  }
}

void SetBranch(Cell& cell, std::string_view name, const BranchName& branch_name, double value) {
  const auto& [symbol, index] = branch_name;
  if (index == cell.branches.size() && symbol == "r") {
    cell.branches.push_back(
        {.resistance_Ohm = {}, .time_constant_s = kMissing, .capacitance_F = {}});
  }
  if (index >= cell.branches.size()) {
    throw OptionError(fmt::format("{}: the cell has {} branch{}; give r_{} first to add one",
                                  name,
                                  cell.branches.size(),
                                  cell.branches.size() == 1 ? "" : "es",
                                  cell.branches.size() + 1));
  }
  Cell::Branch& branch = cell.branches[index];
  if (symbol == "tau") {
    Check(value > 0.0, name, "a time constant above 0 s", value);
    branch.time_constant_s = value;
    branch.capacitance_F.reset();
    return;
  }
  if (symbol == "r") {
    Check(value >= 0.0, name, "a resistance of at least 0 Ohm", value);
    branch.resistance_Ohm = Resistance<double>(value);
  } else {
    Check(value > 0.0, name, "a capacitance above 0 F", value);
    Check(branch.resistance_Ohm.constant(), name, "tau, beside a table of resistances", value);
    branch.capacitance_F = value;
  }
  if (branch.capacitance_F) {
    branch.time_constant_s = branch.resistance_Ohm.resistance_Ohm[0] * *branch.capacitance_F;
  }
}

void SetNode(Cell& cell, std::string_view name, const NodeName& node, double value) {
  const std::size_t nodes = CountNodes(cell, node.table);
  if (node.index >= nodes) {
    throw OptionError(
        nodes == 0
            ? fmt::format("'{}' is no parameter of this cell: it has no table {}", name, node.table)
            : fmt::format("'{}' is no parameter of this cell: the nodes of {} are 0 to {}",
                          name,
                          node.table,
                          nodes - 1));
  }
  if (node.table != "v_oc") {
    Check(value >= 0.0, name, "a resistance of at least 0 Ohm", value);
    FindResistance(cell, node.table)->resistance_Ohm[node.index] = value;
    return;
  }
  Check(true, name, "a finite voltage", value);
  const OpenCircuitVoltage& curve = cell.open_circuit_voltage;
  auto voltage_V = curve.voltage_V();
  voltage_V[node.index] = value;
  cell.open_circuit_voltage =
      curve.method() == OcvMethod::kLinear
          ? OpenCircuitVoltage::Linear(curve.soc(), std::move(voltage_V))
          : OpenCircuitVoltage::MonotoneCubic(curve.soc(), std::move(voltage_V));
}

// tau_h, rho_h.
void SetSelfHeating(Cell& cell, std::string_view name, double value) {
  const bool time = name == "tau_h";
  if (time) {
    Check(value > 0.0, name, "a time constant above 0 s", value);
  } else {
    Check(value >= 0.0, name, "a drop of the resistance of at least 0 Ohm/A^2", value);
  }
  if (!cell.self_heating) cell.self_heating = Cell::SelfHeating{kMissing, kMissing};
  (time ? cell.self_heating->time_constant_s : cell.self_heating->resistance_drop_Ohm_per_A2) =
      value;
}

// i_0, r_ct.
void SetChargeTransfer(Cell& cell, std::string_view name, double value) {
  const bool current = name == "i_0";
  if (current) {
    Check(value > 0.0, name, "a current above 0 A", value);
  } else {
    Check(value >= 0.0, name, "a resistance of at least 0 Ohm", value);
  }
  if (!cell.charge_transfer) cell.charge_transfer = Cell::ChargeTransfer{kMissing, kMissing};
  if (current) {
    cell.charge_transfer->current_A = value;
  } else {
    cell.charge_transfer->resistance_Ohm = value;
  }
}

}  // namespace

std::vector<std::string> CellParameterNames(const Cell& cell) {
  std::vector<std::string> names;
  const auto add = [&](std::string name) {
    if (CellParameter(cell, name)) names.push_back(std::move(name));
  };
  for (const char* name : {"alpha", "beta", "r_s"}) add(name);
  for (std::size_t j = 1; j <= cell.branches.size(); ++j) {
    for (const char* symbol : {"r", "c", "tau"}) add(fmt::format("{}_{}", symbol, j));
  }
  for (const char* name : {"tau_h", "rho_h", "i_0", "r_ct"}) add(name);
  return names;
}

std::vector<std::string> CellNodeNames(const Cell& cell) {
  std::vector<std::string> tables{"r_s"};
  for (std::size_t j = 1; j <= cell.branches.size(); ++j) tables.push_back(fmt::format("r_{}", j));
  tables.insert(tables.end(), {"r_ct", "v_oc"});
  std::vector<std::string> names;
  for (const auto& table : tables) {
    for (std::size_t k = 0; k < CountNodes(cell, table); ++k)
      names.push_back(fmt::format("{}[{}]", table, k));
  }
  return names;
}

std::optional<double> CellParameter(const Cell& cell, std::string_view name) {
  if (const auto node = ParseNodeName(name)) {
    if (node->index >= CountNodes(cell, node->table)) return std::nullopt;
    if (node->table == "v_oc") return cell.open_circuit_voltage.voltage_V()[node->index];
    return FindResistance(cell, node->table)->resistance_Ohm[node->index];
  }
  if (name == "alpha" && cell.diffusion) return cell.diffusion->alpha_C;
  if (name == "beta" && cell.diffusion) return cell.diffusion->beta_per_sqrt_s;
  if (name == "r_s") return UnlessMissing(cell.series_resistance_Ohm);
  if (const auto& term = cell.self_heating) {
    if (name == "tau_h") return UnlessMissing(term->time_constant_s);
    if (name == "rho_h") return UnlessMissing(term->resistance_drop_Ohm_per_A2);
  }
  if (const auto& term = cell.charge_transfer) {
    if (name == "i_0") return UnlessMissing(term->current_A);
    if (name == "r_ct") return UnlessMissing(term->resistance_Ohm);
  }
  const auto branch_name = ParseBranchName(name);
  if (!branch_name || branch_name->index >= cell.branches.size()) return std::nullopt;
  const auto& branch = cell.branches[branch_name->index];
  if (branch_name->symbol == "tau") return UnlessMissing(branch.time_constant_s);
  if (!branch.resistance_Ohm.constant()) return std::nullopt;
  const double resistance_Ohm = branch.resistance_Ohm.resistance_Ohm[0];
  if (branch_name->symbol == "r") return resistance_Ohm;
  if (branch.capacitance_F) return branch.capacitance_F;
  if (resistance_Ohm > 0.0) return UnlessMissing(branch.time_constant_s / resistance_Ohm);
  return std::nullopt;
}

void SetCellParameter(Cell& cell, std::string_view name, double value) {
  if (const auto node = ParseNodeName(name)) return SetNode(cell, name, *node, value);
  if (const auto branch_name = ParseBranchName(name))
    return SetBranch(cell, name, *branch_name, value);
  if (name == "r_s") {
    Check(value >= 0.0, name, "a resistance of at least 0 Ohm", value);
    cell.series_resistance_Ohm = Resistance<double>(value);
  } else if (name == "tau_h" || name == "rho_h") {
    SetSelfHeating(cell, name, value);
  } else if (name == "i_0" || name == "r_ct") {
    SetChargeTransfer(cell, name, value);
  } else if (name == "alpha" && cell.diffusion) {
    Check(value > 0.0, name, "a charge above 0 C", value);
    cell.diffusion->alpha_C = value;
  } else if (name == "beta" && cell.diffusion) {
    Check(value > 0.0 && value <= 1.0, name, "a number in (0, 1]", value);
    cell.diffusion->beta_per_sqrt_s = value;
  } else {
    throw OptionError(fmt::format("'{}' is no parameter of this cell; it has {}",
                                  name,
                                  fmt::join(CellParameterNames(cell), ", ")));
  }
}

std::optional<std::string> MissingCellParameter(const Cell& cell) {
  for (std::size_t j = 0; j < cell.branches.size(); ++j) {
    if (std::isnan(cell.branches[j].time_constant_s)) {
      return fmt::format("r_{0} needs c_{0} or tau_{0} beside it", j + 1);
    }
  }
  const auto pair = [](bool first_missing, std::string_view first, std::string_view second) {
    return fmt::format(
        "{} needs {} beside it", first_missing ? second : first, first_missing ? first : second);
  };
  if (const auto& term = cell.self_heating) {
    const bool no_time = std::isnan(term->time_constant_s);
    if (no_time || std::isnan(term->resistance_drop_Ohm_per_A2)) {
      return pair(no_time, "tau_h", "rho_h");
    }
  }
  if (const auto& term = cell.charge_transfer) {
    const bool no_current = std::isnan(term->current_A);
    if (no_current || std::isnan(term->resistance_Ohm.resistance_Ohm[0])) {
      return pair(no_current, "i_0", "r_ct");
    }
  }
  return std::nullopt;
}

std::string_view CellParameterUnit(std::string_view name) {
  if (name == "alpha") return "C";
  if (name.starts_with("v_oc")) return "V";
  if (name == "beta") return "s^-1/2";
  if (name == "i_0") return "A";
  if (name == "rho_h") return "Ohm/A^2";
  if (name.starts_with("tau")) return "s";
  return name.starts_with("c") ? "F" : "Ohm";
}

}  // namespace lipoid
