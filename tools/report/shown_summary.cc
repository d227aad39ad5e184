#include "tools/report/shown_summary.h"

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "model/statistics/quantiles.h"

namespace lipoid {
namespace {

// The cell of a summary, or those of its `cells`.
void ForEachCell(Json& summary, const std::function<void(Json&)>& act) {
  const auto of = [&](Json& result) {
    if (result.is_object() && result.contains("cell") && result["cell"].is_object())
      act(result["cell"]);
  };
  of(summary);
  if (!summary.is_object() || !summary.contains("cells") || !summary["cells"].is_array()) return;
  for (Json& each : summary["cells"]) of(each);
}

// The roots of the diagonal; null where there is none.
Json StandardErrors(const Json& covariance) {
  Json errors = Json::array();
  for (std::size_t k = 0; k < covariance.size(); ++k) {
    const Json& row = covariance[k];
    const bool there = row.is_array() && k < row.size() && row[k].is_number();
    const double variance = there ? row[k].get<double>() : -1.0;
    errors.push_back(variance >= 0.0 ? Json(std::sqrt(variance)) : Json(nullptr));
  }
  return errors;
}

void Reduce(Json& cell) {
  if (cell.contains("run") && cell["run"].is_object()) cell["run"].erase("metrics");
  if (!cell.contains("uncertainty") || !cell["uncertainty"].is_object()) return;
  Json& uncertainty = cell["uncertainty"];
  if (!uncertainty.contains("covariance") || !uncertainty["covariance"].is_array()) return;
  uncertainty["standard_errors"] = StandardErrors(uncertainty["covariance"]);
  uncertainty.erase("covariance");
  uncertainty["reach_95"] = nullptr;
  if (!uncertainty.contains("degrees_of_freedom")) return;
  const Json& freedom = uncertainty["degrees_of_freedom"];
  if (freedom.is_number() && freedom.get<double>() > 0.0)
    uncertainty["reach_95"] = Reach95(freedom.get<double>());
}

}  // namespace

Json ShownSummary(Json summary) {
  ForEachCell(summary, Reduce);
  return summary;
}

}  // namespace lipoid
