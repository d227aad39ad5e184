#include "model/statistics/factorizations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace lipoid {
namespace {

// Sums of a dozen products of numbers of size one, a few times rounded.
constexpr double kRounding = 1e-13;

Eigen::MatrixXd Random(Eigen::Index rows, Eigen::Index columns) {
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(generator); });
}

TEST(Factorizations, EigenOfSymmetricIsThatOfARotatedDiagonal) {
  // [[2, 1], [1, 2]] has 1 and 3 along the diagonals of the plane; the upper triangle is not read.
  const Eigen::MatrixXd matrix{{2.0, 99.0}, {1.0, 2.0}};
  const SymmetricEigen eigen = EigenOfSymmetric(matrix);
  EXPECT_NEAR(eigen.values[0], 1.0, kRounding);
  EXPECT_NEAR(eigen.values[1], 3.0, kRounding);
  EXPECT_NEAR(std::abs(eigen.vectors(0, 1)), std::sqrt(0.5), kRounding);
  EXPECT_NEAR(eigen.vectors(0, 0), -eigen.vectors(1, 0), kRounding);
}

TEST(Factorizations, TriangularFactorHasTheSquareOfTheRows) {
  for (const Eigen::Index rows : {3, 5, 12}) {
    const Eigen::MatrixXd all = Random(rows, 5);
    const Eigen::MatrixXd factor = TriangularFactor(all);
    EXPECT_EQ(factor.rows(), std::min<Eigen::Index>(rows, 5));
    EXPECT_EQ(factor.cols(), 5);
    EXPECT_TRUE(factor.isUpperTriangular(0.0));
    EXPECT_LT((factor.transpose() * factor - all.transpose() * all).cwiseAbs().maxCoeff(),
              kRounding);
  }
}

TEST(Factorizations, OrthogonalBasisSpansTheColumnsFirst) {
  const Eigen::MatrixXd columns = Random(6, 2);
  const Eigen::MatrixXd basis = OrthogonalBasis(columns);
  EXPECT_TRUE(basis.isUnitary(kRounding));
  EXPECT_LT((basis.rightCols(4).transpose() * columns).cwiseAbs().maxCoeff(), kRounding);
}

TEST(Factorizations, SolvesWithAPositiveMatrix) {
  const Eigen::MatrixXd rows = Random(12, 4);
  const Eigen::MatrixXd square = rows.transpose() * rows;
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(4, 4);
  EXPECT_LT((InverseOfPositive(square) * square - one).cwiseAbs().maxCoeff(), kRounding);
  const Eigen::VectorXd x = Random(4, 1);
  EXPECT_LT((SolvePositive(square, Eigen::VectorXd(square * x)) - x).norm(), kRounding);
  const Eigen::MatrixXd both = Random(4, 2);
  EXPECT_LT((SolvePositive(square, Eigen::MatrixXd(square * both)) - both).norm(), kRounding);
  EXPECT_EQ(SolvePositive(square, Eigen::MatrixXd(4, 0)).cols(), 0);
}

}  // namespace
}  // namespace lipoid
