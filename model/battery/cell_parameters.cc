#include "model/battery/cell_parameters.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>

#include "model/battery/ranges.h"
#include "model/core/errors.h"
#include "model/core/special_values.h"

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

// A row of the table: what is true of the parameter, how a cell gives it and takes it.
struct Row {
  CellParameterKind kind;
  std::optional<double> (*get)(const Cell& cell, std::size_t branch);
  void (*set)(Cell& cell, std::size_t branch, double value);
};

// The terms beyond the thesis begin with one of their two parameters.
Cell::SelfHeating& Heating(Cell& cell) {
  if (!cell.self_heating) cell.self_heating = Cell::SelfHeating{kMissing, kMissing};
  return *cell.self_heating;
}
Cell::ChargeTransfer& Transfer(Cell& cell) {
  if (!cell.charge_transfer) cell.charge_transfer = Cell::ChargeTransfer{kMissing, kMissing};
  return *cell.charge_transfer;
}

// Activation energies begin at zero, where temperature does nothing.
Cell::Temperature& Warmth(Cell& cell) {
  if (!cell.temperature) cell.temperature.emplace();
  cell.temperature->branches_J_per_mol.resize(cell.branches.size(), 0.0);
  return *cell.temperature;
}
HeatBalance<double>& Heat(Cell& cell) {
  auto& heat = Warmth(cell).heat;
  if (!heat) heat = HeatBalance<double>{kMissing, kMissing};
  return *heat;
}
template <auto kNumber>
std::optional<double> OfHeat(const Cell& cell, std::size_t) {
  if (!cell.temperature || !cell.temperature->heat) return std::nullopt;
  return UnlessMissing((*cell.temperature->heat).*kNumber);
}
Cell::Hysteresis& Memory(Cell& cell) {
  if (!cell.hysteresis)
    cell.hysteresis = Cell::Hysteresis{.folds = kMissing, .soc = {}, .half_V = {kMissing}};
  return *cell.hysteresis;
}
std::optional<double> Energy(const Cell& cell, double Cell::Temperature::*of) {
  return cell.temperature ? std::optional(*cell.temperature.*of) : std::nullopt;
}

// A number of a term that a cell may have. It is set in what kBegun() gives: the term, begun where
// the cell has none yet.
template <auto kTerm, auto kNumber>
std::optional<double> Of(const Cell& cell, std::size_t) {
  return cell.*kTerm ? UnlessMissing((*(cell.*kTerm)).*kNumber) : std::nullopt;
}
template <auto kBegun, auto kNumber>
void Set(Cell& cell, std::size_t, double value) {
  kBegun(cell).*kNumber = value;
}

// With r_j given, a branch keeps what it was written with: its capacitance or its time constant.
void FollowCapacitance(Cell::Branch& branch) {
  if (branch.capacitance_F)
    branch.time_constant_s = branch.resistance_Ohm.resistance_Ohm[0] * *branch.capacitance_F;
}

constexpr std::string_view kResistance = "a resistance of at least 0 Ohm";
constexpr std::string_view kTimeConstant = "a time constant above 0 s";
constexpr std::string_view kEnergy = "an activation energy from 0 to 200000 J/mol";
constexpr double kMostEnergy = 2e5;

