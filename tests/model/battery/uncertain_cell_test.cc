#include "model/battery/uncertain_cell.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/battery/cell_file.h"
#include "model/battery/cell_parameters.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

Cell Uncertain() {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.uncertainty =
      Cell::Uncertainty{.parameters = {"beta", "r_s", "v_oc[3]"},
                        .covariance = {{1e-4, 2e-6, 0.0}, {2e-6, 1e-6, 1e-6}, {0.0, 1e-6, 4e-6}},
                        .degrees_of_freedom = 20.0,
                        .soc_follows_alpha = false};
  return cell;
}

TEST(UncertainCell, AtItsEstimateIsTheCell) {
  const Cell cell = Uncertain();
  const UncertainCell around(cell);
  const Cell at = around.At(around.estimate());
  for (const std::string& name : around.names())
    EXPECT_NEAR(*CellParameter(at, name), *CellParameter(cell, name), 1e-14) << name;
  EXPECT_FALSE(at.uncertainty);
}

TEST(UncertainCell, MovesByStandardErrors) {
  const Cell cell = Uncertain();
  const UncertainCell around(cell);
  Eigen::VectorXd x = around.estimate();
  x[1] += 0.001;        // one standard error of r_s
  x[0] /= 1.01 * 1.01;  // 1/beta²
  const Cell at = around.At(x);
  EXPECT_NEAR(*CellParameter(at, "r_s") - *CellParameter(cell, "r_s"), 0.001, 1e-14);
  EXPECT_NEAR(*CellParameter(at, "beta") / *CellParameter(cell, "beta"), 1.01, 1e-12);
}

TEST(UncertainCell, ItsFactorIsThatOfTheCovariance) {
  const UncertainCell around(Uncertain());
  const Eigen::MatrixXd product = around.factor() * around.factor().transpose();
  EXPECT_LT((product - around.covariance()).norm(), 1e-14);
  const Eigen::MatrixXd all = PrincipalMoves(around, 0.0);
  EXPECT_LT((all * all.transpose() - product).norm(), 1e-14);
  const Eigen::MatrixXd most = PrincipalMoves(around, around.variances()[1]);
  ASSERT_EQ(most.cols(), 2);
  EXPECT_EQ(most.col(0), around.factor().col(2));
}

TEST(UncertainCell, GivesItsCovarianceBack) {
  const Cell cell = Uncertain();
  const UncertainCell around(cell);
  const Cell::Uncertainty back = around.WithCovariance(around.estimate(), around.covariance());
  EXPECT_EQ(back.parameters, cell.uncertainty->parameters);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j)
      EXPECT_NEAR(back.covariance[i][j], cell.uncertainty->covariance[i][j], 1e-18);
  }
  const Cell::Uncertainty some =
      UncertaintyAmong(cell, [](const std::string& name) { return name != "r_s"; });
  EXPECT_EQ(some.parameters, (std::vector<std::string>{"beta", "v_oc[3]"}));
  EXPECT_EQ(some.covariance, (std::vector<std::vector<double>>{{1e-4, 0.0}, {0.0, 4e-6}}));
}

TEST(UncertainCell, NeedsAnUncertainty) {
  EXPECT_THROW(UncertainCell(LoadCell("gifi-600mAh-1")), PreconditionError);
}

TEST(UncertainCell, TheLeastEigenvalueIsThatOfTheCorrelations) {
  EXPECT_EQ(LeastEigenvalue({}), 0.0);
  // Correlation 0.5 of variances that differ by 1e12: 1 - 0.5.
  EXPECT_NEAR(LeastEigenvalue({{1e6, 0.5}, {0.5, 1e-6}}), 0.5, 1e-12);
  EXPECT_NEAR(LeastEigenvalue({{1.0, 2.0}, {2.0, 1.0}}), -1.0, 1e-12);
}

}  // namespace
}  // namespace lipoid
