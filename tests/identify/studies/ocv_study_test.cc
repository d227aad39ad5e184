#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/studies/study.h"
#include "model/core/errors.h"
#include "tests/identify/studies/study_logs.h"

namespace lipoid {
namespace {

using test::KnownCampaign;
using test::NoProgress;
using test::StudyCell;

constexpr int kRows = 5001;
constexpr double kNoise_V = 2e-4;
constexpr double kCurrent_A = 0.05;
constexpr double kStep_s = 5.0;

double Polynomial(double x) { return 3.2 + 0.9 * x - 0.6 * x * x + 0.7 * x * x * x * x * x; }

// 0.05 A for seven hours along a polynomial of degree 5.
LoadedLog LowRateLog() {
  LoadedLog log;
  log.entry.kind = LogKind::kLowRate;
  log.entry.file = log.log.record.file = "low_rate.csv";
  Record& record = log.log.record;
  std::mt19937 engine(5);
  std::normal_distribution<double> normal(0.0, kNoise_V);
  for (int k = 0; k < kRows; ++k) {
    record.time_s.push_back(kStep_s * k);
    record.current_A.push_back(k == 0 ? 0.0 : kCurrent_A);
    record.voltage_V.push_back(Polynomial(1.0 - double(k) / (kRows - 1)) + normal(engine));
  }
  return log;
}

// Without what a campaign of known truth is given for other studies.
StudyInput OfLogsAlone(const KnownCampaign& known) {
  return {.campaign = known.Input().campaign, .logs = known.Input().logs};
}

const StudyResult& Study() {
  static const StudyResult study = [] {
    const KnownCampaign known(StudyCell({}), {LowRateLog()});
    return StudyOcv(OfLogsAlone(known), NoProgress);
  }();
  return study;
}

const Json& Row(const std::string& form) {
  for (const auto& row : Study().rows) {
    if (row.at("form") == form) return row;
  }
  throw std::runtime_error("no such row: " + form);
}

// rms of the residual of a plain least-squares polynomial, by QR of its powers.
double PlainPolynomialRms(int degree) {
  const Record record = LowRateLog().log.record;
  const int rows = kRows - 1;  // under load
  Eigen::MatrixXd powers(rows, degree + 1);
  Eigen::VectorXd voltage_V(rows);
  for (int k = 0; k < rows; ++k) {
    const double x = 1.0 - 2.0 * (k + 1) / (kRows - 1);
    powers(k, 0) = 1.0;
    for (int j = 1; j <= degree; ++j) powers(k, j) = powers(k, j - 1) * x;
    voltage_V[k] = record.voltage_V[static_cast<std::size_t>(k) + 1];
  }
  const Eigen::VectorXd solution = powers.householderQr().solve(voltage_V);
  return (powers * solution - voltage_V).norm() / std::sqrt(double(rows));
}

TEST(StudyOcv, APolynomialIsTheOneOfPlainLeastSquares) {
  for (const int degree : {3, 5, 9}) {
    const auto& row = Row("polynomial, degree " + std::to_string(degree));
    EXPECT_NEAR(row.at("rmse_V").get<double>() / PlainPolynomialRms(degree), 1.0, 1e-9) << degree;
    EXPECT_EQ(row.at("parameters"), degree + 1);
  }
}

TEST(StudyOcv, FormsThatCanFollowReachTheNoiseOnRowsLeftOut) {
  // 500 rows are left out: their rms scatters by 1/sqrt(2*500) = 3 %.
  for (const char* form : {"polynomial, degree 5", "polynomial, degree 9", "linear, 100 nodes"}) {
    EXPECT_NEAR(Row(form).at("left_out_rmse_V").get<double>() / kNoise_V, 1.0, 4 * 0.032) << form;
  }
  EXPECT_GT(Row("polynomial, degree 3").at("left_out_rmse_V").get<double>(), 10.0 * kNoise_V);
}

TEST(StudyOcv, RowsLeftOutShowWhatTheFitHides) {
  // 400 nodes follow the noise of 5000 rows: in the fit they look better than the truth, a
  // polynomial of degree 5, and on the same held-out rows worse.
  const auto& nodes = Row("linear, 400 nodes");
  const auto& truth = Row("polynomial, degree 5");
  EXPECT_LT(nodes.at("rmse_V").get<double>(), 0.98 * truth.at("rmse_V").get<double>());
  EXPECT_GT(nodes.at("left_out_rmse_V").get<double>(),
            1.01 * truth.at("left_out_rmse_V").get<double>());
}

TEST(StudyOcv, CountsWhatACurveIsMadeOf) {
  EXPECT_EQ(Row("Fourier, 7 harmonics").at("parameters"), 16);  // a_0, 7 a, 7 b, the frequency
  EXPECT_LE(Row("linear, 50 nodes").at("parameters"), 50);
  EXPECT_GE(Row("linear, 50 nodes").at("parameters"), 45);
}

TEST(StudyOcv, TheChargeIsThatOfTheLog) {
  EXPECT_NEAR(Study().facts.at("charge_C").get<double>(), kCurrent_A * kStep_s * (kRows - 1), 1e-6);
}

// Interpolation row by row, which a short log would have, is none of the forms.
TEST(StudyOcv, FormsHaveTheirNodesHoweverShortTheLogIs) {
  LoadedLog log = LowRateLog();
  Record& record = log.log.record;
  for (auto* column : {&record.time_s, &record.current_A, &record.voltage_V}) {
    const std::vector<double> all = column->ToVector();
    column->clear();
    for (std::size_t k = 0; k < all.size(); k += 10) column->push_back(all[k]);
  }
  const KnownCampaign known(StudyCell({}), {log});
  const auto study = StudyOcv(OfLogsAlone(known), NoProgress);
  EXPECT_EQ(study.rows[0].at("form"), "linear, 25 nodes");
  EXPECT_EQ(study.rows[0].at("parameters"), 25);
  EXPECT_EQ(study.rows[1].at("parameters"), 50);
}

TEST(StudyOcv, RefusesWhatChangesNoForm) {
  const KnownCampaign known(StudyCell({}), {LowRateLog()});
  StudyInput input = OfLogsAlone(known);
  input.given.alpha_C = 1500.0;
  EXPECT_THROW(static_cast<void>(StudyOcv(input, NoProgress)), OptionError);
  input.given = {};
  input.options.pulses.branches = 3;
  EXPECT_THROW(static_cast<void>(StudyOcv(input, NoProgress)), OptionError);
}

TEST(StudyOcv, WithoutALowRateLogThereIsNothingToStudy) {
  const Cell cell = StudyCell({});
  const KnownCampaign known(cell, {test::PulseLog(cell)});
  EXPECT_THROW(static_cast<void>(StudyOcv(OfLogsAlone(known), NoProgress)), LoadError);
}

}  // namespace
}  // namespace lipoid
