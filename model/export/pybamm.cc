#include "model/export/pybamm.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "model/core/errors.h"
#include "model/core/foreign_text.h"
#include "model/export/cell_numbers.h"
#include "model/export/curve_nodes.h"
#include "model/export/folded_branches.h"
#include "model/export/provenance.h"

namespace lipoid {
namespace {

std::string PythonList(const std::vector<double>& values) {
  std::string text = "[";
  std::size_t column = 1;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const std::string number = (k > 0 ? ", " : "") + CNumber(values[k]);
    if (column + number.size() > 100) {
      text += ",\n    ";
      text += CNumber(values[k]);
      column = 4 + number.size();
      continue;
    }
    text += number;
    column += number.size();
  }
  return text + "]";
}

// How the module is called that -o names, and how a program imports it.
struct ModuleName {
  std::string file;  // without .py
  std::string module;
  std::string import;
};
ModuleName NameOf(const ExportRequest& request, const std::string& name) {
  const std::string& stem = request.stem.empty() ? name : request.stem;
  for (const char* package : {"pybamm", "numpy"}) {
    if (stem != package) continue;
    throw OptionError(fmt::format(
        "option -o: {0}.py would hide the package {0} from every program of its folder; give another name",
        package));
  }
  if (stem == Identifier(stem)) return {stem, stem, "import pybamm, " + stem};
  // Between quotation marks, within a text of three of them.
  const bool quotable = std::none_of(stem.begin(), stem.end(), [](unsigned char c) {
    return c < 0x20 || c == 0x7f || c == '"' || c == '\\' || c == '@';
  });
  if (!quotable) return {name, name, "import pybamm, " + name};
  return {stem,
          name,
          fmt::format(
              "import importlib, pybamm\n    {} = importlib.import_module(\"{}\")", name, stem)};
}

class Module {
 public:
  // The name of a constant table in the module and the expression of its value at `soc`.
  std::string Ohms(const std::string& name, const Resistance<double>& resistance) {
    if (resistance.resistance_Ohm.size() == 1) return CNumber(resistance.resistance_Ohm[0]);
    // Flat beyond its ends, as the cell's tables are: Interpolant would go on with the last slope.
    const auto table = FarExtended(resistance);
    tables += fmt::format("{0}_SOC = {1}\n{0}_OHM = {2}\n",
                          name,
                          PythonList(table.soc),
                          PythonList(table.resistance_Ohm));
    std::string words = name;
    std::transform(words.begin(), words.end(), words.begin(), [](char c) {
      return c == '_' ? ' ' : static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    });
    return fmt::format("_table({0}_SOC, {0}_OHM, soc, \"{1}\")", name, words);
  }

  void Function(const std::string& name, const std::string& body) {
    functions += fmt::format("def {}(temperature_degC, current_A, soc):\n{}\n\n", name, body);
  }

  void Value(const std::string& name, const std::string& value) {
    values += fmt::format("        \"{}\": {},\n", name, value);
  }

