#include "identify/fit/followed_move.h"

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

}  // namespace

void FollowedMoves::Add(const std::vector<FittedRows>& after,
                        const std::vector<double>& resistances_Ohm) {
  Eigen::VectorXd right = Eigen::VectorXd::Zero(fit_.penalty.rows());
  for (std::size_t l = 0; l < after.size(); ++l) {
    const FittedRows& log = fit_.logs[l];
    right +=
        log.sensitivity.transpose() * log.weight.cwiseProduct(after[l].residual_V - log.residual_V);
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
