#include "identify/joint/held_error.h"

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "identify/joint/joint_run.h"
#include "identify/joint/joint_sweep.h"
#include "identify/joint/joint_terms.h"
#include "model/battery/uncertain_cell.h"

namespace lipoid {
namespace {

// The rates of the fit that are held as the earlier cell has them, as it has them after a move.
JointRates Moved(const JointResult& result, const HeldShape& held, const HeldShape& moved) {
  const JointSolution& best = result.choice.best;
  const std::map<std::string, double> from = held.Rates();
  const std::map<std::string, double> to = moved.Rates();
  JointRates rates = best.rates;
  for (const JointRate& rate : AllRates(
           best.structure, result.setup, JointObservations(result.logs, result.setup).scales())) {
    const auto at = from.find(rate.name);
    if (at != from.end() && rate.In(rates) == at->second) rate.In(rates) = to.at(rate.name);
  }
  return rates;
}

}  // namespace

void AddHeldError(const JointResult& result, const PulseQuestion& question, FollowedMoves& moves) {
  const JointSolution& best = result.choice.best;
  const HeldShape* held = result.setup.held.get();
  if (held == nullptr || !held->cell.uncertainty || best.x.size() == 0) return;
  HeldShape around = *held;
  const std::map<std::string, double> rates = held->Rates();
  around.cell.uncertainty = UncertaintyAmong(held->cell, [&](const std::string& name) {
    return name == "alpha" || name.starts_with("v_oc[") || rates.contains(name);
  });
  if (around.cell.uncertainty->parameters.empty()) return;
  const UncertainCell uncertain(around.cell);
  constexpr double kOfNote = 1e-3;  // of a single parameter's variance
  const Eigen::MatrixXd principal = PrincipalMoves(uncertain, kOfNote);

  const double typical_A = result.logs.typical_A;
  const auto found_Ohm = PulseResistancesOf(best, result.setup, typical_A, question);
  for (Eigen::Index m = 0; m < principal.cols(); ++m) {
    Eigen::VectorXd at = uncertain.estimate() + principal.col(m);
    uncertain.MoveIntoRange(at);
    HeldShape moved = *held;
    moved.cell = uncertain.At(at);
    JointSetup setup = result.setup;
    setup.open_circuit_voltage = moved.cell.open_circuit_voltage;
    JointSolution with = best;
    with.rates = Moved(result, *held, moved);
    auto moved_Ohm = PulseResistancesOf(with, setup, typical_A, question);
    for (std::size_t k = 0; k < moved_Ohm.size(); ++k) moved_Ohm[k] -= found_Ohm[k];
    moves.Add(JointObservations(result.logs, setup).Rows(with.structure, with.rates, with.x),
              moved_Ohm);
  }
}

}  // namespace lipoid
