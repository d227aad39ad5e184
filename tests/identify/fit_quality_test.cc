#include "identify/fit_quality.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "model/battery/cell_file.h"

namespace lipoid {
namespace {

LogErrors Fitted(double mean_error_percent, double rmse_V) {
  ErrorMetrics all;
  all.mean_error_percent = mean_error_percent;
  all.rmse = rmse_V;
  return {"a.csv", all, {}, 0};
}

ConstantCurrentErrors Time(double measured_s, double predicted_s) {
  ConstantCurrentErrors log;
  log.current_A = 0.6;
  log.measured_s = measured_s;
  log.predicted_s = predicted_s;
  log.error_percent = 100.0 * (predicted_s / measured_s - 1.0);
  return log;
}

// 0.376 Ah at vanishing rate.
const Cell& TheCell() {
  static const Cell cell = LoadCell("gifi-600mAh-1");
  return cell;
}

TEST(FitQuality, OfAGoodFitIsOneSentence) {
  const auto quality =
      JudgeFit(TheCell(), {Fitted(0.1, 0.003), Fitted(0.3, 0.004)}, {Time(1700, 1710)}, 1300, 0.4);
  EXPECT_EQ(quality.grade, FitGrade::kGood);
  EXPECT_TRUE(quality.reasons.empty());
  EXPECT_NEAR(quality.rmse_V, 0.0035355339, 1e-9);  // root of the mean square of the two
  EXPECT_EQ(quality.Sentence(), "predicts its own logs to 3.54 mV (0.2 %): good");
}

TEST(FitQuality, TheWorstOfItsReasonsCounts) {
  EXPECT_EQ(
      JudgeFit(TheCell(), {Fitted(2.0, 0.01)}, {Time(1700, 1400)}, 1300, 0.4).Sentence(),
      "predicts its own logs to 10 mV (2 %): fair: a mean error of 2 %; up to 1 % is good, up "
      "to 3 % fair; at 0.6 A it predicts 1400 s until the cut-off, where 1700 s were measured");
  EXPECT_EQ(JudgeFit(TheCell(), {Fitted(2.0, 0.01)}, {Time(1700, 34)}, 1300, 0.4).Sentence(),
            "predicts its own logs to 10 mV (2 %): poor: at 0.6 A it predicts 34 s until the "
            "cut-off, where 1700 s were measured");
}

// Few rows lie near a step, and the error over all rows hardly sees it.
TEST(FitQuality, SeesStepsThatTheCellAnswersOtherwise) {
  LogErrors a = Fitted(0.1, 0.003);
  LogErrors b = a;
  a.edges = {{0.5, 10.0, 0.05, 0.07}, {0.6, 10.0, 0.05, 0.07}};
  EXPECT_EQ(JudgeFit(TheCell(), {a}, {}, 1300, 0.4).grade, FitGrade::kGood);  // two are few
  b.edges = {{0.5, 10.0, 0.05, 0.07}};
  const auto quality = JudgeFit(TheCell(), {a, b}, {}, 1300, 0.4);
  EXPECT_EQ(quality.grade, FitGrade::kFair);
  ASSERT_EQ(quality.edges.size(), 1U);
  EXPECT_EQ(quality.reasons, std::vector{DoubtAboutEdges(quality.edges)});
  // What is worse explains the grade alone.
  EXPECT_EQ(JudgeFit(TheCell(), {a, b}, {Time(1700, 34)}, 1300, 0.4).reasons.size(), 1U);
}

TEST(FitQuality, SeesWhatNoCellIs) {
  const std::vector<LogErrors> well{Fitted(0.1, 0.003)};
  EXPECT_EQ(JudgeFit(TheCell(), {Fitted(219.0, 8.137)}, {}, 1300, 0.4).grade, FitGrade::kPoor);
  EXPECT_EQ(JudgeFit(TheCell(), well, {}, 1300, 2.9).reasons,
            (std::vector<std::string>{"alpha is 0.376 Ah for a cell of 2.9 Ah"}));
  EXPECT_EQ(JudgeFit(TheCell(), well, {}, 3600, 0.0).reasons,
            (std::vector<std::string>{
                "alpha is 0.376 Ah, less than the 1 Ah below full that a log reaches"}));
  EXPECT_EQ(JudgeFit(TheCell(), well, {}, 1300, 0.0).grade, FitGrade::kGood);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(JudgeFit(TheCell(), {Fitted(nan, nan)}, {}, 1300, 0.4).grade, FitGrade::kPoor);
  EXPECT_EQ(JudgeFit(TheCell(), well, {Time(1700, nan)}, 1300, 0.4).reasons,
            (std::vector<std::string>{
                "at 0.6 A it never reaches the cut-off, where 1700 s were measured"}));
  Cell cell = TheCell();
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {-3.0, 9.0});
  EXPECT_EQ(JudgeFit(cell, well, {}, 1300, 0.4).reasons,
            (std::vector<std::string>{"v_oc(A) runs from -3 to 9 V, which no cell does"}));
}

// alpha is the charge down to the cut-off; a wrong initial_soc makes another of it.
TEST(FitQuality, SeesThatTheCutOffIsNotWhereTheCellIsEmpty) {
  const std::vector<LogErrors> well{Fitted(0.1, 0.003)};
  Cell cell = TheCell();
  const auto down_to = [&](double soc) {
    cell.open_circuit_voltage = OpenCircuitVoltage::Linear({soc, 1.0}, {cell.cutoff_V, 4.2});
    return JudgeFit(cell, well, {}, 800, 0.4);
  };
  EXPECT_EQ(down_to(0.05).grade, FitGrade::kGood);
  EXPECT_EQ(down_to(0.2).grade, FitGrade::kFair);
  EXPECT_EQ(down_to(0.375).grade, FitGrade::kPoor);
  EXPECT_EQ(
      down_to(0.375).reasons,
      (std::vector<std::string>{
          "v_oc(A) is down to the cut-off of 3 V at a state of charge of 0.38, so that alpha, "
          "0.376 Ah, is not the charge that these logs show: look at initial_soc and at where "
          "alpha is from"}));
  // The last row of a log lies a little above the cut-off, and the curve's slope leads there far from empty.
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.24, 0.3, 1.0}, {3.1, 3.2, 4.2});
  EXPECT_EQ(JudgeFit(cell, well, {}, 800, 0.4).grade, FitGrade::kFair);
  // An alpha that was only assumed, as that of a flight, need not be.
  EXPECT_EQ(JudgeFit(cell, well, {}, 800, 0.4, AlphaOf::kElsewhere).grade, FitGrade::kGood);
  // Where no log went so deep nothing is known of it.
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.375, 1.0}, {3.6, 4.2});
  EXPECT_EQ(JudgeFit(cell, well, {}, 800, 0.4).grade, FitGrade::kGood);
}

