#include "identify/fit/followed_move.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lipoid {
namespace {

// One parameter, the same in all rows.
FittedRows Rows(const Eigen::VectorXd& averaged, const Eigen::VectorXd& residual_V) {
  FittedRows rows;
  for (Eigen::Index k = 0; k < averaged.size(); ++k) rows.time_s.push_back(static_cast<double>(k));
  rows.averaged = averaged;
  rows.weight = averaged;
  rows.residual_V = residual_V;
  rows.sensitivity = Eigen::MatrixXd::Ones(averaged.size(), 1);
  return rows;
}

double MoveOf(const FittedRows& before, const FittedRows& after) {
  LinearizedFit fit;
  fit.logs = {before};
  fit.penalty = Eigen::MatrixXd::Zero(1, 1);
  FollowedMoves moves(fit);
  moves.Add({after}, {});
  return moves.OfParameters()(0, 0);
}

// A sweep with more modes may pass a knot of v_oc(A) in another block, and then divides the rows otherwise.
TEST(FollowedMoves, RowsThatAreDividedOtherwiseAreFound) {
  const Eigen::Vector3d averaged(2.0, 4.0, 2.0);
  const FittedRows before = Rows(averaged, Eigen::Vector3d(0.1, 0.2, 0.3));
  const double alike = MoveOf(before, Rows(averaged, Eigen::Vector3d(1.1, 1.2, 1.3)));
  EXPECT_NEAR(std::abs(alike), 1.0, 1e-12);  // every row moves by 1 V
  Eigen::VectorXd divided(4);
  divided << 2.0, 1.0, 3.0, 2.0;
  Eigen::VectorXd moved_V(4);
  moved_V << 1.1, 7.0, 7.0, 1.3;  // what the parts of the second mean show is not compared
  EXPECT_NEAR(MoveOf(before, Rows(divided, moved_V)), alike, 1e-12);
  const Eigen::Vector2d joined(6.0, 2.0);
  const FittedRows fewer = Rows(joined, Eigen::Vector2d(7.0, 1.3));
  EXPECT_NEAR(MoveOf(before, fewer), 2.0 / 8.0 * alike, 1e-12);
}

}  // namespace
}  // namespace lipoid