  std::string tables;
  std::string functions;
  std::string values;
};

// What a resistance was over a mission, at which mean state of charge and with which weight.
struct Seen {
  std::vector<double> bulk;
  std::vector<double> resistance_Ohm;
  std::vector<double> weight;
};

// The table over the mean state of charge that is closest to what was seen: least squares of the
// drops. A little stiffness carries nodes that the mission passed without current.
Resistance<double> OverBulk(const Seen& seen, const Resistance<double>& otherwise) {
  constexpr std::size_t kNodes = 21;
  constexpr double kStiffness = 1e-5;
  double total = 0.0;
  double lo = std::numeric_limits<double>::infinity();
  double hi = -lo;
  for (std::size_t k = 0; k < seen.bulk.size(); ++k) {
    if (!(seen.weight[k] > 0.0)) continue;
    total += seen.weight[k];
    lo = std::min(lo, seen.bulk[k]);
    hi = std::max(hi, seen.bulk[k]);
  }
  if (!(total > 0.0)) return otherwise;  // no current, no drop
  if (!(hi - lo > 1e-6)) hi = lo + 1e-6;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(kNodes, kNodes);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(kNodes);
  const double step = (hi - lo) / (kNodes - 1);
  for (std::size_t k = 0; k < seen.bulk.size(); ++k) {
    if (!(seen.weight[k] > 0.0)) continue;
    const double at = (seen.bulk[k] - lo) / step;
    const auto below =
        static_cast<Eigen::Index>(std::clamp(std::floor(at), 0.0, double(kNodes - 2)));
    const double share = at - static_cast<double>(below);
    const double shares[2] = {1.0 - share, share};
    for (int a = 0; a < 2; ++a) {
      right(below + a) += seen.weight[k] * shares[a] * seen.resistance_Ohm[k];
      for (int b = 0; b < 2; ++b)
        normal(below + a, below + b) += seen.weight[k] * shares[a] * shares[b];
    }
  }
  for (std::size_t k = 1; k + 1 < kNodes; ++k) {
    Eigen::VectorXd bend = Eigen::VectorXd::Zero(kNodes);
    bend.segment<3>(static_cast<Eigen::Index>(k) - 1) << 1.0, -2.0, 1.0;
    normal += kStiffness * total * bend * bend.transpose();
  }
  const Eigen::VectorXd found = normal.ldlt().solve(right);
  const auto [least, most] =
      std::minmax_element(seen.resistance_Ohm.begin(), seen.resistance_Ohm.end());
  Resistance<double> table;
  table.resistance_Ohm.clear();
  for (std::size_t k = 0; k < kNodes; ++k) {
    table.soc.push_back(lo + step * static_cast<double>(k));
    table.resistance_Ohm.push_back(std::clamp(found(static_cast<Eigen::Index>(k)), *least, *most));
  }
  return table;
}

// The cell with its tables over A, and its self-heating, made tables over the mean state of charge,
// the best for this mission.
Cell ProjectedOverBulk(const Cell& cell, const ExportMission& mission) {
  const CellModel<double> model(cell.Parameters());
  RecordStepper<double> stepper(model, mission.hold, model.Relaxed(mission.initial_soc));
  Seen series;
  Seen transfer;
  std::vector<Seen> branches(cell.branches.size());
  for (std::size_t k = 0; k < mission.time_s.size(); ++k) {
    const double current_A = mission.current_A[k] / cell.parallel;
    stepper.Row(mission.time_s[k], current_A);
    const double soc = stepper.Soc();
    const double bulk = 1.0 - stepper.state().delivered_C / cell.alpha_C();
    const auto see = [&](Seen& seen, double resistance_Ohm, double drop_per_Ohm) {
      seen.bulk.push_back(bulk);
      seen.resistance_Ohm.push_back(resistance_Ohm);
      seen.weight.push_back(drop_per_Ohm * drop_per_Ohm);
    };
    see(series, model.SeriesResistance(stepper.state(), soc), current_A);
    for (std::size_t j = 0; j < branches.size(); ++j)
      see(branches[j], cell.branches[j].resistance_Ohm(soc), current_A);
    if (cell.charge_transfer) {
      const double scale_A = cell.charge_transfer->current_A;
      see(transfer,
          cell.charge_transfer->resistance_Ohm(soc),
          scale_A * std::asinh(current_A / scale_A));
    }
  }
  Cell projected = cell;
  if (cell.self_heating || !cell.series_resistance_Ohm.constant())
    projected.series_resistance_Ohm = OverBulk(series, cell.series_resistance_Ohm);
  projected.self_heating.reset();
  for (std::size_t j = 0; j < branches.size(); ++j) {
    auto& ohms = projected.branches[j].resistance_Ohm;
    if (!ohms.constant()) ohms = OverBulk(branches[j], ohms);
  }
  if (cell.charge_transfer && !cell.charge_transfer->resistance_Ohm.constant()) {
    projected.charge_transfer->resistance_Ohm =
        OverBulk(transfer, cell.charge_transfer->resistance_Ohm);
  }
  return projected;
}

}  // namespace

