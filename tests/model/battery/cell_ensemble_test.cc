#include "model/battery/cell_ensemble.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Dense>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/battery/cell_file.h"
#include "model/battery/cell_parameters.h"
#include "model/battery/prediction.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

constexpr double kNormal = 1e7;  // degrees of freedom

// A cell with a branch that takes part, and an uncertainty of these parameters.
Cell With(std::vector<std::string> parameters,
          std::vector<std::vector<double>> covariance,
          double freedom = kNormal) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.branches = {{.resistance_Ohm = 0.03, .time_constant_s = 45.0, .capacitance_F = 1500.0}};
  cell.uncertainty = Cell::Uncertainty{.parameters = std::move(parameters),
                                       .covariance = std::move(covariance),
                                       .degrees_of_freedom = freedom};
  return cell;
}

// Values of the parameters, a column per cell.
Eigen::MatrixXd Drawn(const Cell& cell, int count, std::uint64_t seed = 1) {
  const auto& names = cell.uncertainty->parameters;
  const auto ensemble = DrawCells(cell, count, seed);
  Eigen::MatrixXd values(static_cast<Eigen::Index>(names.size()), count);
  for (Eigen::Index c = 0; c < count; ++c) {
    for (std::size_t k = 0; k < names.size(); ++k)
      values(static_cast<Eigen::Index>(k), c) =
          *CellParameter(ensemble.cells[static_cast<std::size_t>(c)], names[k]);
  }
  return values;
}

Eigen::MatrixXd CovarianceOf(const Eigen::MatrixXd& values) {
  const Eigen::MatrixXd off = values.colwise() - values.rowwise().mean();
  return off * off.transpose() / static_cast<double>(values.cols() - 1);
}

// Within five standard deviations of what chance makes of so many normal draws: each entry of the
// covariance then has the variance (C_ii C_jj + C_ij²)/N, times more for heavier tails.
void ExpectMoments(const Eigen::MatrixXd& values,
                   const std::vector<double>& mean,
                   const Eigen::MatrixXd& covariance,
                   double tails = 1.0) {
  const auto count = static_cast<double>(values.cols());
  const Eigen::MatrixXd found = CovarianceOf(values);
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    EXPECT_NEAR(values.row(i).mean(),
                mean[static_cast<std::size_t>(i)],
                5.0 * std::sqrt(covariance(i, i) / count));
    for (Eigen::Index j = 0; j < values.rows(); ++j) {
      const double chance =
          std::sqrt((covariance(i, i) * covariance(j, j) + std::pow(covariance(i, j), 2)) / count);
      EXPECT_NEAR(found(i, j), covariance(i, j), 5.0 * tails * chance) << i << " " << j;
    }
  }
}

TEST(CellEnsemble, MeanAndCovarianceAreThoseGiven) {
  const Cell cell =
      With({"r_s", "r_1", "tau_1"}, {{1e-6, -8e-7, 1e-3}, {-8e-7, 1e-6, 0.0}, {1e-3, 0.0, 9.0}});
  Eigen::Matrix3d covariance;
  covariance << 1e-6, -8e-7, 1e-3, -8e-7, 1e-6, 0.0, 1e-3, 0.0, 9.0;
  ExpectMoments(Drawn(cell, 20000), {0.1314, 0.03, 45.0}, covariance);
  EXPECT_EQ(DrawCells(cell, 2000, 1).moved, 0);  // 15 standard errors from any bound
}

TEST(CellEnsemble, FewDegreesOfFreedomMakeStudentsTails) {
  constexpr double kFreedom = 12.0;
  const Cell cell = With({"r_s", "r_1"}, {{1e-6, 5e-7}, {5e-7, 1e-6}}, kFreedom);
  const Eigen::MatrixXd values = Drawn(cell, 40000);
  Eigen::Matrix2d scale;
  scale << 1e-6, 5e-7, 5e-7, 1e-6;
  // Student's covariance is nu/(nu - 2) of its scale; its fourth moment 3 (nu - 2)/(nu - 4) of the
  // squared variance makes the chance of a sampled variance wider.
  ExpectMoments(values, {0.1314, 0.03}, kFreedom / (kFreedom - 2.0) * scale, 1.2);
  // 95 % lie within 2.1788 standard errors (the table of Student's t), 97.7 % would if normal.
  int within = 0;
  for (const double r_s : values.row(0)) within += std::abs(r_s - 0.1314) <= 2.1788e-3 ? 1 : 0;
  EXPECT_NEAR(within / 40000.0, 0.95, 0.004);  // four standard deviations
}

