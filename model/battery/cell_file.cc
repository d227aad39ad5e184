#include "model/battery/cell_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <tuple>

#include "generated/shipped_cells.h"
#include "model/battery/cell_parameters.h"
#include "model/battery/ranges.h"
#include "model/battery/uncertain_cell.h"
#include "model/core/atomic_file.h"
#include "model/core/errors.h"
#include "model/core/json_text.h"
#include "model/core/nearest_name.h"
#include "model/core/special_values.h"

namespace lipoid {
namespace {

int Within(const JsonReader& json, const Range& range) {
  return json.Integer(static_cast<int>(range.lo), static_cast<int>(range.hi));
}

constexpr double kLeast = std::numeric_limits<double>::min();  // of what must be above 0

std::vector<double> Increasing(const JsonReader& list) {
  return list.Increasing(-kMostOfACell, kMostOfACell);
}

OpenCircuitVoltage ReadCurve(const JsonReader& json) {
  const auto method = json.At("method").Text();
  if (method == "linear" || method == "monotone-cubic") {
    json.OnlyKeys({"method", "assumed", "soc", "voltage_V"});
    const std::size_t least = method == "linear" ? 2 : 4;
    auto soc = Increasing(json.At("soc"));
    auto voltage = json.At("voltage_V").Numbers(-kMostOpenCircuit_V, kMostOpenCircuit_V);
    if (soc.size() < least) json.At("soc").Fail(fmt::format("at least {} states of charge", least));
    if (voltage.size() != soc.size())
      json.At("voltage_V").Fail(fmt::format("{} voltages", soc.size()));
    return method == "linear"
               ? OpenCircuitVoltage::Linear(std::move(soc), std::move(voltage))
               : OpenCircuitVoltage::MonotoneCubic(std::move(soc), std::move(voltage));
  }
  if (method != "polynomial" && method != "fourier") {
    json.At("method").Fail("linear, polynomial, fourier or monotone-cubic");
  }
  const auto range = Increasing(json.At("soc_range"));
  if (range.size() != 2) json.At("soc_range").Fail("two states of charge");
  if (method == "polynomial") {
    json.OnlyKeys({"method", "assumed", "soc_range", "basis", "coefficients_V"});
    if (json.At("basis").Text() != "chebyshev") json.At("basis").Fail("chebyshev");
    auto coefficients = json.At("coefficients_V").Numbers(-kMostOfACell, kMostOfACell);
    if (coefficients.empty()) json.At("coefficients_V").Fail("at least one coefficient");
    return OpenCircuitVoltage::Polynomial(range[0], range[1], std::move(coefficients));
  }
  json.OnlyKeys({"method", "assumed", "soc_range", "frequency_rad", "cosine_V", "sine_V"});
  auto cosine = json.At("cosine_V").Numbers(-kMostOfACell, kMostOfACell);
  auto sine = json.At("sine_V").Numbers(-kMostOfACell, kMostOfACell);
  if (cosine.size() != sine.size() + 1) {
    json.At("sine_V").Fail("one coefficient less than cosine_V");
  }
  return OpenCircuitVoltage::Fourier(range[0],
                                     range[1],
                                     json.At("frequency_rad").Number(0.0, kMostOfACell),
                                     std::move(cosine),
                                     std::move(sine));
}

Json CurveToJson(const OpenCircuitVoltage& curve) {
  Json json = {{"method", options_internal::ToText(curve.method())}};
  switch (curve.method()) {
    case OcvMethod::kLinear:
    case OcvMethod::kMonotoneCubic:
      json["soc"] = curve.soc();
      json["voltage_V"] = curve.voltage_V();
      break;
    case OcvMethod::kPolynomial:
      json["soc_range"] = {curve.soc_lo(), curve.soc_hi()};
      json["basis"] = "chebyshev";
      json["coefficients_V"] = curve.coefficients_V();
      break;
    case OcvMethod::kFourier:
      json["soc_range"] = {curve.soc_lo(), curve.soc_hi()};
      json["frequency_rad"] = curve.frequency_rad();
      json["cosine_V"] = curve.coefficients_V();
      json["sine_V"] = curve.sine_V();
      break;
  }
  return json;
}

// A quantity over the state of charge: one number, or a table of soc and `key`.
std::pair<std::vector<double>, std::vector<double>> ReadOverSoc(const JsonReader& json,
                                                                const char* key,
                                                                double least,
                                                                const char* values_word) {
  if (json.IsNumber()) return {{}, {json.Number(least, kMostOfACell)}};
  if (!json.IsObject()) json.Fail(fmt::format("a number or a table of soc and {}", key));
  json.OnlyKeys({"soc", key});
  auto soc = Increasing(json.At("soc"));
  auto values = json.At(key).Numbers(least, kMostOfACell);
  if (soc.empty()) json.At("soc").Fail("at least one state of charge");
  if (values.size() != soc.size()) json.At(key).Fail(fmt::format("{} {}", soc.size(), values_word));
  return {std::move(soc), std::move(values)};
}

Json OverSocToJson(const std::vector<double>& soc,
                   const char* key,
                   const std::vector<double>& values) {
  if (soc.empty()) return values[0];
  return {{"soc", soc}, {key, values}};
}

Resistance<double> ReadResistance(const JsonReader& json) {
  auto [soc, values] = ReadOverSoc(json, "resistance_Ohm", 0.0, "resistances");
  Resistance<double> resistance;
  resistance.soc = std::move(soc);
  resistance.resistance_Ohm = std::move(values);
  return resistance;
}

Json ResistanceToJson(const Resistance<double>& resistance) {
  return OverSocToJson(resistance.soc, "resistance_Ohm", resistance.resistance_Ohm);
}

Cell::Branch ReadBranch(const JsonReader& json) {
  json.OnlyKeys({"resistance_Ohm", "capacitance_F", "time_constant_s"});
  Cell::Branch branch;
  branch.resistance_Ohm = ReadResistance(json.At("resistance_Ohm"));
  const auto capacitance = json.Find("capacitance_F");
  const auto time_constant = json.Find("time_constant_s");
  if (capacitance.has_value() == time_constant.has_value()) {
    json.Fail("either capacitance_F or time_constant_s");
  }
  if (time_constant) {
    branch.time_constant_s = time_constant->Number(0.0, kMostOfACell);
  } else {
    if (!branch.resistance_Ohm.constant()) {
      capacitance->FailWith(
          "expected time_constant_s, found capacitance_F beside a table of resistances");
    }
    branch.capacitance_F = capacitance->Number(0.0, kMostCapacitance_F);
    branch.time_constant_s = branch.resistance_Ohm.resistance_Ohm[0] * *branch.capacitance_F;
  }
  return branch;
}

Cell::SelfHeating ReadSelfHeating(const JsonReader& json) {
  json.OnlyKeys({"time_constant_s", "resistance_drop_Ohm_per_A2"});
  return {.time_constant_s = json.At("time_constant_s").Number(kLeast, kMostOfACell),
          .resistance_drop_Ohm_per_A2 =
              json.At("resistance_drop_Ohm_per_A2").Number(0.0, kMostOfACell)};
}

// Of a cell whose branches are read.
Cell::Temperature ReadTemperature(const JsonReader& json, const Cell& cell) {
  json.OnlyKeys({"reference_degC",
                 "activation_energy_J_per_mol",
                 "heat_capacity_J_per_K",
                 "thermal_resistance_K_per_W",
                 "entropy",
                 "reversible_heat",
                 "shared_energies",
                 "seen_degC",
                 "assumed",
                 "heat_assumed"});
  const auto energy = [](const JsonReader& value) {
    return value.Number(kActivationEnergies_J_per_mol.lo, kActivationEnergies_J_per_mol.hi);
  };
  Cell::Temperature term;
  term.reference_K = kZeroCelsius_K +
                     json.At("reference_degC").Number(kTemperatures_degC.lo, kTemperatures_degC.hi);
  const auto energies = json.At("activation_energy_J_per_mol");
  energies.OnlyKeys({"series", "branches", "diffusion", "charge_transfer"});
  term.series_J_per_mol = energy(energies.At("series"));
  const auto branches = energies.At("branches");
  for (std::size_t j = 0; j < branches.Size(); ++j)
    term.branches_J_per_mol.push_back(energy(branches.Item(j)));
  if (branches.Size() != cell.branches.size())
    branches.Fail(fmt::format("{} energies, one for each branch", cell.branches.size()));
  // Whoever reads it sees the equal numbers; what it says is for people.
  if (const auto shared = json.Find("shared_energies")) {
    for (std::size_t k = 0; k < shared->Size(); ++k) (void)shared->Item(k).Text();
  }
  if (const auto one = energies.Find("diffusion")) term.diffusion_J_per_mol = energy(*one);
  if (const auto one = energies.Find("charge_transfer"))
    term.charge_transfer_J_per_mol = energy(*one);
  const auto capacity = json.Find("heat_capacity_J_per_K");
  const auto resistance = json.Find("thermal_resistance_K_per_W");
  if (capacity.has_value() != resistance.has_value())
    json.Fail("both or none of heat_capacity_J_per_K and thermal_resistance_K_per_W");
  if (capacity) {
    term.heat =
        HeatBalance<double>{.heat_capacity_J_per_K = capacity->Number(kLeast, kMostOfACell),
                            .thermal_resistance_K_per_W = resistance->Number(kLeast, kMostOfACell)};
  }
  if (const auto entropy = json.Find("entropy")) {
    term.entropy.emplace();
    std::tie(term.entropy->soc, term.entropy->slope_V_per_K) =
        ReadOverSoc(*entropy, "slope_V_per_K", -kMostOfACell, "slopes");
    if (const auto heat = json.Find("reversible_heat"))
      term.entropy->reversible_heat = heat->Boolean();
  }
  return term;
}

// Energies that are one number, as an identification leaves them that cannot tell them apart.
std::vector<std::string> SharedEnergies(const Cell::Temperature& term,
                                        bool diffusion,
                                        bool transfer) {
  std::vector<std::pair<std::string, double>> all;
  if (diffusion) all.emplace_back("diffusion", term.diffusion_J_per_mol);
  all.emplace_back("series", term.series_J_per_mol);
  for (std::size_t j = 0; j < term.branches_J_per_mol.size(); ++j)
    all.emplace_back(fmt::format("branches[{}]", j), term.branches_J_per_mol[j]);
  if (transfer) all.emplace_back("charge_transfer", term.charge_transfer_J_per_mol);
  std::vector<std::string> shared;
  for (const auto& [name, value] : all) {
    const double own = value;
    const auto alike = std::count_if(
        all.begin(), all.end(), [&](const auto& other) { return other.second == own; });
    if (alike > 1 && own > 0.0) shared.push_back(name);
  }
  return shared;
}

TemperatureRange ReadSeen(const JsonReader& json) {
  if (json.Size() != 2) json.Fail("two temperatures, the coldest and the warmest");
  const auto at = [&](std::size_t k) {
    return json.Item(k).Number(kTemperatures_degC.lo, kTemperatures_degC.hi);
  };
  const TemperatureRange seen{.coldest_degC = at(0), .warmest_degC = at(1)};
  if (seen.coldest_degC > seen.warmest_degC)
    json.Fail("the coldest temperature before the warmest");
  return seen;
}

Json TemperatureToJson(const Cell::Temperature& term, bool assumed, bool diffusion, bool transfer) {
  Json energies = {{"series", term.series_J_per_mol}, {"branches", term.branches_J_per_mol}};
  if (diffusion) energies["diffusion"] = term.diffusion_J_per_mol;
  if (transfer) energies["charge_transfer"] = term.charge_transfer_J_per_mol;
  Json json = {{"reference_degC", CelsiusOf(term.reference_K)},
               {"activation_energy_J_per_mol", std::move(energies)}};
  if (term.heat) {
    json["heat_capacity_J_per_K"] = term.heat->heat_capacity_J_per_K;
    json["thermal_resistance_K_per_W"] = term.heat->thermal_resistance_K_per_W;
  }
  if (term.entropy) {
    json["entropy"] =
        OverSocToJson(term.entropy->soc, "slope_V_per_K", term.entropy->slope_V_per_K);
    if (!term.entropy->reversible_heat) json["reversible_heat"] = false;
  }
  const auto shared = SharedEnergies(term, diffusion, transfer);
  if (!assumed && !shared.empty()) json["shared_energies"] = shared;
  if (assumed) json["assumed"] = true;
  return json;
}

Cell::Hysteresis ReadHysteresis(const JsonReader& json) {
  json.OnlyKeys({"folds", "half_V"});
  Cell::Hysteresis term;
  term.folds = json.At("folds").Number(kLeast, kMostOfACell);
  std::tie(term.soc, term.half_V) = ReadOverSoc(json.At("half_V"), "half_V", 0.0, "voltages");
  return term;
}

Cell::ChargeTransfer ReadChargeTransfer(const JsonReader& json) {
  json.OnlyKeys({"current_A", "resistance_Ohm"});
  return {.current_A = json.At("current_A").Number(kLeast, kMostOfACell),
          .resistance_Ohm = ReadResistance(json.At("resistance_Ohm"))};
}

// Names of parameters of the cell, each once, and no c_j beside tau_j, which says the same.
std::vector<std::string> ReadParameters(const JsonReader& list, const Cell& cell) {
  std::vector<std::string> names;
  const auto named = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  for (std::size_t k = 0; k < list.Size(); ++k) {
    const JsonReader item = list.Item(k);
    const std::string name = item.Text();
    if (!CellParameter(cell, name)) {
      item.Fail(
          fmt::format("a parameter of this cell ({}) or a node of one of its tables, counted "
                      "from 0 (r_s[0], v_oc[0])",
                      fmt::join(CellParameterNames(cell), ", ")));
    }
    if (named(name)) item.Fail("every parameter once");
    for (const auto& [symbol, other] : {std::pair{"c_", "tau_"}, std::pair{"tau_", "c_"}}) {
      if (!name.starts_with(symbol)) continue;
      const std::string twin = other + name.substr(std::string_view(symbol).size());
      if (named(twin)) item.Fail(fmt::format("no {} beside {}", name, twin));
    }
    names.push_back(name);
  }
  return names;
}

// Rows of a covariance: square, symmetric and without negative variances, but for rounding.
std::vector<std::vector<double>> ReadCovariance(const JsonReader& json,
                                                const std::vector<std::string>& names) {
  const std::size_t size = names.size();
  if (json.Size() != size) json.Fail(fmt::format("{} rows, one for each parameter", size));
  std::vector<std::vector<double>> rows;
  for (std::size_t i = 0; i < size; ++i) {
    const JsonReader row = json.Item(i);
    rows.push_back(row.Numbers(-kInfinity, kInfinity));
    if (rows[i].size() != size) row.Fail(fmt::format("{} numbers, as there are rows", size));
    const double most = names[i].starts_with("c_") ? kMostCapacitance_F : kMostOfACell;
    if (!(rows[i][i] >= 0.0 && rows[i][i] <= most * most))
      row.Item(i).Fail(fmt::format("a variance from 0 to {:g}", most * most));
    for (std::size_t j = 0; j < i; ++j) {
      const double largest = std::sqrt(rows[i][i]) * std::sqrt(rows[j][j]);
      if (!(std::abs(rows[i][j] - rows[j][i]) <= kCovarianceRounding * largest)) {
        row.Item(j).Fail(
            fmt::format("a symmetric matrix, {} as in row {} and column {}", rows[j][i], j, i));
      }
      if (!(std::abs(rows[i][j]) <= (1.0 + kCovarianceRounding) * largest)) {
        row.Item(j).Fail(fmt::format(
            "a covariance of at most {} in size, the root of both variances' product", largest));
      }
    }
  }
  const double least = LeastEigenvalue(rows);
  if (least < -kCovarianceRounding * static_cast<double>(size)) {
    json.FailWith(fmt::format(
        "expected a covariance, which gives no combination of parameters a negative variance, "
        "found one of correlations with the eigenvalue {:.3g}",
        least));
  }
  return rows;
}

// Of a cell that is read but for this.
Cell::Uncertainty ReadUncertainty(const JsonReader& json, const Cell& cell) {
  json.OnlyKeys({"parameters", "covariance", "degrees_of_freedom", "soc_follows_alpha"});
  Cell::Uncertainty uncertainty;
  uncertainty.parameters = ReadParameters(json.At("parameters"), cell);
  uncertainty.covariance = ReadCovariance(json.At("covariance"), uncertainty.parameters);
  uncertainty.degrees_of_freedom = json.At("degrees_of_freedom").Number(1.0, kMostOfACell);
  if (const auto follows = json.Find("soc_follows_alpha"))
    uncertainty.soc_follows_alpha = follows->Boolean();
  return uncertainty;
}

void RequireFinite(const Resistance<double>& resistance, std::string_view rule) {
  for (const double r : resistance.resistance_Ohm) {
    Require(std::isfinite(r), rule, {{"resistance_Ohm", r}});
  }
}

}  // namespace

Cell ParseCell(const std::string& text, const std::string& file) {
  const Json document = ParseJson(text, file);
  const JsonReader json(document, file, text);
  if (!json.IsObject()) json.Fail(fmt::format("a cell file, \"schema\": \"{}\"", kCellSchema));
  const auto schema = json.At("schema");
  if (schema.Text() != kCellSchema) schema.Fail(fmt::format("schema \"{}\"", kCellSchema));
  json.OnlyKeys({"schema",
                 "name",
                 "series",
                 "parallel",
                 "capacity_Ah",
                 "cutoff_V",
                 "diffusion",
                 "open_circuit_voltage",
                 "series_resistance_Ohm",
                 "branches",
                 "self_heating",
                 "charge_transfer",
                 "temperature",
                 "reference_degC",
                 "hysteresis",
                 "run",
                 "uncertainty"});
  Cell cell;
  cell.name = json.At("name").Text();
  if (const auto series = json.Find("series")) cell.series = Within(*series, kPackSizes);
  if (const auto parallel = json.Find("parallel")) cell.parallel = Within(*parallel, kPackSizes);
  cell.capacity_Ah = json.At("capacity_Ah").Number(kLeast, kMostOfACell);
  cell.cutoff_V = json.At("cutoff_V").Number(0.0, kMostOfACell);
  if (const auto diffusion = json.At("diffusion"); !diffusion.IsNull()) {
    diffusion.OnlyKeys({"alpha_C", "beta_per_sqrt_s", "terms", "tail"});
    cell.diffusion = Cell::Diffusion{
        .alpha_C = diffusion.At("alpha_C").Number(kLeast, kMostOfACell),
        .beta_per_sqrt_s = diffusion.At("beta_per_sqrt_s").Number(kLeastBeta_per_sqrt_s, 1.0),
        .terms = Within(diffusion.At("terms"), kModeNumbers),
        .tail = diffusion.At("tail").Boolean()};
  }
  const auto curve = json.At("open_circuit_voltage");
  cell.open_circuit_voltage = ReadCurve(curve);
  if (const auto assumed = curve.Find("assumed"))
    cell.open_circuit_voltage_assumed = assumed->Boolean();
  cell.series_resistance_Ohm = ReadResistance(json.At("series_resistance_Ohm"));
  const auto branches = json.At("branches");
  for (std::size_t j = 0; j < branches.Size(); ++j)
    cell.branches.push_back(ReadBranch(branches.Item(j)));
  if (const auto term = json.Find("self_heating")) cell.self_heating = ReadSelfHeating(*term);
  if (const auto term = json.Find("charge_transfer"))
    cell.charge_transfer = ReadChargeTransfer(*term);
  if (const auto term = json.Find("temperature")) {
    if (cell.self_heating) {
      term->FailWith(
          "expected one of temperature and self_heating, which are two laws for one thing, found "
          "both");
    }
    cell.temperature = ReadTemperature(*term, cell);
    if (const auto assumed = term->Find("assumed")) cell.temperature_assumed = assumed->Boolean();
    if (const auto assumed = term->Find("heat_assumed")) cell.heat_assumed = assumed->Boolean();
    if (const auto seen = term->Find("seen_degC")) cell.temperature_seen = ReadSeen(*seen);
  }
  if (const auto reference = json.Find("reference_degC")) {
    if (cell.temperature) {
      reference->FailWith(
          "expected no reference_degC beside temperature, which holds the one of this cell, found one");
    }
    cell.reference_degC = reference->Number(kTemperatures_degC.lo, kTemperatures_degC.hi);
  }
  if (const auto term = json.Find("hysteresis")) cell.hysteresis = ReadHysteresis(*term);
  if (const auto run = json.Find("run")) {
    if (!run->IsObject()) run->Fail("an object");
    cell.run = std::make_shared<const Json>(document.at("run"));
  }
  if (const auto uncertainty = json.Find("uncertainty"))
    cell.uncertainty = ReadUncertainty(*uncertainty, cell);
  return cell;
}

Json CellToJson(const Cell& cell) {
  Json diffusion = nullptr;
  if (cell.diffusion) {
    diffusion = {{"alpha_C", cell.diffusion->alpha_C},
                 {"beta_per_sqrt_s", cell.diffusion->beta_per_sqrt_s},
                 {"terms", cell.diffusion->terms},
                 {"tail", cell.diffusion->tail}};
  }
  Json branches = Json::array();
  for (const auto& branch : cell.branches) {
    Json one = {{"resistance_Ohm", ResistanceToJson(branch.resistance_Ohm)}};
    if (branch.capacitance_F) {
      one["capacitance_F"] = *branch.capacitance_F;
    } else {
      one["time_constant_s"] = branch.time_constant_s;
    }
    branches.push_back(std::move(one));
  }
  Json curve = CurveToJson(cell.open_circuit_voltage);
  if (cell.open_circuit_voltage_assumed) curve["assumed"] = true;
  Json json = {{"schema", kCellSchema},
               {"name", cell.name},
               {"series", cell.series},
               {"parallel", cell.parallel},
               {"capacity_Ah", cell.capacity_Ah},
               {"cutoff_V", cell.cutoff_V},
               {"diffusion", diffusion},
               {"open_circuit_voltage", curve},
               {"series_resistance_Ohm", ResistanceToJson(cell.series_resistance_Ohm)},
               {"branches", branches}};
  if (const auto& term = cell.self_heating) {
    json["self_heating"] = {{"time_constant_s", term->time_constant_s},
                            {"resistance_drop_Ohm_per_A2", term->resistance_drop_Ohm_per_A2}};
  }
  if (const auto& term = cell.charge_transfer) {
    json["charge_transfer"] = {{"current_A", term->current_A},
                               {"resistance_Ohm", ResistanceToJson(term->resistance_Ohm)}};
  }
  if (const auto& term = cell.temperature) {
    json["temperature"] = TemperatureToJson(*term,
                                            cell.temperature_assumed,
                                            cell.diffusion.has_value(),
                                            cell.charge_transfer.has_value());
    if (cell.heat_assumed) json["temperature"]["heat_assumed"] = true;
    if (const auto& seen = cell.temperature_seen)
      json["temperature"]["seen_degC"] = {seen->coldest_degC, seen->warmest_degC};
  } else if (cell.reference_degC) {
    json["reference_degC"] = *cell.reference_degC;
  }
  if (const auto& term = cell.hysteresis) {
    json["hysteresis"] = {{"folds", term->folds},
                          {"half_V", OverSocToJson(term->soc, "half_V", term->half_V)}};
  }
  json["run"] = cell.run ? *cell.run : Json::object();
  if (const auto& uncertainty = cell.uncertainty) {  // last: long, and not for people
    json["uncertainty"] = {{"parameters", uncertainty->parameters},
                           {"covariance", uncertainty->covariance},
                           {"degrees_of_freedom", uncertainty->degrees_of_freedom}};
    if (uncertainty->soc_follows_alpha) json["uncertainty"]["soc_follows_alpha"] = true;
  }
  return json;
}

void WriteCellFile(const Cell& cell, const std::string& file) {
  // JSON has no NaN: it would be written as null, and the file could not be read back.
  for (const double value : {cell.capacity_Ah,
                             cell.cutoff_V,
                             cell.alpha_C(),
                             cell.diffusion ? cell.diffusion->beta_per_sqrt_s : 0.0}) {
    Require(std::isfinite(value), "a cell of finite numbers", {{"value", value}});
  }
  RequireFinite(cell.series_resistance_Ohm, "a finite series resistance");
  for (const auto& branch : cell.branches) {
    Require(std::isfinite(branch.time_constant_s),
            "finite time constants",
            {{"time_constant_s", branch.time_constant_s}});
    RequireFinite(branch.resistance_Ohm, "finite resistances");
  }
  if (const auto& term = cell.self_heating) {
    Require(std::isfinite(term->time_constant_s) && std::isfinite(term->resistance_drop_Ohm_per_A2),
            "finite self-heating",
            {{"time_constant_s", term->time_constant_s},
             {"resistance_drop_Ohm_per_A2", term->resistance_drop_Ohm_per_A2}});
  }
  if (const auto& term = cell.charge_transfer) {
    Require(std::isfinite(term->current_A),
            "a finite current of charge transfer",
            {{"current_A", term->current_A}});
    RequireFinite(term->resistance_Ohm, "a finite resistance of charge transfer");
  }
  if (const auto& term = cell.temperature) {
    for (const double energy :
         {term->series_J_per_mol, term->diffusion_J_per_mol, term->charge_transfer_J_per_mol}) {
      Require(std::isfinite(energy), "finite activation energies", {{"energy_J_per_mol", energy}});
    }
    Require(term->branches_J_per_mol.size() == cell.branches.size(),
            "an activation energy of every branch");
  }
  if (const auto& uncertainty = cell.uncertainty) {
    Require(std::isfinite(uncertainty->degrees_of_freedom), "finite degrees of freedom");
    for (const auto& row : uncertainty->covariance) {
      for (const double entry : row)
        Require(std::isfinite(entry), "a finite covariance", {{"covariance", entry}});
    }
  }
  WriteFileAtomically(file, JsonText(CellToJson(cell)));
}

std::vector<std::string> ShippedCellNames() { return NamesOf(kShippedCells); }

std::string CellText(const std::string& name_or_file) {
  for (const auto& shipped : kShippedCells) {
    if (shipped.name == name_or_file) return std::string(shipped.text);
  }
  return ReadTextFileOr(
      name_or_file, "a cell file or one of the shipped cells", ShippedCellNames());
}

Cell LoadCell(const std::string& name_or_file) {
  return ParseCell(CellText(name_or_file), name_or_file);
}

}  // namespace lipoid