std::vector<double> RunPybammLaw(const Cell& cell, const ExportMission& mission, int points) {
  Require(points >= 3, "points >= 3", {{"points", static_cast<double>(points)}});
  const double alpha_C = cell.alpha_C();
  const auto cells = static_cast<std::size_t>(points);
  // The finite volumes of PyBaMM have the cosines of their middles as modes. The current enters the
  // last volume; the surface is the straight line through the last two.
  std::vector<double> rate_per_s;
  std::vector<double> drive_per_C;
  std::vector<double> at_surface;
  if (cell.diffusion) {
    const double beta = cell.diffusion->beta_per_sqrt_s;
    const double tau_s = std::numbers::pi * std::numbers::pi / (beta * beta);
    for (std::size_t m = 1; m < cells; ++m) {
      const double angle = std::numbers::pi * double(m) / points;
      const double s = std::sin(0.5 * angle);
      const double last = std::cos(angle * (points - 0.5));
      const double before = std::cos(angle * (points - 1.5));
      rate_per_s.push_back(4.0 * points * points * s * s / tau_s);
      drive_per_C.push_back(-2.0 * last / alpha_C);
      at_surface.push_back(1.5 * last - 0.5 * before);
    }
  }
  std::vector<double> mode(rate_per_s.size(), 0.0);
  std::vector<HoldCoefficients<double>> hold(rate_per_s.size());
  std::vector<double> branch_V(cell.branches.size(), 0.0);
  double bulk = mission.initial_soc;
  double prepared_s = -1.0;
  std::vector<double> voltage_V;
  for (std::size_t k = 0; k < mission.time_s.size(); ++k) {
    const double now_A = mission.current_A[k] / cell.parallel;
    if (k > 0) {
      const double dt_s = mission.time_s[k] - mission.time_s[k - 1];
      const double flows_A = mission.FlowBefore_A(k) / cell.parallel;
      if (dt_s != prepared_s) {
        for (std::size_t m = 0; m < mode.size(); ++m) hold[m] = ExactHold(rate_per_s[m], dt_s);
        prepared_s = dt_s;
      }
      for (std::size_t m = 0; m < mode.size(); ++m)
        mode[m] = hold[m].decay * mode[m] + hold[m].gain * drive_per_C[m] * flows_A;
      const double middle = bulk - 0.5 * flows_A * dt_s / alpha_C;
      for (std::size_t j = 0; j < branch_V.size(); ++j) {
        const auto rc = ExactHold(1.0 / cell.branches[j].time_constant_s, dt_s);
        branch_V[j] = rc.decay * branch_V[j] + rc.gain / cell.branches[j].time_constant_s *
                                                   cell.branches[j].resistance_Ohm(middle) *
                                                   flows_A;
      }
      bulk -= flows_A * dt_s / alpha_C;
    }
    double surface = bulk;
    for (std::size_t m = 0; m < mode.size(); ++m) surface += at_surface[m] * mode[m];
    double cell_V = cell.open_circuit_voltage(surface) - cell.series_resistance_Ohm(bulk) * now_A;
    for (const double drop_V : branch_V) cell_V -= drop_V;
    if (cell.charge_transfer) cell_V -= cell.charge_transfer->Drop(bulk, now_A);
    voltage_V.push_back(cell.series * cell_V);
  }
  return voltage_V;
}