// 0.376 A through 8.13 Ohm.
TEST(FitQuality, SeesABranchThatStandsInForSomethingElse) {
  const std::vector<LogErrors> well{Fitted(0.1, 0.003)};
  Cell cell = TheCell();
  cell.branches = {{Resistance<double>(8.0), 17700.0, 2212.5}};
  const auto quality = JudgeFit(cell, well, {}, 1300, 0.4);
  EXPECT_EQ(quality.grade, FitGrade::kFair);
  ASSERT_EQ(quality.reasons.size(), 1U);
  EXPECT_TRUE(quality.reasons[0].starts_with(
      "r_s and the branches have 8.13 Ohm at half charge, which at 1C takes 3.06 V of the "))
      << quality.reasons[0];
}

TEST(FitQuality, AsJson) {
  const Json json = FitQualityToJson(JudgeFit(TheCell(), {Fitted(0.5, 0.2)}, {}, 1300, 0.4));
  EXPECT_EQ(json.at("grade"), "poor");
  EXPECT_EQ(json.at("rmse_V"), 0.2);
  EXPECT_EQ(json.at("mean_error_percent"), 0.5);
  EXPECT_EQ(json.at("reasons")[0], "200 mV rms; up to 50 mV is good, up to 150 mV fair");
}

}  // namespace
}  // namespace lipoid
