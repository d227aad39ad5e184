#include "identify/stages/staged_trust.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "identify/trust/cell_uncertainty.h"
#include "identify/trust/trust_sentence.h"

namespace lipoid {
namespace {

// So many rows tell everything there is to know, in a few milliseconds.
constexpr std::size_t kMostRows = 8000;

bool Has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

TrustReport AssessStaged(const VoltageSweep& sweep,
                         const PulseFitResult& fit,
                         const std::optional<DischargeTimesResult>& times,
                         const TrustOptions& how) {
  const SweepParameters& p = fit.parameters;
  std::vector<FittedRows> rows = sweep.Means(p, kMostRows);
  const auto n = static_cast<Eigen::Index>(p.time_constant_s.size());
  const Eigen::Index columns = VoltageSweep::Columns(static_cast<int>(n));

  std::vector<TrustedQuantity> quantities;
  TrustOptions options = how;
  const auto add = [&](std::string name, std::string unit, double value, Eigen::VectorXd of) {
    TrustedQuantity q;
    q.at_bound = Has(fit.at_bound, name);
    q.name = std::move(name);
    q.unit = std::move(unit);
    q.value = value;
    q.lower = 0.0;
    q.combination = std::move(of);
    quantities.push_back(std::move(q));
  };
  const auto one =
      [&](const std::string& name, const std::string& unit, double value, Eigen::Index k) {
        if (Has(fit.fixed, name)) {
          options.held.push_back(k);
        } else {
          add(name, unit, value, Eigen::VectorXd::Unit(columns, k));
        }
      };
  if (sweep.setup().diffusion) {
    one("beta", "s^-1/2", p.beta_per_sqrt_s, 0);
    if (!quantities.empty()) quantities.back().upper = 1.0;
  } else {
    options.held.push_back(0);
  }
  one("r_s", "Ohm", p.series_resistance_Ohm, 1);
  for (Eigen::Index j = 0; j < n; ++j) {
    const auto at = static_cast<std::size_t>(j);
    const double resistance = p.resistance_Ohm[at];
    const double tau = p.time_constant_s[at];
    const Eigen::Index r_column = 2 + j;
    const Eigen::Index tau_column = 2 + n + j;
    const auto name = [&](const char* family) { return fmt::format("{}_{}", family, j + 1); };
    one(name("r"), "Ohm", resistance, r_column);
    const double capacitance = tau / resistance;
    const bool capacitance_held = Has(fit.fixed, name("c")) || Has(fit.at_bound, name("c"));
    if (capacitance_held && resistance > 0.0) {
      // tau_j = r_j c_j moves with r_j.
      for (auto& log : rows)
        log.sensitivity.col(r_column) += capacitance * log.sensitivity.col(tau_column);
      options.held.push_back(tau_column);
      if (!Has(fit.fixed, name("r")))
        add(name("tau"), "s", tau, capacitance * Eigen::VectorXd::Unit(columns, r_column));
      if (Has(fit.at_bound, name("c")))
        add(name("c"), "F", capacitance, Eigen::VectorXd::Zero(columns));
      continue;
    }
    one(name("tau"), "s", tau, tau_column);
    if (!(resistance > 0.0)) continue;  // no capacitance to speak of
    // c_j = tau_j/r_j, to first order.
    Eigen::VectorXd of = Eigen::VectorXd::Unit(columns, tau_column) / resistance;
    of[r_column] = -capacitance / resistance;
    if (Has(fit.fixed, name("tau")) && Has(fit.fixed, name("r"))) continue;
    add(name("c"), "F", capacitance, std::move(of));
  }
  if (!how.assumed) options.drawn = CellParametersAmong(quantities);
  TrustReport report = AssessTrust(rows, {}, quantities, options);

  if (times) {
    constexpr double kUnknowns = 2.0;  // alpha and the lag of (4.53)
    QuantityTrust alpha = TrustOfEstimate("alpha",
                                          "C",
                                          times->alpha_C,
                                          times->alpha_standard_error_C,
                                          static_cast<double>(times->rows.size()) - kUnknowns);
    report.quantities.insert(report.quantities.begin(), std::move(alpha));
    const Eigen::Index size = report.covariance.rows();
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(size + 1, size + 1);
    covariance.bottomRightCorner(size, size) = report.covariance;
    covariance(0, 0) = report.quantities[0].standard_error * report.quantities[0].standard_error;
    report.covariance = std::move(covariance);
    for (auto& combination : report.combinations)
      combination.weights.insert(combination.weights.begin(), 0.0);
    report.sentence = TrustSentence(report);
  }
  return report;
}

}  // namespace lipoid