Exported ExportPybamm(const ExportRequest& request) {
  if (!request.target_version.empty()) {
    throw OptionError(fmt::format(
        "the target pybamm has no versions: one module serves all of PyBaMM from 23.5 on, found "
        "'{}'",
        ForeignText(request.target_version)));
  }
  const FoldedCell folded = FoldFastBranches(request.cell);
  Cell cell = folded.cell;
  static_cast<void>(NumbersOf(cell));  // refuses what is no battery
  Exported exported;
  exported.notes = folded.notes;

  const bool tables = !cell.series_resistance_Ohm.constant() ||
                      std::any_of(cell.branches.begin(),
                                  cell.branches.end(),
                                  [](const auto& b) { return !b.resistance_Ohm.constant(); }) ||
                      (cell.charge_transfer && !cell.charge_transfer->resistance_Ohm.constant());
  if (cell.self_heating) {
    exported.cannot_hold.emplace_back(
        "Self-heating: the series resistance is a table over the mean state of charge that has what "
        "the heating of this mission left, by least squares of its drops.");
  }
  if (tables && cell.diffusion) {
    exported.cannot_hold.emplace_back(
        "Resistances over A, the state of charge where current enters: PyBaMM looks them up at the "
        "mean state of charge, over which they were fitted to this mission by least squares.");
  }
  if (cell.self_heating || (tables && cell.diffusion))
    cell = ProjectedOverBulk(cell, request.mission);
  if (cell.diffusion) {
    if (!cell.diffusion->tail) {
      exported.cannot_hold.push_back(fmt::format(
          "A diffusion that ends after {} modes: the element has all of them, so that its voltage is "
          "lower under load.",
          cell.diffusion->terms));
    } else if (cell.diffusion->terms < kUsualModes) {
      exported.cannot_hold.push_back(fmt::format(
          "A diffusion of {} modes whose tail follows the current at once: the element takes its time for all "
          "of them, so that its voltage is higher after a step.",
          cell.diffusion->terms));
    }
    exported.notes.push_back(fmt::format(
        "The diffusion element is the cell's own law on a mesh of {} points, which var_pts() asks "
        "for; {} falls with the square of its points. PyBaMM's "
        "default of 20 leaves millivolts.",
        kPybammPoints,
        exported.cannot_hold.empty() ? "the error is that of the mesh and"
                                     : "what the mesh adds to the error of what it cannot hold"));
  }
  exported.notes.emplace_back(
      "The law is that of one cell: divide a pack's current by PARALLEL, multiply volts by SERIES. "
      "A full cell needs model.events cleared, as make_model() does, or an initial SoC of 0.9999.");

  // PyBaMM divides by the resistance of a branch to have its capacitance: 0 becomes next to
  // nothing.
  constexpr double kLeastBranch_Ohm = 1e-9;
  for (auto& branch : cell.branches) {
    for (double& ohms : branch.resistance_Ohm.resistance_Ohm)
      ohms = std::max(ohms, kLeastBranch_Ohm);
  }

  Cell in_lines = cell;
  in_lines.open_circuit_voltage = StraightLines(cell.open_circuit_voltage);
  exported.error = MissionError(request, RunPybammLaw(in_lines, request.mission, kPybammPoints));

  Module module;
  const OpenCircuitVoltage& lines = in_lines.open_circuit_voltage;
  const CurveNodes curve = ExtendedNodesOf(lines, kFarBeyondCurve);

  const std::string series = module.Ohms("SERIES_RESISTANCE", cell.series_resistance_Ohm);
  if (cell.charge_transfer || !cell.series_resistance_Ohm.constant()) {
    std::string body;
    std::string sum = series;
    if (cell.charge_transfer) {
      const auto transfer = module.Ohms("CHARGE_TRANSFER", cell.charge_transfer->resistance_Ohm);
      // asinh(x)/x is even and 1 at 0: the root keeps x from 0 without a difference that matters.
      body += fmt::format("    x = pybamm.sqrt((current_A / {}) ** 2 + 1e-12)\n",
                          CNumber(cell.charge_transfer->current_A));
      sum += fmt::format(" + {} * pybamm.arcsinh(x) / x", transfer);
    }
    module.Function("series_resistance", body + "    return " + sum + "\n");
    module.Value("R0 [Ohm]", "series_resistance");
  } else {
    module.Value("R0 [Ohm]", series);
  }
  for (std::size_t j = 0; j < cell.branches.size(); ++j) {
    const auto& branch = cell.branches[j];
    const std::size_t n = j + 1;
    const std::string ohms = module.Ohms(fmt::format("BRANCH_{}", n), branch.resistance_Ohm);
    if (branch.resistance_Ohm.constant()) {
      module.Value(fmt::format("R{} [Ohm]", n), ohms);
      module.Value(fmt::format("C{} [F]", n),
                   CNumber(branch.time_constant_s / branch.resistance_Ohm.resistance_Ohm[0]));
    } else {
      module.Function(fmt::format("branch_{}_resistance", n), "    return " + ohms + "\n");
      module.Function(fmt::format("branch_{}_capacitance", n),
                      fmt::format("    return {} / {}\n", CNumber(branch.time_constant_s), ohms));
      module.Value(fmt::format("R{} [Ohm]", n), fmt::format("branch_{}_resistance", n));
      module.Value(fmt::format("C{} [F]", n), fmt::format("branch_{}_capacitance", n));
    }
    module.Value(fmt::format("Element-{} initial overpotential [V]", n), "0.0");
  }

  const double capacity_Ah = cell.alpha_C() / 3600.0;
  const double pi = std::numbers::pi;
  const double tau_D_s =
      cell.diffusion ? pi * pi / (cell.diffusion->beta_per_sqrt_s * cell.diffusion->beta_per_sqrt_s)
                     : 1.0;
  const double nominal_Ah = cell.capacity_Ah > 0.0 ? cell.capacity_Ah : capacity_Ah;
  exported.parameters = {{"Cell capacity [A.h]", capacity_Ah, "Ah"},
                         {"Diffusion time constant [s]", tau_D_s, "s"},
                         {"number of rc elements", static_cast<double>(cell.branches.size()), "1"}};
  if (cell.series_resistance_Ohm.constant())
    exported.parameters.push_back({"R0 [Ohm]", cell.series_resistance_Ohm(0.5), "Ohm"});

  const std::string name = Identifier(request.name);
  const ModuleName called = NameOf(request, name);
  exported.files.push_back(
      {".py",
       Filled(RuntimeText("pybamm_module.py"),
              {{"provenance", Commented(ProvenanceLines(request, exported), "# ")},
               {"doc",
                "A lithium-polymer cell for PyBaMM's Thevenin model, with its diffusion element."},
               {"file", called.file},
               {"module", called.module},
               {"import", called.import},
               {"series", fmt::to_string(cell.series)},
               {"parallel", fmt::to_string(cell.parallel)},
               {"points", fmt::to_string(kPybammPoints)},
               {"branches", fmt::to_string(cell.branches.size())},
               {"diffusion", cell.diffusion ? "true" : "false"},
               {"ocv_soc", PythonList(curve.soc)},
               {"ocv_V", PythonList(curve.voltage_V)},
               {"tables", module.tables},
               {"functions", module.functions},
               {"values", module.values},
               {"initial_soc", CNumber(request.mission.initial_soc)},
               {"capacity_Ah", CNumber(capacity_Ah)},
               {"nominal_Ah", CNumber(nominal_Ah)},
               {"upper_V", CNumber(lines(lines.soc_hi()) + 1.0)},
               {"lower_V", CNumber(cell.cutoff_V)},
               {"tau_D_s", CNumber(tau_D_s)}})});
  return exported;
}

}  // namespace lipoid
