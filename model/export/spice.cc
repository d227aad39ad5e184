#include "model/export/spice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/core/errors.h"
#include "model/core/foreign_text.h"
#include "model/export/cell_numbers.h"
#include "model/export/curve_nodes.h"
#include "model/export/folded_branches.h"
#include "model/export/provenance.h"

namespace lipoid {
namespace {

// A line of SPICE holds at most this much, then a '+' continues it.
constexpr std::size_t kColumns = 96;

std::string Number(double value) { return fmt::format("{}", value); }

// Breaks at commas and blanks only, which separate everywhere in an element.
std::string Continued(const std::string& line) {
  std::string text;
  std::string row;
  std::string word;
  const auto flush = [&] {
    if (!row.empty() && row.size() + word.size() > kColumns) {
      text += row + "\n";
      row = "+";
    }
    row += word;
    word.clear();
  };
  for (const char c : line) {
    word += c;
    if (c == ',' || c == ' ') flush();
  }
  flush();
  return text + row + "\n";
}

class Circuit {
 public:
  Circuit(const CellNumbers& numbers, const Cell& cell, std::string name, bool ltspice)
      : n_(numbers), cell_(cell), name_(std::move(name)), ltspice_(ltspice) {}

  [[nodiscard]] std::string Text() {
    text_ += fmt::format(".subckt {} p n soc params: soc0=1\n", name_);
    Comment("Discharge is positive and leaves at p; i is the current of one cell.");
    Line("Vsense inside p 0");
    Comment("Charge that left, as a share of alpha.");
    Line(fmt::format("Fcharge 0 charge Vsense {}", Number(PerCell(1.0))));
    Line(fmt::format("Ccharge charge 0 {}", Number(n_.alpha_C)));
    Line("Rcharge charge 0 1e12");
    std::string start = " V(charge)=0";
    std::string soc = "{soc0} - V(charge)";
    if (!n_.rate_per_s.empty()) Comment("Charge that the modes of the diffusion hold back.");
    for (std::size_t m = 1; m <= n_.rate_per_s.size(); ++m) {
      Line(fmt::format("Fmode{0} 0 mode{0} Vsense {1}", m, Number(PerCell(1.0))));
      Line(fmt::format("Cmode{0} mode{0} 0 {1}", m, Number(0.5 * n_.alpha_C)));
      Line(fmt::format(
          "Rmode{0} mode{0} 0 {1}", m, Number(2.0 / (n_.rate_per_s[m - 1] * n_.alpha_C))));
      start += fmt::format(" V(mode{})=0", m);
      soc += fmt::format(" - V(mode{})", m);
    }
    if (n_.tail_s > 0.0)
      soc += fmt::format(" - {} * I(Vsense)", Number(PerCell(n_.tail_s / n_.alpha_C)));
    Comment("State of charge.");
    Line("Bsoc soc 0 V = " + soc);
    std::string voltage = Curve();
    for (std::size_t j = 1; j <= n_.branch.size(); ++j) {
      const Resistance<double>& ohms = n_.branch[j - 1];
      Comment("Branch.");
      if (ohms.constant()) {
        Line(fmt::format(
            "Fbranch{0} 0 branch{0} Vsense {1}", j, Number(PerCell(ohms.resistance_Ohm[0]))));
      } else {
        Line(fmt::format("Bbranch{0} 0 branch{0} I = {1} * {2}", j, Table(ohms), Current()));
      }
      Line(fmt::format("Cbranch{0} branch{0} 0 {1}", j, Number(n_.time_constant_s[j - 1])));
      Line(fmt::format("Rbranch{0} branch{0} 0 1", j));
      start += fmt::format(" V(branch{})=0", j);
      voltage += fmt::format(" - V(branch{})", j);
    }
    bool resistor = false;
    if (n_.self_heating) {
      Comment("Square of the current, low-passed: the thermal state lowers the series resistance.");
      Line(fmt::format("Bheat 0 heat I = {0} * {0}", Current()));
      Line(fmt::format("Cheat heat 0 {}", Number(n_.self_heating->time_constant_s)));
      Line("Rheat heat 0 1");
      start += " V(heat)=0";
      Comment("Series resistance of a cell, cold and warm.");
      Line("Bcold cold 0 V = " + Table(n_.series));
      Line(fmt::format("Bwarm warm 0 V = max(V(cold) - {} * V(heat), {} * V(cold))",
                       Number(n_.self_heating->resistance_drop_Ohm_per_A2),
                       Number(kLeastSeriesShare)));
      voltage += " - V(warm) * " + Current();
    } else if (!n_.series.constant()) {
      voltage += fmt::format(" - {} * {}", Table(n_.series), Current());
    } else {
      resistor = n_.series.resistance_Ohm[0] > 0.0;
    }
    if (n_.charge_transfer) {
      voltage += fmt::format(" - {} * {} * asinh({} / {})",
                             Table(n_.charge_transfer->resistance_Ohm),
                             Number(n_.charge_transfer->current_A),
                             Current(),
                             Number(n_.charge_transfer->current_A));
    }
    Comment("Terminal voltage.");
    Line(fmt::format(
        "Bcell {} n V = {} * ({})", resistor ? "source" : "inside", cell_.series, voltage));
    if (resistor) {
      Line(fmt::format("Rseries source inside {}",
                       Number(cell_.series * PerCell(n_.series.resistance_Ohm[0]))));
    }
    Comment("Relaxed at the start, whatever current flows then.");
    Line(".ic" + start);
    return text_ + ".ends " + name_ + "\n";
  }

