#include "model/battery/prediction_band.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "model/battery/cell_ensemble.h"
#include "model/battery/cell_file.h"
#include "model/battery/cell_parameters.h"
#include "model/battery/prediction.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

Cell WithUncertainSeriesResistance(double standard_error_Ohm, double freedom) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.uncertainty = Cell::Uncertainty{.parameters = {"r_s"},
                                       .covariance = {{standard_error_Ohm * standard_error_Ohm}},
                                       .degrees_of_freedom = freedom};
  return cell;
}

struct Log {
  std::vector<double> time_s;
  std::vector<double> current_A;
};

// Longer than the rows that are taken at a time.
Log Steps() {
  Log log;
  for (int k = 0; k < 2500; ++k) {
    log.time_s.push_back(0.5 * k);
    log.current_A.push_back(k % 10 < 5 ? 0.0 : 0.2 * (k % 7));
  }
  return log;
}

// Of an uncertain r_s alone the band is known: i times the quantiles of Student's distribution.
TEST(PredictionBand, OfASeriesResistanceIsTheCurrentTimesItsInterval) {
  constexpr double kError_Ohm = 0.004;
  constexpr double kFreedom = 10.0;
  constexpr double kQuantile = 2.2281;  // of Student's t, 97.5 %, 10 degrees of freedom
  constexpr int kCells = 4000;
  Cell cell = WithUncertainSeriesResistance(kError_Ohm, kFreedom);
  cell.series = 3;
  cell.parallel = 2;
  const Log log = Steps();
  const auto cells = DrawCells(cell, kCells, 1).cells;
  const auto band = PredictBand(cells, std::vector<double>(kCells, 0.9), log.time_s, log.current_A);
  const auto estimate = Predict(cell, log.time_s, log.current_A, Hold::kBackward, 0.9);
  // A quantile of 4000 numbers: sqrt(p (1 - p)/N) over the density there, 0.0297 of t_10, is 0.083
  // standard errors; four of them.
  constexpr double kChance = 4.0 * 0.083;
  for (std::size_t k = 0; k < log.time_s.size(); ++k) {
    const double drop_V = 3.0 * log.current_A[k] / 2.0 * kError_Ohm;
    // Rounding of a dozen volts where no current flows.
    ASSERT_NEAR(band.voltage_low_V[k],
                estimate.voltage_V[k] - kQuantile * drop_V,
                kChance * drop_V + 1e-12);
    ASSERT_NEAR(band.voltage_high_V[k],
                estimate.voltage_V[k] + kQuantile * drop_V,
                kChance * drop_V + 1e-12);
  }
}

