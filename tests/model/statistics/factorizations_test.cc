#include "model/statistics/factorizations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace lipoid {
namespace {

// Sums of a dozen products of numbers of size one, a few times rounded.
constexpr double kRoundingOfFactors = 1e-13;

Eigen::MatrixXd Random(Eigen::Index rows, Eigen::Index columns) {
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(generator); });
}

TEST(Factorizations, EigenOfSymmetricIsThatOfARotatedDiagonal) {
  // [[2, 1], [1, 2]] has 1 and 3 along the diagonals of the plane; the upper triangle is not read.
  const Eigen::MatrixXd matrix{{2.0, 99.0}, {1.0, 2.0}};
  const SymmetricEigen eigen = EigenOfSymmetric(matrix);
  EXPECT_NEAR(eigen.values[0], 1.0, kRoundingOfFactors);
  EXPECT_NEAR(eigen.values[1], 3.0, kRoundingOfFactors);
  EXPECT_NEAR(std::abs(eigen.vectors(0, 1)), std::sqrt(0.5), kRoundingOfFactors);
  EXPECT_NEAR(eigen.vectors(0, 0), -eigen.vectors(1, 0), kRoundingOfFactors);
}

TEST(Factorizations, TriangularFactorHasTheSquareOfTheRows) {
  for (const Eigen::Index rows : {3, 5, 12}) {
    const Eigen::MatrixXd all = Random(rows, 5);
    const Eigen::MatrixXd factor = TriangularFactor(all);
    EXPECT_EQ(factor.rows(), std::min<Eigen::Index>(rows, 5));
    EXPECT_EQ(factor.cols(), 5);
    EXPECT_TRUE(factor.isUpperTriangular(0.0));
    EXPECT_LT((factor.transpose() * factor - all.transpose() * all).cwiseAbs().maxCoeff(),
              kRoundingOfFactors);
  }
}

TEST(Factorizations, OrthogonalBasisSpansTheColumnsFirst) {
  const Eigen::MatrixXd columns = Random(6, 2);
  const Eigen::MatrixXd basis = OrthogonalBasis(columns);
  EXPECT_TRUE(basis.isUnitary(kRoundingOfFactors));
  EXPECT_LT((basis.rightCols(4).transpose() * columns).cwiseAbs().maxCoeff(), kRoundingOfFactors);
}

TEST(Factorizations, SolvesWithAPositiveMatrix) {
  const Eigen::MatrixXd rows = Random(12, 4);
  const Eigen::MatrixXd square = rows.transpose() * rows;
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(4, 4);
  EXPECT_LT((InverseOfPositive(square) * square - one).cwiseAbs().maxCoeff(), kRoundingOfFactors);
  const Eigen::VectorXd x = Random(4, 1);
  EXPECT_LT((SolvePositive(square, Eigen::VectorXd(square * x)) - x).norm(), kRoundingOfFactors);
  const Eigen::MatrixXd both = Random(4, 2);
  EXPECT_LT((SolvePositive(square, Eigen::MatrixXd(square * both)) - both).norm(),
            kRoundingOfFactors);
  EXPECT_EQ(SolvePositive(square, Eigen::MatrixXd(4, 0)).cols(), 0);
}

TEST(Factorizations, SolvesLeastSquares) {
  const Eigen::MatrixXd rows = Random(9, 3);
  const Eigen::VectorXd right = Random(9, 1);
  const Eigen::VectorXd x = LeastSquares(rows, right);
  EXPECT_LT((rows.transpose() * (right - rows * x)).norm(), kRoundingOfFactors);
  // Twice the same column: of all that fit, the shortest shares between them.
  Eigen::MatrixXd twice(9, 4);
  twice << rows, rows.col(2);
  const Eigen::VectorXd shortest = ShortestLeastSquares(twice, right);
  EXPECT_NEAR(shortest[2], 0.5 * x[2], kRoundingOfFactors);
  EXPECT_NEAR(shortest[3], 0.5 * x[2], kRoundingOfFactors);
}

TEST(Factorizations, InvertsWhatCanBeInverted) {
  const Eigen::MatrixXd square = Random(5, 5);
  const auto inverse = Inverse(square);
  ASSERT_TRUE(inverse.has_value());
  EXPECT_LT((*inverse * square - Eigen::MatrixXd::Identity(5, 5)).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((PseudoInverse(square) - *inverse).cwiseAbs().maxCoeff(), 1e-12);
  Eigen::MatrixXd singular = square;
  singular.col(1) = singular.col(3);
  EXPECT_FALSE(Inverse(singular).has_value());
  const Eigen::MatrixXd pseudo = PseudoInverse(singular);
  EXPECT_LT((singular * pseudo * singular - singular).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Factorizations, EigenvectorsAreTurnedByNothing) {
  Eigen::MatrixXd matrix = Random(6, 6);
  matrix.bottomLeftCorner(3, 3).setZero();
  const auto eigen = EigenOf(matrix);
  ASSERT_TRUE(eigen.has_value());
  const Eigen::MatrixXcd turned = matrix * eigen->vectors;
  EXPECT_LT((turned - eigen->vectors * eigen->values.asDiagonal()).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_NEAR(EigenvaluesOf(matrix).sum().real(), matrix.trace(), 1e-12);
}

TEST(Factorizations, RootsMakeThePolynomial) {
  // (s + 2)(s² + 2 s + 5)
  const Eigen::VectorXcd roots = RootsOf(Eigen::Vector4d(10.0, 9.0, 4.0, 1.0));
  ASSERT_EQ(roots.size(), 3);
  for (const std::complex<double>& s : roots) {
    EXPECT_LT(std::abs((s + 2.0) * (s * s + 2.0 * s + 5.0)), 1e-12);
  }
}

}  // namespace
}  // namespace lipoid