// The only list of parameters, in the order in which cells name them.
const std::array kRows{
    Row{{"alpha", "C", "a charge above 0 C", false, false, kInfinity},
        [](const Cell& cell, std::size_t) {
          return cell.diffusion ? std::optional(cell.diffusion->alpha_C) : std::nullopt;
        },
        [](Cell& cell, std::size_t, double value) { cell.diffusion->alpha_C = value; }},
    Row{{"beta",
         "s^-1/2",
         "a number from 0.0001 to 1",
         false,
         false,
         1.0,
         false,
         kLeastBeta_per_sqrt_s},
        [](const Cell& cell, std::size_t) {
          return cell.diffusion ? std::optional(cell.diffusion->beta_per_sqrt_s) : std::nullopt;
        },
        [](Cell& cell, std::size_t, double value) { cell.diffusion->beta_per_sqrt_s = value; }},
    Row{{"r_s", "Ohm", kResistance, false, true, kInfinity},
        [](const Cell& cell, std::size_t) { return UnlessMissing(cell.series_resistance_Ohm); },
        [](Cell& cell, std::size_t, double value) {
          cell.series_resistance_Ohm = Resistance<double>(value);
        }},
    Row{{"r", "Ohm", kResistance, true, true, kInfinity},
        [](const Cell& cell, std::size_t j) {
          return UnlessMissing(cell.branches[j].resistance_Ohm);
        },
        [](Cell& cell, std::size_t j, double value) {
          cell.branches[j].resistance_Ohm = Resistance<double>(value);
          FollowCapacitance(cell.branches[j]);
        }},
    Row{{"c", "F", "a capacitance above 0 F", true, false, kInfinity},
        [](const Cell& cell, std::size_t j) -> std::optional<double> {
          const Cell::Branch& branch = cell.branches[j];
          if (!branch.resistance_Ohm.constant()) return std::nullopt;
          if (branch.capacitance_F) return branch.capacitance_F;
          const double resistance_Ohm = branch.resistance_Ohm.resistance_Ohm[0];
          if (!(resistance_Ohm > 0.0)) return std::nullopt;
          return UnlessMissing(branch.time_constant_s / resistance_Ohm);
        },
        [](Cell& cell, std::size_t j, double value) {
          cell.branches[j].capacitance_F = value;
          FollowCapacitance(cell.branches[j]);
        }},
    Row{{"tau", "s", kTimeConstant, true, false, kInfinity},
        [](const Cell& cell, std::size_t j) {
          return UnlessMissing(cell.branches[j].time_constant_s);
        },
        [](Cell& cell, std::size_t j, double value) {
          cell.branches[j].time_constant_s = value;
          cell.branches[j].capacitance_F.reset();
        }},
    Row{{"E", "J/mol", kEnergy, true, true, kMostEnergy},
        [](const Cell& cell, std::size_t j) -> std::optional<double> {
          if (!cell.temperature) return std::nullopt;
          return UnlessMissing(cell.temperature->branches_J_per_mol[j]);
        },
        [](Cell& cell, std::size_t j, double value) {
          Warmth(cell).branches_J_per_mol[j] = value;
        }},
    Row{{"tau_h", "s", kTimeConstant, false, false, kInfinity},
        &Of<&Cell::self_heating, &Cell::SelfHeating::time_constant_s>,
        &Set<&Heating, &Cell::SelfHeating::time_constant_s>},
    Row{{"rho_h",
         "Ohm/A^2",
         "a drop of the resistance of at least 0 Ohm/A^2",
         false,
         true,
         kInfinity},
        &Of<&Cell::self_heating, &Cell::SelfHeating::resistance_drop_Ohm_per_A2>,
        &Set<&Heating, &Cell::SelfHeating::resistance_drop_Ohm_per_A2>},
    Row{{"i_0", "A", "a current above 0 A", false, false, kInfinity},
        &Of<&Cell::charge_transfer, &Cell::ChargeTransfer::current_A>,
        &Set<&Transfer, &Cell::ChargeTransfer::current_A>},
    Row{{"r_ct", "Ohm", kResistance, false, true, kInfinity},
        &Of<&Cell::charge_transfer, &Cell::ChargeTransfer::resistance_Ohm>,
        &Set<&Transfer, &Cell::ChargeTransfer::resistance_Ohm>},
    Row{{"E_s", "J/mol", kEnergy, false, true, kMostEnergy},
        [](const Cell& cell, std::size_t) {
          return Energy(cell, &Cell::Temperature::series_J_per_mol);
        },
        &Set<&Warmth, &Cell::Temperature::series_J_per_mol>},
    Row{{"E_d", "J/mol", kEnergy, false, true, kMostEnergy},
        [](const Cell& cell, std::size_t) -> std::optional<double> {
          if (!cell.diffusion) return std::nullopt;
          return Energy(cell, &Cell::Temperature::diffusion_J_per_mol);
        },
        &Set<&Warmth, &Cell::Temperature::diffusion_J_per_mol>},
    Row{{"E_ct", "J/mol", kEnergy, false, true, kMostEnergy},
        [](const Cell& cell, std::size_t) -> std::optional<double> {
          if (!cell.charge_transfer) return std::nullopt;
          return Energy(cell, &Cell::Temperature::charge_transfer_J_per_mol);
        },
        &Set<&Warmth, &Cell::Temperature::charge_transfer_J_per_mol>},
    Row{{"C_th", "J/K", "a heat capacity above 0 J/K", false, false, kInfinity},
        &OfHeat<&HeatBalance<double>::heat_capacity_J_per_K>,
        &Set<&Heat, &HeatBalance<double>::heat_capacity_J_per_K>},
    Row{{"R_th", "K/W", "a thermal resistance above 0 K/W", false, false, kInfinity},
        &OfHeat<&HeatBalance<double>::thermal_resistance_K_per_W>,
        &Set<&Heat, &HeatBalance<double>::thermal_resistance_K_per_W>},
    Row{{"dv_dT", "V/K", "a finite slope", false, true, kInfinity, true},
        [](const Cell& cell, std::size_t) -> std::optional<double> {
          if (!cell.temperature || !cell.temperature->entropy) return std::nullopt;
          const auto& entropy = *cell.temperature->entropy;
          return entropy.soc.empty() ? std::optional(entropy.slope_V_per_K[0]) : std::nullopt;
        },
        [](Cell& cell, std::size_t, double value) {
          auto& entropy = Warmth(cell).entropy;
          if (!entropy) entropy.emplace();
          entropy->soc.clear();
          entropy->slope_V_per_K = {value};
        }},
    Row{{"gamma", "1", "a number of e-folds above 0", false, false, kInfinity},
        &Of<&Cell::hysteresis, &Cell::Hysteresis::folds>,
        &Set<&Memory, &Cell::Hysteresis::folds>},
    Row{{"M", "V", "a voltage of at least 0 V", false, true, kInfinity},
        [](const Cell& cell, std::size_t) -> std::optional<double> {
          if (!cell.hysteresis || !cell.hysteresis->soc.empty()) return std::nullopt;
          return UnlessMissing(cell.hysteresis->half_V[0]);
        },
        [](Cell& cell, std::size_t, double value) {
          Memory(cell).soc.clear();
          Memory(cell).half_V = {value};
        }},
};

