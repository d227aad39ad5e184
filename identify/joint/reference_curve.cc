#include "identify/joint/reference_curve.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "identify/fit/linearized_fit.h"
#include "identify/joint/joint_run.h"

namespace lipoid {
namespace {

constexpr double kNodeSpacing = 0.1;
// Of the information that a node has by itself: a correction that alpha can stand in for stays small.
constexpr double kRidge = 1e-3;
// The correction leaves at most half of the error, a quarter of its square. Of cells whose curve had moved by
// 70 mV it left a third, of five ages of one cell between 0.65 and 0.95 (docs/joint.md, 10).
constexpr double kMostLeft = 0.5;
// What it takes away is worth a word: it moves a state of charge by a hundredth where v_oc is flat.
constexpr double kWorthSaying_V = 0.005;
// Logs that need another curve further beyond empty or full have a wrong alpha, and no curve mends that.
constexpr double kBeyond = kNodeSpacing;

// From the least to the largest state of charge of the rows that count.
std::vector<double> CorrectionNodes(const SocTrace& soc) {
  const double span = soc.highest - soc.lowest;
  const int pieces = std::max(1, static_cast<int>(std::lround(span / kNodeSpacing)));
  std::vector<double> nodes;
  for (int k = 0; k <= pieces; ++k) nodes.push_back(soc.lowest + span * k / pieces);
  return nodes;
}

// The rows of one log: their sensitivities, then the share of each node.
Eigen::MatrixXd WithCorrection(const FittedRows& rows,
                               const JointLog& log,
                               const LogTrace& soc,
                               const std::vector<double>& nodes) {
  const Eigen::Index p = rows.sensitivity.cols();
  Eigen::MatrixXd all =
      Eigen::MatrixXd::Zero(rows.sensitivity.rows(), p + static_cast<Eigen::Index>(nodes.size()));
  all.leftCols(p) = rows.sensitivity;
  NodeFinder find(nodes);
  Eigen::Index row = 0;
  for (std::size_t k = 0; k < log.size(); ++k) {
    if (!(log.weight[k] > 0.0)) continue;  // no row of the fit
    const NodeShare at = find(soc.at[k]);
    all(row, p + at.lower) = 1.0 - at.share;
    all(row, p + at.lower + 1) = at.share;
    ++row;
  }
  return all;
}

}  // namespace

bool CurveMove::doubted() const {
  const double taken_V =
      std::sqrt(std::max(rmse_V * rmse_V - corrected_rmse_V * corrected_rmse_V, 0.0));
  if (soc < -kBeyond || soc > 1.0 + kBeyond) return false;
  return corrected_rmse_V <= kMostLeft * rmse_V && taken_V >= kWorthSaying_V;
}

std::optional<CurveMove> MoveOfHeldCurve(const JointResult& result) {
  const JointSolution& best = result.choice.best;
  if (!result.setup.held || best.x.size() == 0) return std::nullopt;
  const JointObservations seen(result.logs, result.setup);
  const LinearizedFit fit = Linearize(seen, best, {.fixed = result.fixed}, result.Axis());
  const SocTrace soc = TraceSoc(result.logs, result.setup, best.rates);
  if (!(soc.highest > soc.lowest)) return std::nullopt;
  const std::vector<double> nodes = CorrectionNodes(soc);
  const Eigen::Index p = fit.penalty.rows();
  const auto m = static_cast<Eigen::Index>(nodes.size());

  std::vector<Eigen::MatrixXd> rows;
  Eigen::MatrixXd square = Eigen::MatrixXd::Zero(p + m, p + m);
  Eigen::VectorXd with_residual = Eigen::VectorXd::Zero(p + m);
  double before_V2 = 0.0;
  double weight = 0.0;
  for (std::size_t l = 0; l < fit.logs.size(); ++l) {
    const FittedRows& log = fit.logs[l];
    rows.push_back(WithCorrection(log, result.logs.logs[l], soc.logs[l], nodes));
    square += rows.back().transpose() * log.weight.asDiagonal() * rows.back();
    with_residual += rows.back().transpose() * log.weight.cwiseProduct(log.residual_V);
    before_V2 += log.weight.dot(log.residual_V.cwiseAbs2());
    weight += log.weight.sum();
  }
  const Eigen::VectorXd of_nodes = square.diagonal().tail(m);
  square.diagonal().tail(m) *= 1.0 + kRidge;
  square.topLeftCorner(p, p) += fit.penalty;
  const Eigen::VectorXd move = StepsOf(std::move(square), std::move(with_residual), fit.held);

  double after_V2 = 0.0;
  for (std::size_t l = 0; l < fit.logs.size(); ++l)
    after_V2 += fit.logs[l].weight.dot((fit.logs[l].residual_V - rows[l] * move).cwiseAbs2());
  Eigen::Index at = 0;
  of_nodes.cwiseProduct(move.tail(m).cwiseAbs2()).maxCoeff(&at);
  return CurveMove{.rmse_V = std::sqrt(before_V2 / weight),
                   .corrected_rmse_V = std::sqrt(after_V2 / weight),
                   .largest_V = move[p + at],
                   .soc = nodes[static_cast<std::size_t>(at)]};
}

std::string DoubtAboutHeldCurve(const std::string& source, const CurveMove& move) {
  if (!move.doubted()) return "";
  const double size_V = std::abs(move.largest_V);
  return fmt::format(
      "the reference's open-circuit voltage does not fit these logs: that of {} is about {} too {} about "
      "{:.0f} % charge, and a corrected one would leave {:.3g} mV rms of {:.3g}, rows weighted as in the fit; "
      "alpha, beta and the resistances make up for it and are not those of the cell. Identify this age without --reference, with a low-rate log "
      "of its own",
      source,
      size_V < 1.0 ? fmt::format("{:.0f} mV", 1e3 * size_V) : fmt::format("{:.2g} V", size_V),
      move.largest_V > 0.0 ? "low" : "high",
      100.0 * std::clamp(move.soc, 0.0, 1.0),
      1e3 * move.corrected_rmse_V,
      1e3 * move.rmse_V);
}

}  // namespace lipoid
