#include "identify/stages/row_factor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/support/constants.h"

namespace lipoid {
namespace {

using test::kEpsilon;

Eigen::MatrixXd RandomRows(Eigen::Index rows, Eigen::Index columns, unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd a(rows, columns);
  for (Eigen::Index k = 0; k < rows; ++k) {
    for (Eigen::Index j = 0; j < columns; ++j) a(k, j) = normal(engine);
  }
  return a;
}

void Push(const Eigen::MatrixXd& rows, RowFactor& factor) {
  for (Eigen::Index k = 0; k < rows.rows(); ++k) {
    double* next = factor.NextRow();
    for (Eigen::Index j = 0; j < rows.cols(); ++j) next[j * factor.stride()] = rows(k, j);
    factor.Push();
  }
}

Eigen::MatrixXd FactorOf(const Eigen::MatrixXd& rows) {
  RowFactor factor(static_cast<int>(rows.cols()));
  Push(rows, factor);
  return factor.Factor();
}

// Rows below, at and above the columns and the block in which rows are taken in.
TEST(RowFactor, HasTheSumOfTheOuterProductsOfItsRows) {
  for (const int columns : {1, 2, 5, 13}) {
    for (const Eigen::Index rows : {0, 1, columns - 1, columns, columns + 1, 255, 256, 257, 1000}) {
      const Eigen::MatrixXd a = RandomRows(rows, columns, 7);
      const Eigen::MatrixXd r = FactorOf(a);
      ASSERT_EQ(r.rows(), columns);
      ASSERT_EQ(r.cols(), columns);
      EXPECT_TRUE(r.isUpperTriangular(0.0)) << r;
      // Backward stable: an error of the order of rounding in every row, relative to the columns'
      // norms.
      const Eigen::VectorXd norms = a.colwise().norm().transpose();
      const Eigen::MatrixXd error = (r.transpose() * r - a.transpose() * a).cwiseAbs();
      const Eigen::MatrixXd scale = norms * norms.transpose();
      EXPECT_TRUE((error.array() <= 50 * kEpsilon * scale.array()).all())
          << rows << " rows, " << columns << " columns, worst " << error.maxCoeff();
    }
  }
}

TEST(RowFactor, GoesOnAfterItWasAsked) {
  const Eigen::MatrixXd a = RandomRows(300, 4, 3);
  RowFactor factor(4);
  Push(a.topRows(100), factor);
  const Eigen::MatrixXd first = factor.Factor();
  EXPECT_EQ(factor.Factor(), first);  // asking changes nothing
  Push(a.bottomRows(200), factor);
  const Eigen::MatrixXd r = factor.Factor();
  EXPECT_LT((r.transpose() * r - a.transpose() * a).norm(), 50 * kEpsilon * a.squaredNorm());
}

// Columns of 1e-8 .. 1e8 (a time constant beside a resistance): every column keeps its own digits,
// and the solution of min ||b - A x|| is right where the normal equations have lost it.
TEST(RowFactor, KeepsTheDigitsOfBadlyScaledColumns) {
  constexpr int kUnknowns = 5;
  Eigen::MatrixXd a = RandomRows(2000, kUnknowns + 1, 11);
  // Two nearly dependent columns: condition 1e7, whose square is beyond double.
  a.col(3) = a.col(2) + 1e-7 * a.col(3);
  const Eigen::VectorXd truth = Eigen::VectorXd::LinSpaced(kUnknowns, 1.0, 5.0);
  a.col(kUnknowns) = a.leftCols(kUnknowns) * truth;
  const Eigen::MatrixXd unscaled = a;
  Eigen::VectorXd scale(kUnknowns);
  scale << 1e-8, 1e8, 1.0, 1e4, 1e-3;
  for (int j = 0; j < kUnknowns; ++j) a.col(j) *= scale[j];

  const Eigen::MatrixXd r = FactorOf(a);
  for (int j = 0; j < kUnknowns; ++j) {
    EXPECT_NEAR(r.col(j).norm(), a.col(j).norm(), 100 * kEpsilon * a.col(j).norm())
        << "column " << j;
  }
  const auto worst = [&](const Eigen::VectorXd& x) {
    return (x.cwiseProduct(scale) - truth).cwiseAbs().maxCoeff();
  };
  const Eigen::VectorXd by_factor = r.topLeftCorner(kUnknowns, kUnknowns)
                                        .triangularView<Eigen::Upper>()
                                        .solve(r.topRightCorner(kUnknowns, 1));
  EXPECT_LT(worst(by_factor), 1e-7);  // condition * rounding = 1e7 * 2e-16, and a margin of 50
  // The same by normal equations of the well scaled columns: the square of the condition eats the
  // digits.
  const Eigen::MatrixXd normal =
      unscaled.leftCols(kUnknowns).transpose() * unscaled.leftCols(kUnknowns);
  const Eigen::VectorXd right = unscaled.leftCols(kUnknowns).transpose() * unscaled.col(kUnknowns);
  EXPECT_GT((normal.ldlt().solve(right) - truth).cwiseAbs().maxCoeff(), 1e-4);
}

}  // namespace
}  // namespace lipoid