std::optional<std::size_t> ParseNumber(std::string_view digits) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
  return number;
}

struct Found {
  const Row* row = nullptr;
  std::size_t branch = 0;
};

Found Find(std::string_view name) {
  for (const Row& row : kRows) {
    if (!row.kind.of_branch && row.kind.symbol == name) return {&row};
  }
  const auto bar = name.find('_');
  if (bar == std::string_view::npos) return {};
  const auto number = ParseNumber(name.substr(bar + 1));
  if (!number || *number < 1) return {};
  for (const Row& row : kRows) {
    if (row.kind.of_branch && row.kind.symbol == name.substr(0, bar)) return {&row, *number - 1};
  }
  return {};
}

// "r_s[3]" is {"r_s", 3}.
struct NodeName {
  std::string_view table;
  std::size_t index = 0;
};

std::optional<NodeName> ParseNodeName(std::string_view name) {
  const auto bracket = name.find('[');
  if (bracket == std::string_view::npos || !name.ends_with(']')) return std::nullopt;
  const auto index = ParseNumber(name.substr(bracket + 1, name.size() - bracket - 2));
  if (!index) return std::nullopt;
  return NodeName{name.substr(0, bracket), *index};
}

// The resistance that may be a table: r_s, r_1, ..., r_ct; null where the cell has none of that
// name.
template <class AnyCell>
auto* FindResistance(AnyCell& cell, std::string_view name) {
  decltype(&cell.series_resistance_Ohm) found = nullptr;
  const auto [row, branch] = Find(name);
  if (name == "r_s") {
    found = &cell.series_resistance_Ohm;
  } else if (name == "r_ct" && cell.charge_transfer) {
    found = &cell.charge_transfer->resistance_Ohm;
  } else if (row != nullptr && row->kind.symbol == "r" && branch < cell.branches.size()) {
    found = &cell.branches[branch].resistance_Ohm;
  }
  return found;
}

// The values at the nodes of a table but that of v_oc; null where the cell has no such table.
template <class AnyCell>
auto* FindValues(AnyCell& cell, std::string_view table) {
  decltype(&cell.series_resistance_Ohm.resistance_Ohm) found = nullptr;
  if (table == "M") {
    if (cell.hysteresis && !cell.hysteresis->soc.empty()) found = &cell.hysteresis->half_V;
  } else if (table == "dv_dT") {
    if (cell.temperature && cell.temperature->entropy && !cell.temperature->entropy->soc.empty())
      found = &cell.temperature->entropy->slope_V_per_K;
  } else if (auto* resistance = FindResistance(cell, table)) {
    if (!resistance->constant()) found = &resistance->resistance_Ohm;
  }
  return found;
}