// The charge that diffusion holds back goes with 1/beta², which is what is drawn.
TEST(CellEnsemble, BetaIsDrawnByWhatDiffusionHoldsBack) {
  const double beta = 0.1924;
  const double held_back_s = 1.0 / (beta * beta);
  const Cell cell = With({"beta"}, {{0.01 * beta * beta}});  // 10 %
  const Eigen::MatrixXd values = Drawn(cell, 20000).array().square().inverse();
  Eigen::MatrixXd covariance(1, 1);
  covariance << 0.04 * held_back_s * held_back_s;
  ExpectMoments(values, {held_back_s}, covariance);
}

// A beta that is known to a factor of itself holds back a few times what the estimate does, and not
// hundreds of times; none is above 1.
TEST(CellEnsemble, ABetaThatIsHardlyKnownStaysOfItsKind) {
  const double beta = 0.25;
  const Cell cell = With({"beta"}, {{beta * beta}});
  const Eigen::MatrixXd values = Drawn(cell, 20000);
  EXPECT_GT(values.minCoeff(), beta / 5.0);  // 25 times 1/beta²: twelve of its standard errors
  EXPECT_LE(values.maxCoeff(), 1.0);
}

// The sum of two resistances is known to 0.1 mOhm, each of them to 30: where one would become
// negative it is zero, and the other follows.
TEST(CellEnsemble, WhatTheDataKnowStaysWhereADrawIsMovedIntoRange) {
  const double own = 9e-4;
  const double apart = -own + 0.5e-8;
  const Cell cell = With({"r_s", "r_1"}, {{own, apart}, {apart, own}});
  const auto ensemble = DrawCells(cell, 4000, 3);
  int at_zero = 0;
  for (const Cell& drawn : ensemble.cells) {
    const double r_s = *CellParameter(drawn, "r_s");
    const double r_1 = *CellParameter(drawn, "r_1");
    ASSERT_GE(r_s, 0.0);
    ASSERT_GE(r_1, 0.0);
    ASSERT_NEAR(r_s + r_1, 0.1614, 5e-4);  // five standard errors of the sum
    at_zero += r_1 < 1e-12 ? 1 : 0;        // zero but for rounding
  }
  // r_1 of 0.03 +- 0.03: a sixth of a normal distribution lies below zero.
  EXPECT_NEAR(at_zero / 4000.0, 0.1587, 0.025);
  EXPECT_EQ(ensemble.moved, at_zero);
  EXPECT_EQ(DoubtAboutMoved(static_cast<std::size_t>(ensemble.moved), 4000), "");
}

