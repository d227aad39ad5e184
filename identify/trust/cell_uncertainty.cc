#include "identify/trust/cell_uncertainty.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/battery/cell_parameters.h"
#include "model/statistics/order_statistics.h"
#include "model/statistics/quantiles.h"

namespace lipoid {
namespace {

bool HasError(const QuantityTrust& q) {
  return std::isfinite(q.standard_error) && q.standard_error > 0.0 && q.degrees_of_freedom > 0.0;
}

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Grows by one parameter, which varies with no other.
void Append(Cell::Uncertainty& to, std::string name, double variance) {
  to.parameters.push_back(std::move(name));
  for (auto& row : to.covariance) row.push_back(0.0);
  to.covariance.emplace_back(to.parameters.size(), 0.0);
  to.covariance.back().back() = variance;
}

}  // namespace

double MiddleFreedom(const TrustReport& trust) {
  std::vector<double> all;
  for (const QuantityTrust& q : trust.quantities) {
    if (HasError(q) && (q.name != "alpha" || Contains(trust.drawn, "alpha")))
      all.push_back(q.degrees_of_freedom);
  }
  if (all.empty()) return 0.0;
  return UpperMedian(std::move(all));
}

std::vector<NamedCombination> CellParametersAmong(const std::vector<TrustedQuantity>& quantities) {
  std::vector<NamedCombination> parameters;
  for (const TrustedQuantity& q : quantities) {
    const auto found = FindCellParameter(q.name);
    if (!found || found->kind->symbol == "c") continue;
    parameters.push_back({q.name, q.combination, q.added_spread});
  }
  return parameters;
}

CellUncertainty UncertaintyOf(const TrustReport& trust, const Cell& cell, bool soc_follows_alpha) {
  CellUncertainty result;
  for (const QuantityTrust& q : trust.quantities) {
    if (std::isinf(q.standard_error)) result.unknown.push_back(q.name);
  }
  Cell::Uncertainty found;
  found.degrees_of_freedom = MiddleFreedom(trust);

  std::vector<Eigen::Index> kept;
  for (std::size_t k = 0; k < trust.drawn.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    const bool varies = trust.drawn_covariance(at, at) > 0.0;
    if (varies && CellParameter(cell, trust.drawn[k])) kept.push_back(at);
  }
  for (const Eigen::Index i : kept) {
    found.parameters.push_back(trust.drawn[static_cast<std::size_t>(i)]);
    auto& row = found.covariance.emplace_back();
    for (const Eigen::Index j : kept) row.push_back(trust.drawn_covariance(i, j));
  }
  for (std::size_t j = 1; j <= cell.branches.size(); ++j) {
    const std::string tau = fmt::format("tau_{}", j);
    if (Contains(found.parameters, fmt::format("r_{}", j)) && !Contains(found.parameters, tau))
      Append(found, tau, 0.0);
  }
  for (const QuantityTrust& q : trust.quantities) {
    if (q.name != "alpha" || Contains(trust.drawn, q.name) || !HasError(q)) continue;
    if (!CellParameter(cell, q.name)) continue;
    if (found.degrees_of_freedom == 0.0) found.degrees_of_freedom = q.degrees_of_freedom;
    const double error =
        q.standard_error * Reach95(q.degrees_of_freedom) / Reach95(found.degrees_of_freedom);
    Append(found, q.name, error * error);
  }
  found.soc_follows_alpha = soc_follows_alpha && Contains(found.parameters, "alpha");
  if (!found.parameters.empty() && found.degrees_of_freedom > 0.0) result.found = std::move(found);
  return result;
}

void AddPair(Cell::Uncertainty& to,
             const std::string& first,
             const std::string& second,
             double first_variance,
             double second_variance,
             double covariance) {
  if (!std::isfinite(first_variance) || !std::isfinite(second_variance) ||
      !std::isfinite(covariance) || !(first_variance > 0.0) || !(second_variance > 0.0))
    return;
  Append(to, first, first_variance);
  Append(to, second, second_variance);
  const std::size_t last = to.parameters.size() - 1;
  // No combination has a negative variance, but for rounding.
  const double most = std::sqrt(first_variance * second_variance);
  to.covariance[last][last - 1] = to.covariance[last - 1][last] =
      std::clamp(covariance, -most, most);
}

}  // namespace lipoid