// Nodes of a table of this name: none where the cell has no such table.
std::size_t CountNodes(const Cell& cell, std::string_view table) {
  if (table == "v_oc") return cell.open_circuit_voltage.voltage_V().size();
  const auto* values = FindValues(cell, table);
  return values ? values->size() : 0;
}

void Check(bool holds, std::string_view name, std::string_view expected, double value) {
  if (!holds) throw OptionError(fmt::format("{}: expected {}, found {}", name, expected, value));
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
    const CellParameterKind& kind = Find(node.table).row->kind;
    Check(kind.Holds(value), name, kind.expected, value);
    (*FindValues(cell, node.table))[node.index] = value;
    return;
  }
  Check(std::isfinite(value), name, "a finite voltage", value);
  const OpenCircuitVoltage& curve = cell.open_circuit_voltage;
  auto voltage_V = curve.voltage_V();
  voltage_V[node.index] = value;
  cell.open_circuit_voltage =
      curve.method() == OcvMethod::kLinear
          ? OpenCircuitVoltage::Linear(curve.soc(), std::move(voltage_V))
          : OpenCircuitVoltage::MonotoneCubic(curve.soc(), std::move(voltage_V));
}

}  // namespace

bool CellParameterKind::Holds(double value) const {
  if (any_sign) return std::isfinite(value);
  return std::isfinite(value) && (zero ? value >= 0.0 : value > 0.0) && value >= lower &&
         value <= upper;
}

double SeriesAndBranches(const Cell& cell, double soc) {
  double sum_Ohm = cell.series_resistance_Ohm(soc);
  for (const auto& branch : cell.branches) sum_Ohm += branch.resistance_Ohm(soc);
  return sum_Ohm;
}

double TotalResistance(const Cell& cell, double soc) {
  const double sum_Ohm = SeriesAndBranches(cell, soc);
  return cell.charge_transfer ? sum_Ohm + cell.charge_transfer->resistance_Ohm(soc) : sum_Ohm;
}

std::vector<std::string> CellResistanceNames(const Cell& cell) {
  std::vector<std::string> names{"r_s"};
  for (std::size_t j = 0; j < cell.branches.size(); ++j)
    names.push_back(fmt::format("r_{}", j + 1));
  if (cell.charge_transfer) names.emplace_back("r_ct");
  return names;
}

const Resistance<double>* CellResistance(const Cell& cell, std::string_view name) {
  return FindResistance(cell, name);
}

std::optional<CellParameterName> FindCellParameter(std::string_view name) {
  const Found found = Find(name);
  if (found.row == nullptr) return std::nullopt;
  return CellParameterName{&found.row->kind, found.branch};
}

QuantityName SplitQuantity(std::string_view quantity) {
  const std::size_t bracket = quantity.find('(');
  if (bracket == std::string_view::npos) return {std::string(quantity), std::nullopt};
  double soc = kNaN;
  std::from_chars(quantity.data() + bracket + 1, quantity.data() + quantity.size(), soc);
  return {std::string(quantity.substr(0, bracket)), soc};
}

std::vector<std::string> CellParameterNames(const Cell& cell) {
  std::vector<std::string> names;
  const auto add = [&](const Row& row, std::size_t branch, std::string name) {
    if (row.get(cell, branch)) names.push_back(std::move(name));
  };
  std::size_t branches = 0;  // those of one branch stand together
  for (const Row& row : kRows) {
    if (!row.kind.of_branch) {
      add(row, 0, std::string(row.kind.symbol));
    } else if (branches++ == 0) {
      for (std::size_t j = 0; j < cell.branches.size(); ++j) {
        for (const Row& of : kRows) {
          if (of.kind.of_branch) add(of, j, fmt::format("{}_{}", of.kind.symbol, j + 1));
        }
      }
    }
  }
  return names;
}

