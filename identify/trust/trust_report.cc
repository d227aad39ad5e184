#include "identify/trust/trust_report.h"

#include <nlohmann/json.hpp>

#include "model/core/options.h"

namespace lipoid {

Json TrustedParametersToJson(const TrustReport& report) {
  Json parameters = Json::array();
  for (const auto& q : report.quantities) {
    parameters.push_back({{"name", q.name},
                          {"unit", q.unit},
                          {"estimate", NumberOrNull(q.estimate)},
                          {"standard_error", NumberOrNull(q.standard_error)},
                          {"model_standard_error", NumberOrNull(q.model_standard_error)},
                          {"relative_standard_error", NumberOrNull(q.relative_standard_error)},
                          {"interval_95", {NumberOrNull(q.low), NumberOrNull(q.high)}},
                          {"verdict", options_internal::ToText(q.verdict)},
                          {"with", q.with},
                          {"degrees_of_freedom", NumberOrNull(q.degrees_of_freedom)},
                          {"white_standard_error", NumberOrNull(q.white_standard_error)}});
  }
  return parameters;
}

Json TrustToJson(const TrustReport& report) {
  Json singular_values = Json::array();
  Json combinations = Json::array();
  for (const auto& combination : report.combinations) {
    singular_values.push_back(NumberOrNull(combination.singular_value_V));
    Json weights = Json::object();
    for (std::size_t k = 0; k < combination.weights.size(); ++k) {
      if (combination.weights[k] != 0.0)
        weights[report.quantities[k].name] = NumberOrNull(combination.weights[k]);
    }
    combinations.push_back({{"singular_value_V", NumberOrNull(combination.singular_value_V)},
                            {"weights", std::move(weights)}});
  }
  Json correlation = Json::array();
  for (const auto& log : report.residual_correlation) {
    correlation.push_back({{"white_V", NumberOrNull(log.white_V)},
                           {"correlated_V", NumberOrNull(log.correlated_V)},
                           {"correlation_s", NumberOrNull(log.correlation_s)}});
  }
  Json names = Json::array();
  Json covariance = Json::array();
  for (std::size_t k = 0; k < report.quantities.size(); ++k) {
    names.push_back(report.quantities[k].name);
    Json row = Json::array();
    for (Eigen::Index j = 0; j < report.covariance.cols(); ++j)
      row.push_back(NumberOrNull(report.covariance(static_cast<Eigen::Index>(k), j)));
    covariance.push_back(std::move(row));
  }
  return {{"sentence", report.sentence},
          {"singular_values", std::move(singular_values)},
          {"combinations", std::move(combinations)},
          {"residual_correlation", std::move(correlation)},
          {"covariance", {{"names", std::move(names)}, {"rows", std::move(covariance)}}}};
}

Json PulseResistancesToJson(const TrustReport& report) {
  Json resistances = Json::array();
  for (const auto& r : report.resistance) {
    resistances.push_back(
        {{"soc", r.soc},
         {"after_s", r.after_s},
         {"current_A", r.current_A},
         {"temperature_degC", r.temperature_degC ? Json(*r.temperature_degC) : Json()},
         {"resistance_Ohm", NumberOrNull(r.resistance_Ohm)},
         {"interval_95", {NumberOrNull(r.low_Ohm), NumberOrNull(r.high_Ohm)}}});
  }
  return resistances;
}

Json ProfilesToJson(const std::vector<Profile>& profiles) {
  Json all = Json::array();
  for (const Profile& profile : profiles) {
    Json points = Json::array();
    for (const ProfilePoint& point : profile.points) {
      points.push_back({{"value", point.value},
                        {"cost", NumberOrNull(point.cost)},
                        {"rmse_V", NumberOrNull(point.rmse_V)}});
    }
    Json one = {{"name", profile.name},
                {"unit", profile.unit},
                {"estimate", NumberOrNull(profile.estimate)},
                {"points", std::move(points)},
                {"interval_95", {NumberOrNull(profile.low), NumberOrNull(profile.high)}},
                {"objective_rise_95", NumberOrNull(profile.rise_95)},
                {"objective_rise_of", profile.rise_of.empty() ? profile.name : profile.rise_of}};
    if (!profile.none_because.empty()) one["none_because"] = profile.none_because;
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace lipoid
