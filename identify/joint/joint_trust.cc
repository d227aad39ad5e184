#include "identify/joint/joint_trust.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "identify/fit/fast_modes.h"
#include "identify/fit/pulse_resistance.h"
#include "identify/joint/held_error.h"
#include "identify/joint/joint_drawn.h"
#include "identify/joint/structure_spread.h"

namespace lipoid {
namespace {

// Standard deviations of a counted charge, below which alpha cannot be.
constexpr double kFarthestCount = 3.0;

// alpha' = alpha (A_s - A_0)/A_s, A_0 where the line through two nodes is the cut-off and A_s where
// the logs start.
TrustedQuantity Alpha(const JointResult& result, const LinearizedFit& fit) {
  const CutoffPoint& cutoff = result.cutoff;
  TrustedQuantity q = fit.Quantity("alpha", "C", result.alpha_C);
  // Of nodes; of rises the suffix sums of these.
  const double per_soc_C = -result.setup.alpha_C / result.start_soc;
  const double of_lower = per_soc_C * cutoff.per_lower_V;
  const double of_upper = per_soc_C * cutoff.per_upper_V;
  q.lower = std::min(result.least_alpha_C - kFarthestCount * result.counting_C, q.value);
  for (std::size_t k = 0; k <= cutoff.upper; ++k) {
    q.combination[fit.Linear(static_cast<int>(k))] =
        of_upper + (k <= cutoff.lower ? of_lower : 0.0);
  }
  // A curve that lies higher there reaches the cut-off later.
  q.added_spread = SpreadOverStructures(result.choice, [&](const JointSolution& solution) {
    return (of_lower + of_upper) *
           OpenCircuitVoltageIn(solution, result.setup.open_circuit_voltage, cutoff.soc);
  });
  // Below the last row v_oc(A) falls faster than its last slope, nobody knows how much: over the tenth of the charge
  // in which it bends, what that slope adds is not known to better than itself.
  constexpr double kBend = 0.1;
  constexpr double kMostShare = 0.5;
  const auto add = [&q](double deviation) {
    q.added_spread.conservativeResize(q.added_spread.size() + 1);
    q.added_spread[q.added_spread.size() - 1] = deviation;
  };
  if (cutoff.extrapolated) {
    const double beyond = result.choice.best.structure.voltage_soc[cutoff.lower] - cutoff.soc;
    add(std::max(0.0, -per_soc_C * beyond * std::min(kMostShare, beyond / kBend)));
  }
  if (result.counting_C > 0.0) add(result.counting_C);
  return q;
}

// Of rests: no row of the fit tells it, for which alpha was held.
TrustedQuantity AlphaByRests(const JointResult& result, const LinearizedFit& fit) {
  TrustedQuantity q = fit.Quantity("alpha", "C", result.alpha_C);
  q.lower = std::min(result.least_alpha_C, q.value);
  q.from_elsewhere = true;
  q.added_spread = Eigen::VectorXd::Constant(1, result.alpha_of_rests->error_C);
  return q;
}

// What a small steady current sees at half charge: often known where its parts are not.
TrustedQuantity Total(const JointResult& result, const LinearizedFit& fit) {
  const JointSolution& best = result.choice.best;
  const JointLayout layout(best.structure);
  const auto& nodes = best.structure.resistance_soc;
  const double per_A = 1.0 / result.logs.typical_A;
  const NodeShare at = NodeFinder(nodes)(result.Axis()(0.5));
  TrustedQuantity q = fit.Quantity("r_total(0.5)", "Ohm", 0.0);
  for (int t = 0; t < layout.tables(); ++t) {
    const int k = layout.table(t) + at.lower;
    q.combination[fit.Linear(k)] += (1.0 - at.share) * per_A;
    if (nodes.size() > 1) q.combination[fit.Linear(k + 1)] += at.share * per_A;
    q.value += (1.0 - at.share) * best.x[k] * per_A;
    if (nodes.size() > 1) q.value += at.share * best.x[k + 1] * per_A;
  }
  return q;
}

// Half charge on the axis of the fit, and 1C, of so many times the alpha that was found.
PulseQuestion AtHalfCharge(const JointResult& result, double alphas) {
  constexpr double kHalf = 0.5;
  FitAxis axis = result.Axis();
  axis.alpha_ratio *= alphas;
  PulseQuestion question{.soc = axis(kHalf), .current_A = alphas * result.alpha_C / 3600.0};
  if (result.choice.best.structure.temperature)
    question.temperature_degC = CelsiusOf(result.logs.told_K);
  return question;
}

// Standard deviations of the resistances at half charge that the fit does not know: half of an alpha that
// follows the fit is another place on its axis.
std::vector<double> ByAlpha(const JointResult& result, const TrustReport& report) {
  const QuantityTrust* alpha = FindQuantity(report, "alpha");
  if (alpha == nullptr || result.setup.axis_follows_alpha) return {};
  constexpr double kFarthest = 0.5;
  const double share = std::min(alpha->relative_standard_error, kFarthest);
  if (!(share > 0.0)) return {};
  const auto at = [&](double alphas) {
    return PulseResistancesOf(
        result.choice.best, result.setup, result.logs.typical_A, AtHalfCharge(result, alphas));
  };
  std::vector<double> moved_Ohm = at(1.0 + share);
  const std::vector<double> back_Ohm = at(1.0 - share);
  for (std::size_t k = 0; k < moved_Ohm.size(); ++k)
    moved_Ohm[k] = 0.5 * std::abs(moved_Ohm[k] - back_Ohm[k]);
  return moved_Ohm;
}

}  // namespace

TrustReport AssessJoint(const JointResult& result, const TrustOptions& options) {
  const JointSolution& best = result.choice.best;
  const JointObservations seen(result.logs, result.setup);
  const LinearizedFit fit =
      Linearize(seen, best, {.fixed = result.fixed, .bounds = result.bounds}, result.Axis());
  std::vector<TrustedQuantity> quantities = fit.quantities;
  if (JointLayout(best.structure).tables() > 1) quantities.push_back(Total(result, fit));
  for (TrustedQuantity& q : quantities) {
    q.added_spread = SpreadOverStructures(result.choice, [&](const JointSolution& solution) {
      return ValueIn(solution, q.name, result.logs.typical_A, best, result.Axis());
    });
  }
  if (result.cutoff.found) quantities.insert(quantities.begin(), Alpha(result, fit));
  if (result.alpha_of_rests) quantities.insert(quantities.begin(), AlphaByRests(result, fit));
  TrustOptions with_held = options;
  with_held.held.insert(with_held.held.end(), fit.held.begin(), fit.held.end());
  // Nobody draws cells from what is only planned.
  if (!options.assumed) with_held.drawn = DrawnOfJoint(result, quantities, fit.Linear(0));

  const PulseQuestion question = AtHalfCharge(result, 1.0);
  const auto resistances = [&](const JointSolution& solution) {
    return PulseResistancesOf(solution, result.setup, result.logs.typical_A, question);
  };
  auto pulses = PulseResistancesIn(fit, best, result.setup, result.logs.typical_A, question);
  for (std::size_t k = 0; k < pulses.size(); ++k) {
    pulses[k].added_spread =
        SpreadOverStructures(result.choice, [&](const auto& in) { return resistances(in)[k]; });
  }
  FollowedMoves moves(fit);
  AddHeldError(result, question, moves);
  AddFastModes(
      fit,
      best,
      result.setup,
      result.logs.typical_A,
      question,
      [&](const JointSetup& finer) {
        return JointObservations(result.logs, finer).Rows(best.structure, best.rates, best.x);
      },
      moves);
  moves.CountIn(quantities, with_held.drawn, pulses);
  with_held.drawn.insert(with_held.drawn.end(), pulses.begin(), pulses.end());
  TrustReport report = AssessTrust(fit.logs, fit.penalty, quantities, with_held);
  TakePulseResistances(resistances(best), question, report, ByAlpha(result, report));
  return report;
}

}  // namespace lipoid