 private:
  void Line(const std::string& line) { text_ += Continued(line); }
  void Comment(const std::string& words) { text_ += "* " + words + "\n"; }

  [[nodiscard]] double PerCell(double value) const { return value / cell_.parallel; }
  [[nodiscard]] std::string Current() const {
    return cell_.parallel == 1 ? "I(Vsense)" : fmt::format("(I(Vsense) / {})", cell_.parallel);
  }

  // Straight lines over the state of charge. What a dialect does beyond the last point differs: the
  // first and the last line are long, and no solution comes to their ends.
  [[nodiscard]] std::string Points(const std::vector<double>& x,
                                   const std::vector<double>& y) const {
    std::string points = ltspice_ ? "table(V(soc)" : "pwl(V(soc)";
    for (std::size_t k = 0; k < x.size(); ++k)
      points += fmt::format(", {}, {}", Number(x[k]), Number(y[k]));
    return points + ")";
  }
  [[nodiscard]] std::string Table(const Resistance<double>& ohms) const {
    if (ohms.resistance_Ohm.size() == 1) return Number(ohms.resistance_Ohm[0]);
    const Resistance<double> far = FarExtended(ohms);
    return Points(far.soc, far.resistance_Ohm);
  }
  [[nodiscard]] std::string Curve() const {
    const CurveNodes nodes =
        ExtendedNodesOf(StraightLines(cell_.open_circuit_voltage), kFarBeyondCurve);
    return Points(nodes.soc, nodes.voltage_V);
  }

  const CellNumbers& n_;
  const Cell& cell_;
  std::string name_;
  bool ltspice_;
  std::string text_;
};

}  // namespace

Exported ExportSpice(const ExportRequest& request) {
  const std::string version = request.target_version.empty() ? "ngspice" : request.target_version;
  if (version != "ngspice" && version != "ltspice") {
    throw OptionError(fmt::format(
        "the target spice has the versions ngspice and ltspice, found '{}'", ForeignText(version)));
  }
  const FoldedCell folded = FoldFastBranches(request.cell);
  const Cell& cell = folded.cell;
  const CellNumbers numbers = NumbersOf(cell);
  Cell in_lines = cell;
  in_lines.open_circuit_voltage = StraightLines(cell.open_circuit_voltage);

  Exported exported;
  constexpr int kStepsOfRow = 20;
  exported.error = MissionError(
      request, RunCellLaw(in_lines, request.mission, LawNumbers::kDouble, kStepsOfRow));
  exported.parameters = {{"soc0", 1.0, "1"},
                         {"Ccharge", numbers.alpha_C, "F"},
                         {"modes", static_cast<double>(numbers.rate_per_s.size()), "1"}};
  exported.notes = folded.notes;
  if (cell.open_circuit_voltage.method() != OcvMethod::kLinear) {
    exported.notes.push_back(
        fmt::format("v_oc(A) is made of {} straight lines that are off by at most {:g} V a cell.",
                    in_lines.open_circuit_voltage.soc().size() - 1,
                    kCurveTolerance_V));
  }
  for (const auto& branch : cell.branches) {
    if (branch.resistance_Ohm.constant()) continue;
    exported.notes.emplace_back(
        "lipoid's cell takes the resistance of a branch at the beginning of each row of the mission, "
        "SPICE follows it within the row: that is most of the error, and vanishes with finer rows.");
    break;
  }
  exported.notes.push_back(fmt::format(
      "The law is the cell's own{}; the error of SPICE's integration comes on top: .options "
      "reltol=1e-6 and a largest step of a tenth of a second keep it near 0.03 mV.",
      WithoutWhatNoTargetHolds(request)));
  exported.notes.emplace_back(
      "Use: X1 plus minus soc NAME soc0=1, with the state of charge as the voltage of soc against "
      "ground. The subcircuit holds its relaxed start by .ic, without uic.");
  if (version == "ltspice") {
    exported.notes.emplace_back(
        "The dialect of LTspice follows its manual (table() for ngspice's pwl()); it was not run.");
  }
  const std::string name = Identifier(request.name);
  exported.files.push_back({".lib",
                            Commented(ProvenanceLines(request, exported), "* ") +
                                Circuit(numbers, cell, name, version == "ltspice").Text()});
  return exported;
}

}  // namespace lipoid
