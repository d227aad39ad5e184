#include "model/export/cell_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <initializer_list>

#include "generated/export_runtime.h"
#include "model/core/errors.h"
#include "model/export/export_error.h"

namespace lipoid {
namespace {

// The exported C code itself, once for each type of numbers.
// NOLINTBEGIN: C99
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
namespace with_double {
#define CELL_FLOAT 0
#include "model/export/runtime/cell_law.h"
#undef CELL_FLOAT
#undef CELL_MATH
#undef CELL_ALIVE
}  // namespace with_double
namespace with_float {
#define CELL_FLOAT 1
#include "model/export/runtime/cell_law.h"
#undef CELL_FLOAT
#undef CELL_MATH
#undef CELL_ALIVE
}  // namespace with_float
#pragma GCC diagnostic pop
// NOLINTEND

void RequireFinite(std::string_view what, std::span<const double> values) {
  for (const double value : values)
    Require(std::isfinite(value), "a finite number", {{what, value}});
}

void RequireFinite(std::string_view what, const Resistance<double>& resistance) {
  Require(!resistance.resistance_Ohm.empty() &&
              (resistance.constant() || resistance.soc.size() == resistance.resistance_Ohm.size()),
          "as many resistances as states of charge");
  RequireFinite(what, resistance.soc);
  RequireFinite(what, resistance.resistance_Ohm);
}

std::vector<double> Pieces(const OpenCircuitVoltage& curve) {
  std::vector<double> pieces;
  for (const auto& piece : curve.pieces())
    pieces.insert(pieces.end(), {piece.c0, piece.c1, piece.c2, piece.c3});
  return pieces;
}

std::string TableOfC(std::string_view name, const std::vector<double>& values) {
  if (values.empty()) return "";
  std::string text = fmt::format("static const cell_real {}[{}] = {{", name, values.size());
  std::size_t column = 200;
  for (const double value : values) {
    const std::string number = fmt::format("CELL_NUMBER({}),", CNumber(value));
    if (column + number.size() > 100) {
      text += "\n   ";
      column = 3;
    }
    text += " " + number;
    column += number.size() + 1;
  }
  return text + "\n};\n";
}

std::string_view OrNull(std::string_view name, bool there) { return there ? name : "0"; }

// A resistance as an initializer, and its tables.
struct ResistanceOfC {
  std::string tables;
  std::string initializer;

