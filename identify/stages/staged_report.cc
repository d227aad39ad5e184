#include "identify/stages/staged_report.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/trust/trust_report.h"

namespace lipoid {
namespace {

Json DischargeTimesToJson(const DischargeTimesResult& stage) {
  Json logs = Json::array();
  for (const auto& row : stage.rows) {
    logs.push_back({{"file", row.file},
                    {"current_A", row.current_A},
                    {"measured_s", row.measured_s},
                    {"predicted_s", row.predicted_s},
                    {"error_percent", row.error_percent}});
  }
  return {
      {"alpha_C", NumberOrNull(stage.alpha_C)},
      {"beta_per_sqrt_s", stage.identifiable ? NumberOrNull(stage.beta_per_sqrt_s) : Json(nullptr)},
      {"alpha_standard_error_C", NumberOrNull(stage.alpha_standard_error_C)},
      {"beta_standard_error_per_sqrt_s",
       stage.identifiable ? NumberOrNull(stage.beta_standard_error_per_sqrt_s) : Json(nullptr)},
      {"identifiable", stage.identifiable},
      {"reason", stage.identifiable ? Json(nullptr) : Json(stage.reason)},
      {"beta_lower_bound_per_sqrt_s", NumberOrNull(stage.beta_lower_bound_per_sqrt_s)},
      {"beta_start_per_sqrt_s", NumberOrNull(stage.beta_start_per_sqrt_s)},
      {"mean_error_percent", NumberOrNull(stage.errors.mean_error_percent)},
      {"max_error_percent", NumberOrNull(stage.errors.max_error_percent)},
      {"rmse_s", NumberOrNull(stage.errors.rmse)},
      {"logs", logs}};
}

Json OcvToJson(const OcvFitResult& stage) {
  return {{"source", "low-rate"},
          {"method", options_internal::ToText(stage.curve.method())},
          {"mean_error_percent", NumberOrNull(stage.errors.mean_error_percent)},
          {"max_error_percent", NumberOrNull(stage.errors.max_error_percent)},
          {"rmse_V", NumberOrNull(stage.errors.rmse)},
          {"nodes", stage.curve.soc().size()},
          {"rows", stage.rows},
          {"charge_C", stage.charge_C},
          {"current_A", stage.current_A},
          {"soc_lo", stage.curve.soc_lo()},
          {"soc_hi", stage.curve.soc_hi()}};
}

Json FromRestsToJson(const OcvFromRests& stage) {
  Json rests = Json::array();
  for (const auto& rest : stage.rests) {
    rests.push_back({{"soc", rest.soc},
                     {"voltage_V", rest.voltage_V},
                     {"rest_s", rest.rest_s},
                     {"drift_V", rest.drift_V},
                     {"slope_V_per_s", rest.slope_V_per_s}});
  }
  return {{"source", "rests"},
          {"method", options_internal::ToText(stage.curve.method())},
          {"nodes", stage.curve.soc().size()},
          {"rest_count", stage.rests.size()},
          {"largest_drift_V", stage.largest_drift_V},
          {"soc_lo", stage.rests.front().soc},
          {"soc_hi", stage.rests.back().soc},
          {"guessed_to_soc", stage.guessed_to_soc ? Json(*stage.guessed_to_soc) : Json(nullptr)},
          {"half_gap_V", stage.guessed_to_soc ? Json(stage.half_gap_V) : Json(nullptr)},
          {"drop_V", stage.guessed_to_soc ? Json(stage.drop_V) : Json(nullptr)},
          {"rests", std::move(rests)}};
}

Json PulsesToJson(const PulseFitResult& stage, bool diffusion) {
  return {{"optimizer", "levenberg-marquardt"},
          {"mean_error_percent", NumberOrNull(stage.errors.mean_error_percent)},
          {"max_error_percent", NumberOrNull(stage.errors.max_error_percent)},
          {"rmse_V", NumberOrNull(stage.errors.rmse)},
          {"evaluations", stage.evaluations},
          {"termination", options_internal::ToText(stage.termination)},
          {"message", stage.message},
          {"wall_s", stage.wall_s},
          {"at_bound", stage.at_bound},
          {"fixed", stage.fixed},
          {"starts", stage.starts},
          {"rows", stage.errors.rows},
          {"rows_outside_curve", stage.rows_outside_curve},
          {"parameters", SweepParametersToJson(stage.parameters, diffusion)}};
}

}  // namespace

Json SweepParametersToJson(const SweepParameters& p, bool diffusion) {
  Json parameters = Json::object();
  if (diffusion) parameters["beta"] = p.beta_per_sqrt_s;
  parameters["r_s"] = p.series_resistance_Ohm;
  for (std::size_t j = 0; j < p.time_constant_s.size(); ++j) {
    const double r = p.resistance_Ohm[j];
    const double tau = p.time_constant_s[j];
    parameters[fmt::format("r_{}", j + 1)] = r;
    constexpr double kVanished = 1e-9;  // of r_s: an interior point never comes to 0
    const bool any = r > kVanished * p.series_resistance_Ohm;
    parameters[fmt::format("c_{}", j + 1)] = any ? Json(tau / r) : Json(nullptr);
    parameters[fmt::format("tau_{}", j + 1)] = tau;
  }
  return parameters;
}

Json LogErrorsToJson(const LogErrors& errors) {
  Json json = {
      {"file", errors.file},
      {"mean_error_percent", NumberOrNull(errors.all.mean_error_percent)},
      {"max_error_percent", NumberOrNull(errors.all.max_error_percent)},
      {"rmse_V", NumberOrNull(errors.all.rmse)},
      {"mean_error_percent_above_10_soc", NumberOrNull(errors.above_10_soc.mean_error_percent)},
      {"rmse_V_above_10_soc", NumberOrNull(errors.above_10_soc.rmse)},
      {"rows", errors.all.rows},
      {"rows_outside_curve", errors.rows_outside_curve}};
  if (std::isfinite(errors.temperature_rmse_K))
    json["temperature_rmse_K"] = errors.temperature_rmse_K;
  return json;
}

Json ConstantCurrentErrorsToJson(const ConstantCurrentErrors& errors) {
  Json json = {{"file", errors.voltage.file},
               {"current_A", errors.current_A},
               {"measured_s", errors.measured_s},
               {"predicted_s", NumberOrNull(errors.predicted_s)},
               {"error_percent", NumberOrNull(errors.error_percent)}};
  json.update(LogErrorsToJson(errors.voltage));
  return json;
}

Json StagedToJson(const StagedResult& result) {
  const bool diffusion = result.cell.diffusion.has_value();
  Json stages;
  stages["discharge_times"] =
      result.discharge_times ? DischargeTimesToJson(*result.discharge_times) : Json(nullptr);
  stages["open_circuit_voltage"] = result.open_circuit_voltage
                                       ? OcvToJson(*result.open_circuit_voltage)
                                   : result.from_rests ? FromRestsToJson(*result.from_rests)
                                                       : Json(nullptr);
  stages["pulses_beta_held"] =
      result.pulses_beta_held ? PulsesToJson(*result.pulses_beta_held, diffusion) : Json(nullptr);
  stages["pulses"] = PulsesToJson(result.pulses, diffusion);
  Json validation = Json::array();
  for (const auto& errors : result.validation) validation.push_back(LogErrorsToJson(errors));
  Json constant_current = Json::array();
  for (const auto& errors : result.constant_current)
    constant_current.push_back(ConstantCurrentErrorsToJson(errors));
  const double ratio =
      result.low_rate_charge_C > 0.0 ? result.alpha_C / result.low_rate_charge_C : std::nan("");
  Json trust = TrustToJson(result.trust);
  trust["taken_as_exact"] = {"alpha", "open_circuit_voltage"};
  return {{"method", "staged"},
          {"fitted_kind", options_internal::ToText(result.fitted_kind)},
          {"converged", result.converged},
          {"alpha_C", result.alpha_C},
          {"alpha_source", result.alpha_source},
          {"low_rate_charge_C",
           result.low_rate_charge_C > 0.0 ? Json(result.low_rate_charge_C) : Json(nullptr)},
          {"alpha_over_low_rate_charge", NumberOrNull(ratio)},
          {"low_rate_offset_V",
           result.open_circuit_voltage ? NumberOrNull(result.low_rate_offset_V) : Json(nullptr)},
          {"stages", stages},
          {"parameters", TrustedParametersToJson(result.trust)},
          {"trust", std::move(trust)},
          {"validation", validation},
          {"constant_current", constant_current},
          {"done_instead", result.done_instead},
          {"cautions", result.cautions}};
}

}  // namespace lipoid
