#include "identify/fit/followed_move.h"

#include <cmath>
#include <utility>

namespace lipoid {
namespace {

void Prepend(const Eigen::VectorXd& common, Eigen::VectorXd& added_spread) {
  const Eigen::VectorXd own = added_spread;
  added_spread.resize(common.size() + own.size());
  added_spread << common, own;
}

void Append(const Eigen::VectorXd& column, Eigen::MatrixXd& columns) {
  columns.conservativeResize(column.size(), columns.cols() + 1);
  columns.rightCols(1) = column;
}

// By how much the residuals move, at the means of `before`. A sweep divides the rows otherwise where it passes a
// knot of v_oc(A) in another block: these means move as the last one before them that both sweeps have.
Eigen::VectorXd MoveOfResiduals(const FittedRows& before, const FittedRows& after) {
  if (before.averaged.size() == after.averaged.size() && before.averaged == after.averaged)
    return after.residual_V - before.residual_V;
  // A quadrature sums to whole rows but for its rounding.
  const auto rows = [](const FittedRows& of, Eigen::Index k) { return std::round(of.averaged[k]); };
  Eigen::VectorXd moved_V = Eigen::VectorXd::Zero(before.residual_V.size());
  double begin = 0.0;  // rows before the mean of `before`, and of `after`
  double begin_after = 0.0;
  Eigen::Index j = 0;
  for (Eigen::Index k = 0; k < moved_V.size(); ++k) {
    const double end = begin + rows(before, k);
    while (j < after.averaged.size() && begin_after + rows(after, j) < end)
      begin_after += rows(after, j++);
    const bool same =
        j < after.averaged.size() && begin_after == begin && rows(after, j) == rows(before, k);
    if (same) {
      moved_V[k] = after.residual_V[j] - before.residual_V[k];
    } else if (k > 0) {
      moved_V[k] = moved_V[k - 1];
    }
    begin = end;
  }
  return moved_V;
}

}  // namespace

void FollowedMoves::Add(const std::vector<FittedRows>& after,
                        const std::vector<double>& resistances_Ohm) {
  Eigen::VectorXd right = Eigen::VectorXd::Zero(fit_.penalty.rows());
  for (std::size_t l = 0; l < after.size(); ++l) {
    const FittedRows& log = fit_.logs[l];
    right += log.sensitivity.transpose() * log.weight.cwiseProduct(MoveOfResiduals(log, after[l]));
  }
  Append(right, right_);
  Append(Eigen::Map<const Eigen::VectorXd>(resistances_Ohm.data(),
                                           static_cast<Eigen::Index>(resistances_Ohm.size())),
         resistance_Ohm_);
}

Eigen::MatrixXd FollowedMoves::OfParameters() const {
  if (size() == 0) return Eigen::MatrixXd::Zero(fit_.penalty.rows(), 0);
  Eigen::MatrixXd square = fit_.penalty;
  for (const FittedRows& log : fit_.logs)
    square += log.sensitivity.transpose() * log.weight.asDiagonal() * log.sensitivity;
  return StepsOf(std::move(square), right_, fit_.held);
}

void FollowedMoves::CountIn(std::vector<TrustedQuantity>& quantities,
                            std::vector<NamedCombination>& drawn,
                            std::vector<NamedCombination>& pulses) const {
  if (size() == 0) return;
  const Eigen::MatrixXd moves = OfParameters();
  for (TrustedQuantity& q : quantities) Prepend(moves.transpose() * q.combination, q.added_spread);
  for (NamedCombination& one : drawn)
    Prepend(moves.transpose() * one.combination, one.added_spread);
  for (std::size_t k = 0; k < pulses.size(); ++k) {
    Prepend(moves.transpose() * pulses[k].combination +
                resistance_Ohm_.row(static_cast<Eigen::Index>(k)).transpose(),
            pulses[k].added_spread);
  }
}

}  // namespace lipoid
