#include "model/battery/cell_schema.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "model/battery/cell_file.h"
#include "model/battery/ranges.h"

namespace lipoid {
namespace {

Json Number() {
  return {{"type", "number"}, {"minimum", -kMostOfACell}, {"maximum", kMostOfACell}};
}
Json AtLeast(double least, double most = kMostOfACell) {
  return {{"type", "number"}, {"minimum", least}, {"maximum", most}};
}
Json Between(const Range& range) {
  return {{"type", "number"}, {"minimum", range.lo}, {"maximum", range.hi}};
}
Json Above(double bound) {
  return {{"type", "number"}, {"exclusiveMinimum", bound}, {"maximum", kMostOfACell}};
}
Json Whole(const Range& range) {
  return {{"type", "integer"},
          {"minimum", static_cast<int>(range.lo)},
          {"maximum", static_cast<int>(range.hi)}};
}
Json Boolean() { return {{"type", "boolean"}}; }
Json ListOf(Json item, int least = 0) {
  Json list = {{"type", "array"}, {"items", std::move(item)}};
  if (least > 0) list["minItems"] = least;
  return list;
}
Json Numbers(int least = 0) { return ListOf(Number(), least); }
Json Constant(const char* text) { return {{"const", text}}; }

// An object with these keys and no others; `optional` may be left out.
Json Strict(Json properties, const std::vector<std::string>& optional = {}) {
  Json required = Json::array();
  for (const auto& [key, value] : properties.items()) {
    if (std::find(optional.begin(), optional.end(), key) == optional.end()) required.push_back(key);
  }
  return {{"type", "object"},
          {"properties", std::move(properties)},
          {"required", std::move(required)},
          {"additionalProperties", false}};
}

Json Described(Json schema, const char* description) {
  schema["description"] = description;
  return schema;
}

// One number, or a table over the state of charge.
Json OverSoc(const char* key, const Json& value) {
  return {{"oneOf", {value, Strict({{"soc", Numbers(1)}, {key, ListOf(value, 1)}})}}};
}

Json Curve() {
  Json forms = Json::array();
  const Json range = {{"type", "array"}, {"items", Number()}, {"minItems", 2}, {"maxItems", 2}};
  for (const auto& [method, least] : {std::pair{"linear", 2}, std::pair{"monotone-cubic", 4}}) {
    forms.push_back(Strict({{"method", Constant(method)},
                            {"assumed", Boolean()},
                            {"soc", Numbers(least)},
                            {"voltage_V", Numbers(least)}},
                           {"assumed"}));
  }
  forms.push_back(Strict({{"method", Constant("polynomial")},
                          {"assumed", Boolean()},
                          {"soc_range", range},
                          {"basis", Constant("chebyshev")},
                          {"coefficients_V", Numbers(1)}},
                         {"assumed"}));
  forms.push_back(Strict({{"method", Constant("fourier")},
                          {"assumed", Boolean()},
                          {"soc_range", range},
                          {"frequency_rad", AtLeast(0.0)},
                          {"cosine_V", Numbers(1)},
                          {"sine_V", Numbers()}},
                         {"assumed"}));
  return {{"oneOf", std::move(forms)}};
}

}  // namespace

Json CellSchema() {
  const Json resistance = {{"$ref", "#/$defs/resistance"}};
  Json branch = Strict({{"resistance_Ohm", resistance},
                        {"capacitance_F", AtLeast(0.0, kMostCapacitance_F)},
                        {"time_constant_s", AtLeast(0.0)}},
                       {"capacitance_F", "time_constant_s"});
  branch["oneOf"] = {
      {{"required", {"capacitance_F"}}, {"properties", {{"resistance_Ohm", {{"type", "number"}}}}}},
      {{"required", {"time_constant_s"}}}};
  Json diffusion =
      Strict({{"alpha_C", Above(0.0)},
              {"beta_per_sqrt_s",
               {{"type", "number"}, {"minimum", kLeastBeta_per_sqrt_s}, {"maximum", 1.0}}},
              {"terms", Whole(kModeNumbers)},
              {"tail", Boolean()}});
  diffusion["type"] = {"object", "null"};
  Json properties = {
      {"schema", Constant(kCellSchema)},
      {"name", {{"type", "string"}}},
      {"series", Described(Whole(kPackSizes), "cells in series; 1 where it is not given")},
      {"parallel", Described(Whole(kPackSizes), "cells in parallel; 1 where it is not given")},
      {"capacity_Ah", Described(Above(0.0), "nominal capacity of one cell")},
      {"cutoff_V", Described(AtLeast(0.0), "end of discharge of one cell")},
      {"diffusion",
       Described(std::move(diffusion), "null: the state of charge follows the charge")},
      {"open_circuit_voltage", Curve()},
      {"series_resistance_Ohm", resistance},
      {"branches", ListOf(std::move(branch))},
      {"self_heating",
       Strict({{"time_constant_s", Above(0.0)}, {"resistance_drop_Ohm_per_A2", AtLeast(0.0)}})},
      {"charge_transfer", Strict({{"current_A", Above(0.0)}, {"resistance_Ohm", resistance}})},
      {"temperature",
       Strict({{"reference_degC", Between(kTemperatures_degC)},
               {"activation_energy_J_per_mol",
                Strict({{"series", Between(kActivationEnergies_J_per_mol)},
                        {"branches", ListOf(Between(kActivationEnergies_J_per_mol))},
                        {"diffusion", Between(kActivationEnergies_J_per_mol)},
                        {"charge_transfer", Between(kActivationEnergies_J_per_mol)}},
                       {"diffusion", "charge_transfer"})},
               {"heat_capacity_J_per_K", Above(0.0)},
               {"thermal_resistance_K_per_W", Above(0.0)},
               {"entropy", OverSoc("slope_V_per_K", Number())},
               {"reversible_heat", Boolean()},
               {"shared_energies",
                Described(ListOf({{"type", "string"}}),
                          "the activation energies that are one number by the identification")},
               {"seen_degC",
                Described({{"type", "array"},
                           {"items", Between(kTemperatures_degC)},
                           {"minItems", 2},
                           {"maxItems", 2}},
                          "the coldest and the warmest temperature of the logs")},
               {"assumed", Boolean()},
               {"heat_assumed", Boolean()}},
              {"heat_capacity_J_per_K",
               "thermal_resistance_K_per_W",
               "entropy",
               "reversible_heat",
               "shared_energies",
               "seen_degC",
               "assumed",
               "heat_assumed"})},
      {"reference_degC",
       Described(Between(kTemperatures_degC),
                 "the temperature of the logs of a cell that knows none; not beside temperature")},
      {"hysteresis", Strict({{"folds", Above(0.0)}, {"half_V", OverSoc("half_V", AtLeast(0.0))}})},
      {"run", Described({{"type", "object"}}, "how the cell was made")},
      {"uncertainty",
       Strict({{"parameters", ListOf({{"type", "string"}})},
               {"covariance", ListOf(ListOf({{"type", "number"}}))},
               {"degrees_of_freedom", {{"type", "number"}, {"minimum", 1.0}}},
               {"soc_follows_alpha", Boolean()}},
              {"soc_follows_alpha"})}};
  Json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                 {"$id", "urn:lipoid:cell:1"},
                 {"title", "A lithium-polymer cell as lipoid identifies it"}};
  schema.update(Strict(std::move(properties),
                       {"series",
                        "parallel",
                        "self_heating",
                        "charge_transfer",
                        "temperature",
                        "reference_degC",
                        "hysteresis",
                        "run",
                        "uncertainty"}));
  schema["$defs"] = {{"resistance", OverSoc("resistance_Ohm", AtLeast(0.0))}};
  return schema;
}

}  // namespace lipoid
