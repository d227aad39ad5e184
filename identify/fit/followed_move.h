#pragma once

/// @file
/// What a fit does where something that it holds is not as it holds it: a curve, a rate, modes of the diffusion that
/// it leaves out. Such a move moves the predicted voltages, and the fit follows to first order, as it follows any
/// other error of the voltages. Tests: tests/identify/joint/held_error_test.cc,
/// tests/identify/fit/fast_modes_test.cc.

#include <Eigen/Core>
#include <vector>

#include "identify/fit/linearized_fit.h"

namespace lipoid {

/// Moves that are independent of one another. All that the fit finds has each of them in common.
class FollowedMoves {
 public:
  /// It must outlive this.
  explicit FollowedMoves(const LinearizedFit& fit) : fit_(fit) {}

  /// One move: the rows of the fit after it, and what it does by itself, before the fit follows, to the pulse
  /// resistances (pulse_resistance.h).
  void Add(const std::vector<FittedRows>& after, const std::vector<double>& resistances_Ohm);
  [[nodiscard]] Eigen::Index size() const { return right_.cols(); }
  /// How the parameters of the fit follow: a column for each move.
  [[nodiscard]] Eigen::MatrixXd OfParameters() const;
  /// Into what is not in the scatter of the rows, of quantities, of what is drawn, and of the pulse resistances.
  void CountIn(std::vector<TrustedQuantity>& quantities,
               std::vector<NamedCombination>& drawn,
               std::vector<NamedCombination>& pulses) const;

 private:
  const LinearizedFit& fit_;
  Eigen::MatrixXd right_;
  Eigen::MatrixXd resistance_Ohm_;
};

}  // namespace lipoid