// Of thirty nodes of 1 +- 1 mOhm five of each cell are below zero. Moving them would take alpha along, which has
// no bound near and as much to do with each: 0.4 of its standard errors down in the mean.
TEST(CellEnsemble, NodesThatAreMovedLeaveANumberAsItWasDrawn) {
  constexpr std::size_t kNodes = 30;
  constexpr double kCorrelation = -0.17;  // 30 times its square is 0.87
  Cell cell = LoadCell("gifi-600mAh-1");
  const double error_C = 0.02 * cell.alpha_C();
  Resistance<double>& r_s = cell.series_resistance_Ohm;
  r_s.soc.clear();
  r_s.resistance_Ohm.assign(kNodes, 1e-3);
  Cell::Uncertainty uncertainty{
      .parameters = {"alpha"},
      .covariance = std::vector(kNodes + 1, std::vector<double>(kNodes + 1, 0.0)),
      .degrees_of_freedom = 1e7,
      .soc_follows_alpha = false};
  uncertainty.covariance[0][0] = error_C * error_C;
  for (std::size_t k = 0; k < kNodes; ++k) {
    r_s.soc.push_back(static_cast<double>(k) / (kNodes - 1));
    uncertainty.parameters.push_back(fmt::format("r_s[{}]", k));
    uncertainty.covariance[k + 1][k + 1] = 1e-6;
    uncertainty.covariance[0][k + 1] = uncertainty.covariance[k + 1][0] =
        kCorrelation * 1e-3 * error_C;
  }
  cell.uncertainty = uncertainty;
  constexpr int kCells = 4000;
  const CellEnsemble ensemble = DrawCells(cell, kCells, 1);
  EXPECT_GT(ensemble.moved, 0.95 * kCells);
  double sum = 0.0;
  double squares = 0.0;
  for (const Cell& drawn : ensemble.cells) {
    const double off = (drawn.alpha_C() - cell.alpha_C()) / error_C;
    sum += off;
    squares += off * off;
    for (const double node_Ohm : drawn.series_resistance_Ohm.resistance_Ohm)
      ASSERT_GE(node_Ohm, 0.0);
  }
  EXPECT_NEAR(sum / kCells, 0.0, 5.0 / std::sqrt(kCells));
  EXPECT_NEAR(squares / kCells, 1.0, 5.0 * std::sqrt(2.0 / kCells));
}

// Half of what is drawn about zero is below: then the estimate is an end of the interval, and not
// outside.
TEST(CellEnsemble, AnIntervalOfMovedCellsSaysSo) {
  EXPECT_EQ(DoubtAboutMoved(0, 0), "");
  EXPECT_EQ(DoubtAboutMoved(100, 200), "");
  EXPECT_EQ(DoubtAboutMoved(101, 200).find("101 of 200 cells were drawn with what no cell has"),
            0U);
}

TEST(CellEnsemble, EveryCellIsOneThatAFileMayHold) {
  Cell cell = With({"alpha",
                    "beta",
                    "r_s[0]",
                    "r_s[1]",
                    "r_1",
                    "tau_1",
                    "tau_h",
                    "rho_h",
                    "i_0",
                    "r_ct",
                    "v_oc[3]",
                    "v_oc[4]",
                    "v_oc[12]"},
                   {},
                   3.0);
  cell.series_resistance_Ohm = Resistance<double>({0.0, 1.0}, {0.2, 0.0});
  cell.self_heating = {100.0, 1e-4};
  cell.charge_transfer = {0.5, Resistance<double>(0.01)};
  auto& covariance = cell.uncertainty->covariance;
  const auto& names = cell.uncertainty->parameters;
  covariance.assign(names.size(), std::vector<double>(names.size(), 0.0));
  for (std::size_t k = 0; k < names.size(); ++k) {
    const double value = *CellParameter(cell, names[k]);
    covariance[k][k] = names[k].starts_with("v_oc") ? 0.04 : std::max(1e-4, value * value);
  }
  const auto ensemble = DrawCells(cell, 500, 9);
  EXPECT_GT(ensemble.moved, 250);
  for (const Cell& drawn : ensemble.cells) {
    ASSERT_NO_THROW((void)ParseCell(CellToJson(drawn).dump(), "drawn.json"));
    const auto& voltage_V = drawn.open_circuit_voltage.voltage_V();
    for (std::size_t k = 1; k < voltage_V.size(); ++k) ASSERT_GE(voltage_V[k], voltage_V[k - 1]);
    // Nodes that are not drawn stay.
    ASSERT_EQ(voltage_V[0], 3.0);
    ASSERT_EQ(voltage_V[5], 3.74);
    ASSERT_FALSE(drawn.uncertainty.has_value());
  }
}

TEST(CellEnsemble, TheSameSeedGivesTheSameCellsOnAnyNumberOfThreads) {
  const Cell cell = With({"beta", "r_s"}, {{1e-4, 0.0}, {0.0, 1e-4}}, 5.0);
  const Eigen::MatrixXd all = Drawn(cell, 50, 7);
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(Drawn(cell, 50, 7), all);
  }
  EXPECT_EQ(Drawn(cell, 20, 7), all.leftCols(20));  // a longer ensemble begins with the shorter
  EXPECT_NE(Drawn(cell, 50, 8), all);
}