// Small errors of many parameters that vary together: the variance of a voltage is that of its
// linear part, g' C g with slopes g by differences of two simulations.
TEST(PredictionBand, OfSmallErrorsIsThatOfTheLinearPrediction) {
  constexpr int kCells = 4000;
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.branches = {{Resistance<double>(0.03), 45.0, 1500.0}};
  const std::vector<std::string> names{"beta", "r_s", "r_1", "tau_1", "v_oc[6]", "v_oc[7]"};
  const Eigen::VectorXd errors{{2e-4, 4e-4, 5e-4, 0.5, 3e-4, 3e-4}};
  const auto count = static_cast<Eigen::Index>(names.size());
  // r_s and r_1 against each other, the two nodes of v_oc together.
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(count, count);
  correlation(1, 2) = correlation(2, 1) = -0.9;
  correlation(4, 5) = correlation(5, 4) = 0.8;
  correlation(1, 4) = correlation(4, 1) = 0.3;
  const Eigen::MatrixXd covariance = errors.asDiagonal() * correlation * errors.asDiagonal();
  cell.uncertainty =
      Cell::Uncertainty{.parameters = names, .covariance = {}, .degrees_of_freedom = 1e7};
  for (Eigen::Index k = 0; k < count; ++k)
    cell.uncertainty->covariance.emplace_back(covariance.row(k).begin(), covariance.row(k).end());

  const Log log = Steps();
  constexpr double kStart = 0.6;
  Eigen::MatrixXd slope(static_cast<Eigen::Index>(log.time_s.size()), count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto& name = names[static_cast<std::size_t>(k)];
    std::vector<double> voltage_V[2];
    for (const int side : {0, 1}) {
      Cell moved = cell;
      const double by = (side == 0 ? -0.1 : 0.1) * errors[k];
      SetCellParameter(moved, name, *CellParameter(cell, name) + by);
      if (name == "r_1") moved.branches[0].time_constant_s = 45.0;  // tau_1 is drawn too
      voltage_V[side] =
          Predict(moved, log.time_s, log.current_A, Hold::kBackward, kStart).voltage_V;
    }
    for (std::size_t row = 0; row < log.time_s.size(); ++row)
      slope(static_cast<Eigen::Index>(row), k) =
          (voltage_V[1][row] - voltage_V[0][row]) / (0.2 * errors[k]);
  }
  const auto ensemble = DrawCells(cell, kCells, 5);
  EXPECT_EQ(ensemble.moved, 0);
  const auto band =
      PredictBand(ensemble.cells, std::vector<double>(kCells, kStart), log.time_s, log.current_A);
  // Four standard deviations of a quantile of 4000 normal numbers, 0.0424 each (p = 0.025, density
  // 0.0584), at either end, and a tenth of the width, where A crosses a kink of v_oc and slopes of
  // one side are not those of the other. Without the correlations it would be off by half and more.
  constexpr double kChance = 4.0 * 0.0424 * 1.4143 + 0.1 * 2.0 * 1.96;
  for (Eigen::Index row = 0; row < slope.rows(); ++row) {
    const double expected_V = std::sqrt(slope.row(row) * covariance * slope.row(row).transpose());
    const auto k = static_cast<std::size_t>(row);
    ASSERT_NEAR(band.voltage_high_V[k] - band.voltage_low_V[k],
                2.0 * 1.96 * expected_V,
                kChance * expected_V)
        << log.time_s[k];
  }
}

TEST(PredictionBand, OfOneCellIsItsPrediction) {
  const Cell cell = LoadCell("gifi-600mAh-1");
  const Log log = Steps();
  for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
    const std::vector<Cell> one{cell};
    const auto band = PredictBand(one, std::vector<double>{0.8}, log.time_s, log.current_A, hold);
    const auto expected = Predict(cell, log.time_s, log.current_A, hold, 0.8).voltage_V;
    EXPECT_EQ(band.voltage_low_V, expected);
    EXPECT_EQ(band.voltage_high_V, expected);
  }
}

TEST(PredictionBand, OfFewCellsIsTheirExtremes) {
  const auto cells = DrawCells(WithUncertainSeriesResistance(0.01, 1e7), 5, 2).cells;
  const Log log = Steps();
  const auto band = PredictBand(cells, std::vector<double>(5, 1.0), log.time_s, log.current_A);
  std::vector<double> low_V(log.time_s.size(), 1e9);
  std::vector<double> high_V(log.time_s.size(), -1e9);
  for (const Cell& cell : cells) {
    const auto voltage_V = Predict(cell, log.time_s, log.current_A).voltage_V;
    for (std::size_t k = 0; k < voltage_V.size(); ++k) {
      low_V[k] = std::min(low_V[k], voltage_V[k]);
      high_V[k] = std::max(high_V[k], voltage_V[k]);
    }
  }
  EXPECT_EQ(band.voltage_low_V, low_V);
  EXPECT_EQ(band.voltage_high_V, high_V);
}

TEST(PredictionBand, DoesNotDependOnTheNumberOfThreads) {
  const auto cells = DrawCells(WithUncertainSeriesResistance(0.01, 4.0), 60, 2).cells;
  const Log log = Steps();
  const std::vector<double> full(60, 1.0);
  const auto all = PredictBand(cells, full, log.time_s, log.current_A);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto alone = PredictBand(cells, full, log.time_s, log.current_A);
  EXPECT_EQ(alone.voltage_low_V, all.voltage_low_V);
  EXPECT_EQ(alone.voltage_high_V, all.voltage_high_V);
}

TEST(PredictionBand, NeedsCellsAndAStartForEach) {
  const std::vector<double> times{0.0, 1.0};
  EXPECT_THROW((void)PredictBand({}, {}, times, times), PreconditionError);
}

}  // namespace
}  // namespace lipoid