std::optional<double> CellParameter(const Cell& cell, std::string_view name) {
  if (const auto node = ParseNodeName(name)) {
    if (node->index >= CountNodes(cell, node->table)) return std::nullopt;
    if (node->table == "v_oc") return cell.open_circuit_voltage.voltage_V()[node->index];
    return (*FindValues(cell, node->table))[node->index];
  }
  const Found found = Find(name);
  if (found.row == nullptr) return std::nullopt;
  if (found.row->kind.of_branch && found.branch >= cell.branches.size()) return std::nullopt;
  return found.row->get(cell, found.branch);
}

void SetCellParameter(Cell& cell, std::string_view name, double value) {
  if (const auto node = ParseNodeName(name)) return SetNode(cell, name, *node, value);
  const Found found = Find(name);
  const bool of_diffusion = name == "alpha" || name == "beta";
  if (found.row == nullptr || (of_diffusion && !cell.diffusion)) {
    throw OptionError(fmt::format("'{}' is no parameter of this cell; it has {}",
                                  name,
                                  fmt::join(CellParameterNames(cell), ", ")));
  }
  const CellParameterKind& kind = found.row->kind;
  if (kind.of_branch) {
    if (found.branch == cell.branches.size() && kind.symbol == "r") {
      cell.branches.push_back(
          {.resistance_Ohm = {}, .time_constant_s = kMissing, .capacitance_F = {}});
      if (cell.temperature) cell.temperature->branches_J_per_mol.push_back(0.0);
    }
    if (found.branch >= cell.branches.size()) {
      throw OptionError(fmt::format("{}: the cell has {} branch{}; give r_{} first to add one",
                                    name,
                                    cell.branches.size(),
                                    cell.branches.size() == 1 ? "" : "es",
                                    cell.branches.size() + 1));
    }
  }
  Check(kind.Holds(value), name, kind.expected, value);
  if (kind.symbol == "c") {
    const bool constant = cell.branches[found.branch].resistance_Ohm.constant();
    Check(constant, name, "tau, beside a table of resistances", value);
  }
  found.row->set(cell, found.branch, value);
}

void SetCellParameters(Cell& cell, const std::vector<std::pair<std::string, double>>& values) {
  std::set<std::string> given;
  for (const auto& [name, value] : values) {
    if (!given.insert(name).second)
      throw OptionError(fmt::format("{} is given twice; give it once", name));
    SetCellParameter(cell, name, value);
  }
  for (std::size_t j = 1; j <= cell.branches.size(); ++j) {
    const auto c = fmt::format("c_{}", j);
    const auto tau = fmt::format("tau_{}", j);
    if (given.contains(c) && given.contains(tau)) {
      throw OptionError(
          fmt::format("give either {0} or {1}, not both: {1} = r_{2} {0}", c, tau, j));
    }
  }
  if (const auto missing = MissingCellParameter(cell)) throw OptionError(*missing);
}

std::optional<std::string> MissingCellParameter(const Cell& cell) {
  for (std::size_t j = 0; j < cell.branches.size(); ++j) {
    if (std::isnan(cell.branches[j].time_constant_s)) {
      return fmt::format("r_{0} needs c_{0} or tau_{0} beside it", j + 1);
    }
  }
  // The terms beyond the thesis have two numbers each.
  struct Pair {
    bool begun;
    std::string_view first, second;
  };
  const bool heat = cell.temperature && cell.temperature->heat;
  for (const auto& [begun, first, second] :
       {Pair{cell.self_heating.has_value(), "tau_h", "rho_h"},
        Pair{
            cell.charge_transfer && cell.charge_transfer->resistance_Ohm.constant(), "i_0", "r_ct"},
        Pair{heat, "C_th", "R_th"},
        Pair{cell.hysteresis && cell.hysteresis->soc.empty(), "gamma", "M"}}) {
    if (!begun) continue;
    const bool no_first = !CellParameter(cell, first);
    if (no_first || !CellParameter(cell, second)) {
      return fmt::format(
          "{} needs {} beside it", no_first ? second : first, no_first ? first : second);
    }
  }
  return std::nullopt;
}

std::string_view CellParameterUnit(std::string_view name) {
  const auto node = ParseNodeName(name);
  if (node && node->table == "v_oc") return "V";
  const Found found = Find(node ? node->table : name);
  Require(found.row != nullptr, "the name of a parameter");
  return found.row->kind.unit;
}

}  // namespace lipoid