// The same numbers on every machine, to the rounding of its functions: printed once, by GCC 12.
TEST(CellEnsemble, TheNumbersDoNotDependOnTheStandardLibrary) {
  const Cell cell = With({"r_s"}, {{1e-4}}, 8.0);
  const Eigen::MatrixXd values = Drawn(cell, 3, 1);
  EXPECT_NEAR(values(0, 0), 0.14738692975732959, 1e-12);
  EXPECT_NEAR(values(0, 1), 0.12338961703206122, 1e-12);
  EXPECT_NEAR(values(0, 2), 0.12320433391627048, 1e-12);
}

TEST(CellEnsemble, ABranchKeepsWhatItIsWrittenWith) {
  const auto second = [](const Cell& cell) { return DrawCells(cell, 2, 1).cells[1]; };
  Cell drawn = second(With({"r_1"}, {{1e-6}}));
  EXPECT_EQ(drawn.branches[0].capacitance_F, 1500.0);
  EXPECT_EQ(drawn.branches[0].time_constant_s, 1500.0 * *CellParameter(drawn, "r_1"));
  drawn = second(With({"r_1", "tau_1"}, {{1e-6, 0.0}, {0.0, 0.0}}));
  EXPECT_NE(*CellParameter(drawn, "r_1"), 0.03);
  EXPECT_EQ(drawn.branches[0].time_constant_s, 45.0);
}

// In every form of the curve: a cell of another alpha whose curves follow shows the same voltage
// under any current, for there is no diffusion to tell them apart; and another one where they stay.
TEST(CellEnsemble, CurvesOverChargeFollowAlpha) {
  const std::vector<double> soc{-0.1, 0.2, 0.5, 0.8, 1.0};
  const std::vector<double> voltage_V{2.9, 3.6, 3.7, 3.9, 4.2};
  const OpenCircuitVoltage curves[] = {
      OpenCircuitVoltage::Linear(soc, voltage_V),
      OpenCircuitVoltage::MonotoneCubic(soc, voltage_V),
      OpenCircuitVoltage::Polynomial(0.0, 1.0, {3.6, 0.5, 0.05, 0.02}),
      OpenCircuitVoltage::Fourier(0.0, 1.0, 2.0, {3.7, -0.2, 0.05}, {0.3, -0.1})};
  std::vector<double> time_s;
  std::vector<double> current_A;
  for (int k = 0; k <= 50; ++k) {
    time_s.push_back(20.0 * k);
    current_A.push_back(k % 7 < 3 ? 1.8 : 0.3);
  }
  for (const OpenCircuitVoltage& curve : curves) {
    Cell cell = With({"alpha"}, {{9e4}});
    cell.open_circuit_voltage = curve;
    cell.series_resistance_Ohm = Resistance<double>({0.0, 0.5, 1.0}, {0.3, 0.15, 0.1});
    const auto expected = Predict(cell, time_s, current_A);
    for (const bool follows : {true, false}) {
      cell.uncertainty->soc_follows_alpha = follows;
      const Cell drawn = DrawCells(cell, 1, 4).cells[0];
      ASSERT_GT(std::abs(drawn.alpha_C() - cell.alpha_C()), 20.0);
      const auto found = Predict(drawn, time_s, current_A);
      double most_V = 0.0;
      for (std::size_t k = 0; k < time_s.size(); ++k)
        most_V = std::max(most_V, std::abs(found.voltage_V[k] - expected.voltage_V[k]));
      if (follows) {
        EXPECT_LT(most_V, 1e-12);  // rounding of a few volts
      } else {
        EXPECT_GT(most_V, 1e-3);
      }
    }
  }
}

TEST(CellEnsemble, ACellWithoutUncertaintyIsAMistakeOfTheCaller) {
  EXPECT_THROW((void)DrawCells(LoadCell("gifi-600mAh-1"), 3, 1), PreconditionError);
}

}  // namespace
}  // namespace lipoid