  ResistanceOfC(const std::string& name, const Resistance<double>& resistance) {
    tables = TableOfC(name + "_soc", resistance.soc) +
             TableOfC(name + "_Ohm", resistance.resistance_Ohm);
    initializer = fmt::format("{{{}, {}, {}_Ohm}}",
                              resistance.resistance_Ohm.size(),
                              OrNull(name + "_soc", !resistance.constant()),
                              name);
  }
};

class Bytes {
 public:
  void Count(std::size_t count) { Number(static_cast<double>(count)); }
  void Number(double value) { text_ += NumberAsBytes(value); }
  void List(const std::vector<double>& values) {
    Count(values.size());
    for (const double value : values) Number(value);
  }
  void Ohms(const Resistance<double>& resistance) {
    List(resistance.resistance_Ohm);
    if (resistance.resistance_Ohm.size() > 1) {
      for (const double soc : resistance.soc) Number(soc);
    }
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

// The numbers as cell_law.h takes them, pointing into storage of its own type.
template <class Real, class Numbers, class Ohms>
class LawCell {
 public:
  explicit LawCell(const CellNumbers& of) {
    const auto keep = [this](const std::vector<double>& values) -> const Real* {
      if (values.empty()) return nullptr;
      auto& list = store_.emplace_back();
      for (const double value : values) list.push_back(static_cast<Real>(value));
      return list.data();
    };
    const auto ohms = [&](const Resistance<double>& r) {
      return Ohms{static_cast<int>(r.resistance_Ohm.size()), keep(r.soc), keep(r.resistance_Ohm)};
    };
    numbers_.alpha_C = static_cast<Real>(of.alpha_C);
    numbers_.tail_s = static_cast<Real>(of.tail_s);
    numbers_.modes = static_cast<int>(of.rate_per_s.size());
    numbers_.rate_per_s = keep(of.rate_per_s);
    numbers_.branches = static_cast<int>(of.branch.size());
    numbers_.time_constant_s = keep(of.time_constant_s);
    for (const auto& branch : of.branch) branch_.push_back(ohms(branch));
    numbers_.branch = branch_.data();
    numbers_.series = ohms(of.series);
    numbers_.warms = of.self_heating ? 1 : 0;
    if (of.self_heating) {
      numbers_.thermal_s = static_cast<Real>(of.self_heating->time_constant_s);
      numbers_.drop_Ohm_per_A2 = static_cast<Real>(of.self_heating->resistance_drop_Ohm_per_A2);
    }
    numbers_.least_share = static_cast<Real>(kLeastSeriesShare);
    numbers_.transfers = of.charge_transfer ? 1 : 0;
    if (of.charge_transfer) {
      numbers_.transfer_A = static_cast<Real>(of.charge_transfer->current_A);
      numbers_.transfer = ohms(of.charge_transfer->resistance_Ohm);
    }
    numbers_.curve = of.curve;
    numbers_.nodes = static_cast<int>(of.soc.size());
    numbers_.soc = keep(of.soc);
    numbers_.piece_V = keep(of.piece_V);
    numbers_.coefficients = static_cast<int>(of.cosine_V.size());
    numbers_.cosine_V = keep(of.cosine_V);
    numbers_.sine_V = keep(of.sine_V);
    numbers_.frequency_rad = static_cast<Real>(of.frequency_rad);
    for (int end = 0; end < 2; ++end) {
      numbers_.end_V[end] = static_cast<Real>(of.end_V[static_cast<std::size_t>(end)]);
      numbers_.end_slope_V[end] = static_cast<Real>(of.end_slope_V[static_cast<std::size_t>(end)]);
    }
  }

  [[nodiscard]] const Numbers* get() const { return &numbers_; }

 private:
  std::vector<std::vector<Real>> store_;
  std::vector<Ohms> branch_;
  Numbers numbers_{};
};

// Rows as RecordStepper walks them. `Law` has the functions of cell_law.h for one type of numbers.
template <class Real, class LawOfCell, class Prepare, class Advance, class Relax, class Voltage>
std::vector<double> Rows(const Cell& cell,
                         const ExportMission& mission,
                         int steps_of_row,
                         Prepare prepare,
                         Advance advance,
                         Relax relax,
                         Voltage voltage) {
  const CellNumbers numbers = NumbersOf(cell);
  const LawOfCell law(numbers);
  const std::size_t states = numbers.states();
  std::vector<Real> x(states);
  std::vector<Real> carry(states);
  std::vector<Real> loss(states);
  std::vector<Real> gain(states);
  relax(law.get(), x.data(), carry.data(), static_cast<Real>(mission.initial_soc));
  std::vector<double> voltage_V;
  double prepared_s = -1.0;
  for (std::size_t k = 0; k < mission.time_s.size(); ++k) {
    if (k > 0) {
      const double dt_s = mission.time_s[k] - mission.time_s[k - 1];
      if (dt_s != prepared_s)
        prepare(law.get(), static_cast<Real>(dt_s / steps_of_row), loss.data(), gain.data());
      prepared_s = dt_s;
      const auto flows_A = static_cast<Real>(mission.FlowBefore_A(k) / cell.parallel);
      for (int n = 0; n < steps_of_row; ++n)
        advance(law.get(), x.data(), carry.data(), loss.data(), gain.data(), flows_A);
    }
    const auto now_A = static_cast<Real>(mission.current_A[k] / cell.parallel);
    voltage_V.push_back(cell.series * double(voltage(law.get(), x.data(), now_A, Real(1))));
  }
  return voltage_V;
}

}  // namespace

CellNumbers NumbersOf(const Cell& cell) {
  const CellParameters<double> p = cell.Parameters();
  Require(p.alpha_C > 0.0 && std::isfinite(p.alpha_C), "alpha_C > 0", {{"alpha_C", p.alpha_C}});
  Require(cell.series >= 1 && cell.parallel >= 1,
          "series, parallel >= 1",
          {{"series", cell.series}, {"parallel", cell.parallel}});
  CellNumbers n;
  n.alpha_C = p.alpha_C;
  if (p.diffusion) {
    const double rate_per_s = p.beta_per_sqrt_s * p.beta_per_sqrt_s;
    Require(rate_per_s > 0.0 && std::isfinite(rate_per_s),
            "beta > 0",
            {{"beta_per_sqrt_s", p.beta_per_sqrt_s}});
    for (int m = 1; m <= p.terms; ++m) n.rate_per_s.push_back(double(m) * m * rate_per_s);
    n.tail_s = CellModel<double>(p).tail_s();
  }
  for (const auto& branch : p.branches) {
    n.time_constant_s.push_back(branch.time_constant_s);
    n.branch.push_back(branch.resistance_Ohm);
    RequireFinite("branch resistance_Ohm", branch.resistance_Ohm);
  }
  RequireFinite("branch time_constant_s", n.time_constant_s);
  n.series = p.series_resistance_Ohm;
  RequireFinite("series_resistance_Ohm", n.series);
  n.self_heating = p.self_heating;
  if (n.self_heating) {
    RequireFinite(
        "self_heating",
        std::array{n.self_heating->time_constant_s, n.self_heating->resistance_drop_Ohm_per_A2});
  }
  n.charge_transfer = p.charge_transfer;
  if (n.charge_transfer) {
    RequireFinite("charge_transfer current_A", std::array{n.charge_transfer->current_A});
    RequireFinite("charge_transfer resistance_Ohm", n.charge_transfer->resistance_Ohm);
  }
  const OpenCircuitVoltage& curve = p.open_circuit_voltage;
  n.end_V = {curve.below().value_V, curve.above().value_V};
  n.end_slope_V = {curve.below().slope_V, curve.above().slope_V};
  switch (curve.method()) {
    case OcvMethod::kLinear:
    case OcvMethod::kMonotoneCubic:
      n.curve = with_double::CELL_CURVE_PIECES;
      n.soc = curve.soc();
      n.piece_V = Pieces(curve);
      break;
    case OcvMethod::kPolynomial:
    case OcvMethod::kFourier:
      n.curve = curve.method() == OcvMethod::kFourier ? with_double::CELL_CURVE_FOURIER
                                                      : with_double::CELL_CURVE_CHEBYSHEV;
      n.soc = {curve.soc_lo(), curve.soc_hi()};
      n.cosine_V = curve.coefficients_V();
      n.sine_V = curve.sine_V();
      n.frequency_rad = curve.frequency_rad();
      break;
  }
  for (const auto& list : {n.soc, n.piece_V, n.cosine_V, n.sine_V}) {
    RequireFinite("open_circuit_voltage", list);
  }
  RequireFinite("open_circuit_voltage", n.end_V);
  RequireFinite("open_circuit_voltage", n.end_slope_V);
  return n;
}

std::string CNumber(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string NumbersAsC(const CellNumbers& n) {
  std::string text;
  text += TableOfC("cell_rate_per_s", n.rate_per_s);
  text += TableOfC("cell_time_constant_s", n.time_constant_s);
  std::string branches;
  for (std::size_t j = 0; j < n.branch.size(); ++j) {
    const ResistanceOfC branch(fmt::format("cell_branch_{}", j + 1), n.branch[j]);
    text += branch.tables;
    branches += (j > 0 ? ", " : "") + branch.initializer;
  }
  if (!branches.empty()) {
    text += fmt::format(
        "static const cell_resistance cell_branch[{}] = {{{}}};\n", n.branch.size(), branches);
  }
  const ResistanceOfC series("cell_series_resistance", n.series);
  text += series.tables;
  std::string transfer = "{0, 0, 0}";
  if (n.charge_transfer) {
    const ResistanceOfC resistance("cell_transfer", n.charge_transfer->resistance_Ohm);
    text += resistance.tables;
    transfer = resistance.initializer;
  }
  text += TableOfC("cell_soc_nodes", n.soc);
  text += TableOfC("cell_piece_V", n.piece_V);
  text += TableOfC("cell_cosine_V", n.cosine_V);
  text += TableOfC("cell_sine_V", n.sine_V);
  const auto number = [](double value) { return fmt::format("CELL_NUMBER({})", CNumber(value)); };
  const auto field = [&text](const std::string& value, std::string_view meaning) {
    text += fmt::format("    {},  // {}\n", value, meaning);
  };
  text += "static const cell_numbers cell_of_file = {\n";
  field(number(n.alpha_C), "alpha_C");
  field(number(n.tail_s), "tail_s");
  field(fmt::to_string(n.rate_per_s.size()), "modes");
  field(std::string(OrNull("cell_rate_per_s", !n.rate_per_s.empty())), "rate_per_s");
  field(fmt::to_string(n.branch.size()), "branches");
  field(std::string(OrNull("cell_time_constant_s", !n.branch.empty())), "time_constant_s");
  field(std::string(OrNull("cell_branch", !n.branch.empty())), "branch");
  field(series.initializer, "series");
  field(n.self_heating ? "1" : "0", "warms");
  field(number(n.self_heating ? n.self_heating->time_constant_s : 0.0), "thermal_s");
  field(number(n.self_heating ? n.self_heating->resistance_drop_Ohm_per_A2 : 0.0),
        "drop_Ohm_per_A2");
  field(number(kLeastSeriesShare), "least_share");
  field(n.charge_transfer ? "1" : "0", "transfers");
  field(number(n.charge_transfer ? n.charge_transfer->current_A : 0.0), "transfer_A");
  field(transfer, "transfer");
  field(fmt::to_string(n.curve), "curve");
  field(fmt::to_string(n.soc.size()), "nodes");
  field("cell_soc_nodes", "soc");
  field(std::string(OrNull("cell_piece_V", !n.piece_V.empty())), "piece_V");
  field(fmt::to_string(n.cosine_V.size()), "coefficients");
  field(std::string(OrNull("cell_cosine_V", !n.cosine_V.empty())), "cosine_V");
  field(std::string(OrNull("cell_sine_V", !n.sine_V.empty())), "sine_V");
  field(number(n.frequency_rad), "frequency_rad");
  field(fmt::format("{{{}, {}}}", number(n.end_V[0]), number(n.end_V[1])), "end_V");
  text += fmt::format(
      "    {{{}, {}}}  // end_slope_V\n}};\n", number(n.end_slope_V[0]), number(n.end_slope_V[1]));
  return text;
}

std::string NumberAsBytes(double value) {
  std::string text;
  auto bits = std::bit_cast<std::uint64_t>(value);
  for (int k = 0; k < 8; ++k, bits >>= 8) text += static_cast<char>(bits & 0xff);
  return text;
}

std::string NumbersAsBytes(const CellNumbers& n) {
  Bytes bytes;
  bytes.Number(n.alpha_C);
  bytes.Number(n.tail_s);
  bytes.List(n.rate_per_s);
  bytes.List(n.time_constant_s);
  for (const auto& branch : n.branch) bytes.Ohms(branch);
  bytes.Ohms(n.series);
  bytes.Count(n.self_heating ? 1 : 0);
  bytes.Number(n.self_heating ? n.self_heating->time_constant_s : 0.0);
  bytes.Number(n.self_heating ? n.self_heating->resistance_drop_Ohm_per_A2 : 0.0);
  bytes.Number(kLeastSeriesShare);
  bytes.Count(n.charge_transfer ? 1 : 0);
  bytes.Number(n.charge_transfer ? n.charge_transfer->current_A : 0.0);
  bytes.Ohms(n.charge_transfer ? n.charge_transfer->resistance_Ohm : Resistance<double>(0.0));
  bytes.Number(n.curve);
  bytes.List(n.soc);
  bytes.List(n.piece_V);
  bytes.List(n.cosine_V);
  bytes.List(n.sine_V);
  bytes.Number(n.frequency_rad);
  for (const double value : n.end_V) bytes.Number(value);
  for (const double value : n.end_slope_V) bytes.Number(value);
  return bytes.text();
}

std::string_view RuntimeText(std::string_view name) {
  const auto* const found = std::find_if(kExportRuntime.begin(),
                                         kExportRuntime.end(),
                                         [&](const auto& entry) { return entry.name == name; });
  Require(found != kExportRuntime.end(), "a text of model/export/runtime");
  return found->text;
}

std::string Filled(std::string_view text,
                   std::initializer_list<std::pair<std::string_view, std::string_view>> values) {
  std::string filled;
  while (!text.empty()) {
    const std::size_t at = text.find('@');
    const std::size_t end = at == text.npos ? text.npos : text.find('@', at + 1);
    if (end == text.npos) break;
    const std::string_view key = text.substr(at + 1, end - at - 1);
    const auto* const value =
        std::find_if(values.begin(), values.end(), [&](const auto& v) { return v.first == key; });
    if (value == values.end()) {  // an @ that stands for itself
      filled += text.substr(0, at + 1);
      text.remove_prefix(at + 1);
      continue;
    }
    filled += text.substr(0, at);
    filled += value->second;
    text.remove_prefix(end + 1);
  }
  filled += text;
  return filled;
}

std::string Identifier(std::string_view name) {
  constexpr std::size_t kMostLetters = 63;
  std::string text;
  for (const char c : name) {
    const bool fits = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    text += fits ? c : '_';
  }
  // The words that MATLAB lets nothing else be called by.
  constexpr std::string_view kReserved[] = {
      "break",      "case",   "catch",    "classdef", "continue", "else",      "elseif",
      "end",        "for",    "function", "global",   "if",       "otherwise", "parfor",
      "persistent", "return", "spmd",     "switch",   "try",      "while"};
  const bool letter =
      !text.empty() && ((text[0] >= 'a' && text[0] <= 'z') || (text[0] >= 'A' && text[0] <= 'Z'));
  if (!letter || std::find(std::begin(kReserved), std::end(kReserved), text) != std::end(kReserved))
    text = "cell_" + text;
  return text.substr(0, kMostLetters);
}

std::vector<double> RunCellLaw(const Cell& cell,
                               const ExportMission& mission,
                               LawNumbers numbers,
                               int steps_of_row) {
  if (numbers == LawNumbers::kFloat) {
    namespace law = with_float;
    return Rows<float, LawCell<float, law::cell_numbers, law::cell_resistance>>(cell,
                                                                                mission,
                                                                                steps_of_row,
                                                                                law::cell_prepare,
                                                                                law::cell_advance,
                                                                                law::cell_relax,
                                                                                law::cell_voltage);
  }
  namespace law = with_double;
  return Rows<double, LawCell<double, law::cell_numbers, law::cell_resistance>>(cell,
                                                                                mission,
                                                                                steps_of_row,
                                                                                law::cell_prepare,
                                                                                law::cell_advance,
                                                                                law::cell_relax,
                                                                                law::cell_voltage);
}

ExportError MissionError(const ExportRequest& request, std::span<const double> voltage_V) {
  return VoltageError(ReferenceOf(request), request.mission, voltage_V);
}

}  // namespace lipoid
