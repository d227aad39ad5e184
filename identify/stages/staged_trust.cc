#include "identify/stages/staged_trust.h"

#include <cmath>

#include "identify/fit/fast_modes.h"
#include "identify/fit/pulse_resistance.h"
#include "identify/trust/cell_uncertainty.h"

namespace lipoid {
TrustReport AssessStaged(const VoltageSweep& sweep,
                         const PulseFitResult& fit,
                         const std::optional<DischargeTimesResult>& times,
                         const TrustOptions& how) {
  GivenParameters known{.bounds = fit.bounds};
  for (const std::string& name : fit.fixed) known.fixed[name] = 0.0;  // no matter at what
  LinearizedFit at = Linearize(sweep, fit.solution, known);
  TrustOptions options = how;
  options.held.insert(options.held.end(), at.held.begin(), at.held.end());
  const JointSetup& setup = sweep.setup();
  const PulseQuestion question{.soc = 0.5, .current_A = setup.alpha_C / 3600.0};
  if (!how.assumed) {
    options.drawn = CellParametersAmong(at.quantities);
    auto pulses = PulseResistancesIn(at, fit.solution, setup, 1.0, question);
    FollowedMoves moves(at);
    AddFastModes(
        at,
        fit.solution,
        setup,
        1.0,
        question,
        [&](const JointSetup& finer) {
          return sweep.With(finer).Rows(fit.solution.structure, fit.solution.rates, fit.solution.x);
        },
        moves);
    moves.CountIn(at.quantities, options.drawn, pulses);
    options.drawn.insert(options.drawn.end(), pulses.begin(), pulses.end());
  }
  TrustReport report = AssessTrust(at.logs, at.penalty, at.quantities, options);
  TakePulseResistances(PulseResistancesOf(fit.solution, setup, 1.0, question), question, report);

  if (times) {
    // What the law (4.53) leaves of the times is no noise then, and does not average out over them.
    const double of_law_C =
        times->LeaveTheLaw() ? 0.01 * times->errors.mean_error_percent * times->alpha_C : 0.0;
    QuantityTrust alpha = TrustOfEstimate("alpha",
                                          "C",
                                          times->alpha_C,
                                          std::hypot(times->alpha_standard_error_C, of_law_C),
                                          times->degrees_of_freedom);
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
