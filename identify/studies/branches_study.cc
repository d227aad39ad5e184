// How many resistor-capacitor branches do the pulses ask for? Figs 4.19-4.21, with a criterion.
//
// (4.61) is fitted with n = 0 .. 5 branches, each fit starting from the answer of the one before
// too, so that the cost never rises with n. Among them
//
//   BIC_n = N_e ln(S_n/N) + p_n ln N_e
//
// is least for the number recommended: S_n the sum of squares over N rows, p_n the free
// parameters, N_e the number of independent rows that the residuals of the richest fit are worth
// (effective_rows.h). With N instead of N_e correlated residuals would vote for branches as if
// every row were news.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "identify/studies/effective_rows.h"
#include "identify/studies/pulse_study.h"
#include "identify/studies/study.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

constexpr int kMostBranches = 5;
constexpr double kHardlyWorse = 2.0;  // of the criterion: odds of e to one, "bare mention"

// The same cell written with one branch more, which carries nothing.
SweepParameters WithIdleBranch(SweepParameters p, double time_constant_s) {
  p.resistance_Ohm.push_back(0.0);
  p.time_constant_s.push_back(time_constant_s);
  return p;
}

// What the fits minimize, over its rows: a log of twice the weight counts as two.
double MeanSquare(const PulseStudy& study, const VoltageSweep& sweep, const PulseFitResult& fit) {
  const auto& logs = sweep.logs();
  const bool alike = std::all_of(logs.begin(), logs.end(), [&](const SweepLog& log) {
    return log.weight == logs.front().weight;
  });
  if (alike) return fit.errors.rmse * fit.errors.rmse;
  const auto residuals_V = study.Residuals(sweep, fit.parameters);
  double squares = 0.0;
  double rows = 0.0;
  for (std::size_t l = 0; l < logs.size(); ++l) {
    for (const double residual_V : residuals_V[l])
      squares += logs[l].weight * residual_V * residual_V;
    rows += logs[l].weight * static_cast<double>(residuals_V[l].size());
  }
  return squares / rows;
}

// A cell with n branches is one with n+1 of which one is idle: where the search for n+1 ended above
// it, that is the better answer. The mean square of the answer.
double KeepNested(PulseFitResult& fit,
                  double mean_square,
                  const PulseFitResult& before,
                  double mean_square_before,
                  double time_constant_s) {
  if (mean_square <= mean_square_before) return mean_square;
  fit.parameters = WithIdleBranch(before.parameters, time_constant_s);
  fit.errors = before.errors;
  fit.termination = before.termination;
  fit.message = before.message;
  fit.rows_outside_curve = before.rows_outside_curve;
  fit.at_bound = before.at_bound;
  fit.at_bound.push_back(fmt::format("r_{}", fit.parameters.resistance_Ohm.size()));
  return mean_square_before;
}

}  // namespace

StudyResult StudyBranches(const StudyInput& input, const StudyProgress& progress) {
  if (input.options.pulses.branches != PulseFitOptions().branches) {
    throw OptionError(fmt::format(
        "option --branches: this study fits 0 to {} branches, one after the other; leave it out",
        kMostBranches));
  }
  if (input.given.parameters.NamesABranch()) {
    throw OptionError(fmt::format(
        "--fix, --start, --bounds: this study fits 0 to {} branches, one after the other, and no branch is in all of "
        "them; say beta or r_s, or fit with one number of branches: lipoid identify --method staged --branches N",
        kMostBranches));
  }
  progress("stages before", 0.0);
  const PulseStudy study(input);
  const auto sweep = study.Sweep(input.options.pulses.terms, input.options.pulses.tail);
  const double idle_s = std::sqrt(study.before().start.shortest_s * study.before().start.longest_s);
  std::vector<PulseFitResult> fits;
  std::vector<double> mean_square;
  for (int n = 0; n <= kMostBranches; ++n) {
    progress(fmt::format("{} branch{}", n, n == 1 ? "" : "es"), 0.1 + 0.15 * n);
    if (n == 0) {
      fits.push_back(study.Fit(sweep, n, nullptr));
      mean_square.push_back(MeanSquare(study, sweep, fits.back()));
      continue;
    }
    const auto previous = WithIdleBranch(fits.back().parameters, idle_s);
    fits.push_back(study.Fit(sweep, n, &previous));
    mean_square.push_back(KeepNested(fits.back(),
                                     MeanSquare(study, sweep, fits.back()),
                                     fits[fits.size() - 2],
                                     mean_square.back(),
                                     idle_s));
  }
  const double effective_rows = EffectiveRows(study.Residuals(sweep, fits.back().parameters));
  std::vector<double> above;  // of the criterion, above its least
  for (std::size_t n = 0; n < fits.size(); ++n)
    above.push_back(effective_rows * std::log(mean_square[n]) +
                    study.FreeParameters(fits[n]) * std::log(effective_rows));
  const auto best = std::min_element(above.begin(), above.end()) - above.begin();
  for (const double least = above[static_cast<std::size_t>(best)]; double& criterion : above)
    criterion -= least;

  StudyResult result;
  result.columns = {{"branches", "branches"},
                    {"wall_s", "time / s", 1.0, 3},
                    {"mean_error_percent", "mean / %", 1.0, 3},
                    {"max_error_percent", "max / %", 1.0, 3},
                    {"rmse_V", "rmse / mV", 1e3, 5},
                    {"free_parameters", "parameters"},
                    {"information_criterion", "BIC above least", 1.0, 4},
                    {"recommended", "recommended"},
                    {"at_bound", "at bound"}};
  std::vector<NamedFit> named;
  for (std::size_t n = 0; n < fits.size(); ++n) {
    const auto& fit = fits[n];
    named.push_back({fmt::format("{} branch{}", n, n == 1 ? "" : "es"), &fit});
    result.rows.push_back({{"branches", n},
                           {"wall_s", fit.wall_s},
                           {"mean_error_percent", fit.errors.mean_error_percent},
                           {"max_error_percent", fit.errors.max_error_percent},
                           {"rmse_V", fit.errors.rmse},
                           {"free_parameters", study.FreeParameters(fit)},
                           {"information_criterion", above[n]},
                           {"recommended", static_cast<std::ptrdiff_t>(n) == best},
                           {"termination", options_internal::ToText(fit.termination)},
                           {"at_bound", fit.at_bound},
                           {"evaluations", fit.evaluations},
                           {"parameters", study.Parameters(fit.parameters)}});
  }
  result.facts = {{"recommended_branches", best},
                  {"data_rows", fits.back().errors.rows},
                  {"effective_rows", effective_rows}};
  TellWhetherConverged(named, result);
  result.remarks.push_back(
      fmt::format("{} branch{} recommended: the least of N_e ln(S/N) + p ln N_e, where the {} rows "
                  "are worth N_e = {:.3g} independent ones",
                  best,
                  best == 1 ? " is" : "es are",
                  fits.back().errors.rows,
                  effective_rows));
  for (std::size_t n = 0; n < fits.size(); ++n) {
    if (static_cast<std::ptrdiff_t>(n) == best || above[n] >= kHardlyWorse) continue;
    result.remarks.push_back(fmt::format(
        "{} would do nearly as well ({:.3g} above): these logs hardly decide between the two",
        n,
        above[n]));
  }
  return result;
}

}  // namespace lipoid
