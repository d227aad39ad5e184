#include "identify/joint/joint_report.h"

#include <nlohmann/json.hpp>

#include "identify/stages/staged_report.h"
#include "identify/trust/trust_report.h"

namespace lipoid {
namespace {

void AddTerms(const JointStructure& structure, Json& json) {
  for (const JointTerm& term : JointTerms()) json[std::string(term.key)] = term.present(structure);
}

Json TriedToJson(const TriedStructure& row) {
  const JointStructure& s = row.solution.structure;
  Json json = {{"what", row.what},
               {"branches", s.branches},
               {"resistance_nodes", s.nodes()},
               {"voltage_nodes", s.voltage_soc.size()}};
  AddTerms(s, json);
  json.update({{"smoothness", row.errors.smoothness},
               {"fitted_V", NumberOrNull(row.errors.fitted_V)},
               {"left_out_V", NumberOrNull(row.errors.left_out_V)},
               {"expected_V", NumberOrNull(row.errors.expected_V)},
               {"gain_V", NumberOrNull(row.gain.gain)},
               {"gain_standard_error_V", NumberOrNull(row.gain.standard_error)},
               {"weight", row.weight},
               {"beta_per_sqrt_s", NumberOrNull(row.solution.rates.beta_per_sqrt_s)},
               {"time_constants_s", row.solution.rates.time_constant_s},
               {"taken", row.taken}});
  return json;
}

}  // namespace

Json JointToJson(const JointResult& result, const TrustReport& trust) {
  Json staged = StagedToJson(result.staged);
  Json tried = Json::array();
  for (const auto& row : result.choice.tried) tried.push_back(TriedToJson(row));
  Json logs = Json::array();
  for (std::size_t l = 0; l < result.fitted.size(); ++l) {
    Json log = LogErrorsToJson(result.fitted[l]);
    log["staged"] = LogErrorsToJson(result.fitted_staged[l]);
    log["staged"].erase("file");
    logs.push_back(std::move(log));
  }
  Json validation = Json::array();
  for (const auto& errors : result.validation) validation.push_back(LogErrorsToJson(errors));
  Json constant_current = Json::array();
  for (const auto& errors : result.constant_current)
    constant_current.push_back(ConstantCurrentErrorsToJson(errors));
  const JointSolution& best = result.choice.best;
  Json heat = nullptr;
  if (const auto& found = result.heat) {
    heat = {{"heat_capacity_J_per_K", found->balance.heat_capacity_J_per_K},
            {"heat_capacity_standard_error_J_per_K",
             NumberOrNull(found->heat_capacity_standard_error_J_per_K)},
            {"thermal_resistance_K_per_W", found->balance.thermal_resistance_K_per_W},
            {"thermal_resistance_standard_error_K_per_W",
             NumberOrNull(found->thermal_resistance_standard_error_K_per_W)},
            {"rmse_K", found->rmse_K},
            {"reversible", found->reversible},
            {"rmse_reversible_K", NumberOrNull(found->rmse_reversible_K)},
            {"largest_rise_K", found->largest_rise_K},
            {"logs", found->logs}};
  }
  Json joint = {{"rmse_V", result.rmse_V},
                {"evaluations", result.evaluations},
                {"termination", options_internal::ToText(best.termination)},
                {"message", best.message},
                {"wall_s", result.wall_s},
                {"branches", best.structure.branches},
                {"resistance_nodes", best.structure.nodes()},
                {"voltage_nodes", best.structure.voltage_soc.size()}};
  AddTerms(best.structure, joint);
  joint["shared_energies"] = SharedEnergyNames(best.structure, result.setup.diffusion);
  joint.update({{"smoothness", best.smoothness}, {"at_bound", best.at_bound}, {"tried", tried}});
  if (best.structure.current_offset) joint["current_offset_A"] = best.rates.current_offset_A;
  if (const auto& held = result.setup.held) {
    joint["reference"] = {{"file", held->source}, {"held", held->Names()}};
    if (const auto& move = result.held_curve) {
      joint["reference"]["curve"] = {{"rmse_V", move->rmse_V},
                                     {"corrected_rmse_V", move->corrected_rmse_V},
                                     {"largest_V", move->largest_V},
                                     {"soc", move->soc},
                                     {"doubted", move->doubted()}};
    }
  }
  Json report = {{"method", "joint"},
                 {"converged", result.converged},
                 {"alpha_C", result.alpha_C},
                 {"alpha_source", result.alpha_source},
                 {"low_rate_charge_C", staged["low_rate_charge_C"]},
                 {"joint", joint},
                 {"parameters", TrustedParametersToJson(trust)},
                 {"trust", TrustToJson(trust)},
                 {"logs", logs},
                 {"constant_current", constant_current},
                 {"validation", validation},
                 {"cautions", result.cautions},
                 {"done_instead", staged["done_instead"]},
                 {"stages", staged["stages"]},
                 {"staged", staged}};
  if (!heat.is_null()) report["joint"]["heat"] = std::move(heat);
  return report;
}

}  // namespace lipoid
