#include "model/battery/prediction_band.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <vector>

#include "model/battery/cell_ensemble.h"
#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

Cell WithUncertainSeriesResistance(double standard_error_Ohm, double freedom) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.uncertainty =
      Cell::Uncertainty{.parameters = {"r_s"},
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
  const auto band =
      PredictBand(cells, std::vector<double>(kCells, 0.9), log.time_s, log.current_A);
  const auto estimate = Predict(cell, log.time_s, log.current_A, Hold::kBackward, 0.9);
  // A quantile of 4000 numbers: sqrt(p (1 - p)/N) over the density there, 0.0297 of t_10, is 0.083
  // standard errors; four of them.
  constexpr double kChance = 4.0 * 0.083;
  for (std::size_t k = 0; k < log.time_s.size(); ++k) {
    const double drop_V = 3.0 * log.current_A[k] / 2.0 * kError_Ohm;
    // Rounding of a dozen volts where no current flows.
    ASSERT_NEAR(band.voltage_low_V[k], estimate.voltage_V[k] - kQuantile * drop_V,
                kChance * drop_V + 1e-12);
    ASSERT_NEAR(band.voltage_high_V[k], estimate.voltage_V[k] + kQuantile * drop_V,
                kChance * drop_V + 1e-12);
  }
}

TEST(PredictionBand, OfOneCellIsItsPrediction) {
  const Cell cell = LoadCell("gifi-600mAh-1");
  const Log log = Steps();
  for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
    const std::vector<Cell> one{cell};
    const auto band =
        PredictBand(one, std::vector<double>{0.8}, log.time_s, log.current_A, hold);
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
