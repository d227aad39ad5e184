#include "identify/stages/open_circuit_voltage_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "model/core/errors.h"
#include "tests/support/load_error.h"
#include "tests/support/paths.h"
#include "tests/support/plain_csv.h"
#include "tests/support/synthetic_record.h"

namespace lipoid {
namespace {

constexpr double kCurveAlpha_C = 10000.0;
// Sums of a few thousand rows in double precision, through a fit of moderate condition.
constexpr double kExact_V = 1e-9;

// A discharge from full at constant current in `rows` steps, after one row at rest; the voltage is
// that of the curve at the charge counted.
Record DischargeAlong(const std::function<double(double)>& curve,
                      int rows,
                      double from_soc = 1.0,
                      double to_soc = 0.0,
                      Hold hold = Hold::kBackward) {
  Record record;
  record.file = "low_rate.csv";
  record.hold = hold;
  constexpr double kCurrent_A = 0.5;
  const double step_s = (from_soc - to_soc) * kCurveAlpha_C / kCurrent_A / rows;
  for (int k = 0; k <= rows; ++k) {
    record.time_s.push_back(k * step_s);
    record.current_A.push_back(k == 0 && hold == Hold::kBackward ? 0.0 : kCurrent_A);
    record.voltage_V.push_back(curve(from_soc - kCurrent_A * k * step_s / kCurveAlpha_C));
  }
  return record;
}

double WorstDifference(const OpenCircuitVoltage& a,
                       const std::function<double(double)>& b,
                       double lo,
                       double hi) {
  double worst = 0.0;
  for (int k = 0; k <= 1000; ++k) {
    const double soc = lo + (hi - lo) * k / 1000;
    worst = std::max(worst, std::abs(a(soc) - b(soc)));
  }
  return worst;
}

// A knee at the empty end, a plateau, a rise: like a lithium-polymer cell, without a kink.
double Smooth(double soc) {
  return 3.7 + 0.4 * soc - 0.6 * std::exp(-30.0 * soc) + 0.05 * std::sin(6.0 * soc);
}

TEST(OcvFit, FindsAPolynomialAgain) {
  const auto truth = OpenCircuitVoltage::Polynomial(
      0.0, 1.0, {3.72, 0.45, -0.05, 0.08, -0.04, 0.03, -0.02, 0.015, -0.01, 0.005});
  for (const int rows : {200, 5000}) {
    const auto fit = FitOpenCircuitVoltage(
        DischargeAlong(truth, rows), kCurveAlpha_C, 1.0, {.method = OcvMethod::kPolynomial});
    EXPECT_EQ(fit.curve.method(), OcvMethod::kPolynomial);
    EXPECT_EQ(fit.curve.coefficients_V().size(), 10U);
    EXPECT_LT(WorstDifference(fit.curve, truth, 0.0, 1.0), kExact_V);
    EXPECT_LT(fit.errors.rmse, kExact_V);
    EXPECT_EQ(fit.rows, static_cast<std::size_t>(rows));
  }
  // Averages of 10 neighbours: v'' h²/24 with h = 1e-4 and v'' of at most 70 V at the ends.
  const auto many = FitOpenCircuitVoltage(
      DischargeAlong(truth, 100000), kCurveAlpha_C, 1.0, {.method = OcvMethod::kPolynomial});
  EXPECT_LT(WorstDifference(many.curve, truth, 0.0, 1.0), 1e-7);
}

TEST(OcvFit, FindsAFourierSeriesAgain) {
  const auto truth =
      OpenCircuitVoltage::Fourier(0.0, 1.0, 3.9, {3.7, -0.2, 0.02, 0.01}, {0.3, -0.05, 0.02});
  const auto fit = FitOpenCircuitVoltage(DischargeAlong(truth, 3000),
                                         kCurveAlpha_C,
                                         1.0,
                                         {.method = OcvMethod::kFourier, .harmonics = 3});
  EXPECT_EQ(fit.curve.method(), OcvMethod::kFourier);
  // The frequency is found by values of the cost, to 16 bits: their share of volts, well below 0.1
  // mV.
  EXPECT_LT(WorstDifference(fit.curve, truth, 0.0, 1.0), 1e-5);
  EXPECT_NEAR(fit.curve.frequency_rad(), 3.9, 1e-3);
  EXPECT_LT(fit.errors.rmse, 1e-5);
}

TEST(OcvFit, JoinsTheRowsOfAShortLog) {
  // Kinks at 0.2 and 0.7, which are rows of a log of 500.
  const auto truth = OpenCircuitVoltage::Linear({0.0, 0.2, 0.7, 1.0}, {3.0, 3.6, 3.8, 4.2});
  for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
    const auto fit =
        FitOpenCircuitVoltage(DischargeAlong(truth, 500, 1.0, 0.0, hold), kCurveAlpha_C, 1.0);
    EXPECT_LT(WorstDifference(fit.curve, truth, 0.0, 1.0), 1e-12);
    EXPECT_GE(fit.curve.soc().size(), 500U);
    EXPECT_DOUBLE_EQ(fit.curve.soc_hi(), 1.0);
    EXPECT_NEAR(fit.curve.soc_lo(), 0.0, 1e-12);
    // Rows left out lie on the lines between the others but beside a kink.
    EXPECT_LT(fit.errors.rmse, 1e-4);
    EXPECT_EQ(fit.current_A, 0.5);
    EXPECT_NEAR(fit.charge_C, kCurveAlpha_C, 1e-6);
  }
}

TEST(OcvFit, JoinsRowsUpToTheNumberThatIsAskedFor) {
  const auto record = DischargeAlong(Smooth, 600);
  EXPECT_GE(FitOpenCircuitVoltage(record, kCurveAlpha_C, 1.0, {.interpolate_up_to = 600})
                .curve.soc()
                .size(),
            600U);
  EXPECT_LE(FitOpenCircuitVoltage(record, kCurveAlpha_C, 1.0, {.interpolate_up_to = 599})
                .curve.soc()
                .size(),
            200U);
  EXPECT_LE(FitOpenCircuitVoltage(record, kCurveAlpha_C, 1.0, {.knots = 50, .interpolate_up_to = 0})
                .curve.soc()
                .size(),
            50U);
}

TEST(OcvFit, FitsNodesToALongLog) {
  // One straight line is of every such family.
  const auto line = [](double soc) { return 3.0 + 1.2 * soc; };
  for (const auto method : {OcvMethod::kLinear, OcvMethod::kMonotoneCubic}) {
    const auto fit =
        FitOpenCircuitVoltage(DischargeAlong(line, 20000), kCurveAlpha_C, 1.0, {.method = method});
    EXPECT_LT(WorstDifference(fit.curve, line, 0.0, 1.0), kExact_V);
    EXPECT_LT(fit.errors.rmse, kExact_V);
  }
  // Kinks lie between nodes: off by at most a quarter of the interval times the change of slope,
  // and only there.
  const auto kinked = OpenCircuitVoltage::Linear({0.0, 0.2, 0.7, 1.0}, {3.0, 3.6, 3.8, 4.2});
  const auto fit = FitOpenCircuitVoltage(DischargeAlong(kinked, 20000), kCurveAlpha_C, 1.0);
  double widest = 0.0;
  for (std::size_t k = 1; k < fit.curve.soc().size(); ++k) {
    widest = std::max(widest, fit.curve.soc()[k] - fit.curve.soc()[k - 1]);
  }
  EXPECT_LT(WorstDifference(fit.curve, kinked, 0.0, 1.0), 0.25 * widest * (3.0 - 0.4));
  EXPECT_LT(WorstDifference(fit.curve, kinked, 0.3, 0.6), 1e-6);
}

TEST(OcvFit, NodesRiseAndStandDenselyWhereTheCurveIsSteep) {
  const auto fit = FitOpenCircuitVoltage(DischargeAlong(Smooth, 50000), kCurveAlpha_C, 1.0);
  const auto& soc = fit.curve.soc();
  EXPECT_TRUE(std::is_sorted(soc.begin(), soc.end()));
  EXPECT_EQ(std::adjacent_find(soc.begin(), soc.end()), soc.end());
  const auto between = [&](double lo, double hi) {
    return std::count_if(soc.begin(), soc.end(), [&](double s) { return s >= lo && s < hi; });
  };
  EXPECT_GT(between(0.0, 0.1), 3 * between(0.5, 0.6));
  EXPECT_GE(between(0.5, 0.6), 5);
  EXPECT_LT(WorstDifference(fit.curve, Smooth, 0.0, 1.0), 1e-3);
}

TEST(OcvFit, ErrorsOnRowsLeftOutAreHonest) {
  constexpr double kNoise_V = 1e-3;
  Record record = DischargeAlong(Smooth, 20000);
  test::AddWhiteNoise(record, kNoise_V, 3);
  const auto seen = [&](const OpenCircuitVoltage& curve) {
    double squares = 0.0;
    for (int k = 1; k <= 20000; ++k) {
      squares +=
          std::pow(record.voltage_V[static_cast<std::size_t>(k)] - curve(1.0 - k / 20000.0), 2);
    }
    return std::sqrt(squares / 20000.0);
  };
  // 2000 rows are left out: their rms is known to 1/sqrt(4000) = 1.6 %.
  const auto few = FitOpenCircuitVoltage(record, kCurveAlpha_C, 1.0);
  EXPECT_NEAR(few.errors.rmse, kNoise_V, 0.05 * kNoise_V);
  EXPECT_NEAR(
      few.errors.mean_error_percent, 100.0 * kNoise_V * std::sqrt(2.0 / M_PI) / 3.85, 0.1 * 0.021);
  EXPECT_GT(few.errors.max_error_percent, 3.0 * kNoise_V / 3.85 * 100.0);
  const auto smooth = FitOpenCircuitVoltage(
      record, kCurveAlpha_C, 1.0, {.method = OcvMethod::kPolynomial, .degree = 25});
  EXPECT_NEAR(smooth.errors.rmse, kNoise_V, 0.05 * kNoise_V);
  // A node for every third row follows the noise it is shown, and is caught.
  const auto many = FitOpenCircuitVoltage(record, kCurveAlpha_C, 1.0, {.knots = 100000});
  EXPECT_LT(seen(many.curve), 0.9 * kNoise_V);
  EXPECT_GT(many.errors.rmse, 1.15 * kNoise_V);
}

TEST(OcvFit, LeavesOutRestRows) {
  const auto plain = DischargeAlong(Smooth, 2000);
  Record with_rests = plain;
  with_rests.time_s.clear();
  with_rests.current_A.clear();
  with_rests.voltage_V.clear();
  double shift_s = 0.0;
  for (std::size_t k = 0; k < plain.size(); ++k) {
    with_rests.time_s.push_back(plain.time_s[k] + shift_s);
    with_rests.current_A.push_back(plain.current_A[k]);
    with_rests.voltage_V.push_back(plain.voltage_V[k]);
    if (k % 500 != 0) continue;
    for (int rest = 1; rest <= 40; ++rest) {  // 40 minutes of rest, 0.1 V up
      with_rests.time_s.push_back(plain.time_s[k] + shift_s + 60.0 * rest);
      with_rests.current_A.push_back(0.0);
      with_rests.voltage_V.push_back(plain.voltage_V[k] + 0.1);
    }
    shift_s += 2400.0;
  }
  const auto fit = FitOpenCircuitVoltage(with_rests, kCurveAlpha_C, 1.0);
  EXPECT_EQ(fit.rows, 2000U);
  EXPECT_LT(WorstDifference(fit.curve, Smooth, 0.0, 1.0), 1e-3);
  EXPECT_LT(fit.errors.rmse, 1e-3);
}

TEST(OcvFit, CountsChargeThatComesBack) {
  // Every 100 rows five rows of charging at 1 A: A goes back, the rows under load see the same
  // curve again.
  for (const int interpolate_up_to : {0, 100000}) {
    Record record;
    record.file = "low_rate.csv";
    double soc = 1.0;
    for (int k = 0; soc > 0.0; ++k) {
      const double current_A = k == 0 ? 0.0 : k % 100 < 5 ? -1.0 : 0.5;
      if (k > 0) soc -= current_A * 10.0 / kCurveAlpha_C;
      record.time_s.push_back(10.0 * k);
      record.current_A.push_back(current_A);
      record.voltage_V.push_back(Smooth(soc) + (current_A < 0.0 ? 0.2 : 0.0));
    }
    const auto fit =
        FitOpenCircuitVoltage(record, kCurveAlpha_C, 1.0, {.interpolate_up_to = interpolate_up_to});
    EXPECT_LT(WorstDifference(fit.curve, Smooth, 0.01, 0.98), 1e-3);
    EXPECT_LT(fit.errors.rmse, 1e-3);
  }
}

TEST(OcvFit, StartsWhereTheLogStarts) {
  const auto fit =
      FitOpenCircuitVoltage(DischargeAlong(Smooth, 3000, 0.8, 0.1), kCurveAlpha_C, 0.8);
  EXPECT_NEAR(fit.curve.soc_hi(), 0.8, 1e-12);
  EXPECT_NEAR(fit.curve.soc_lo(), 0.1, 1e-9);
  EXPECT_NEAR(fit.charge_C, 0.7 * kCurveAlpha_C, 1e-6);
  EXPECT_LT(WorstDifference(fit.curve, Smooth, 0.1, 0.8), 1e-3);
}

TEST(OcvFit, MonotoneCubicNeverFallsWhateverTheNoise) {
  for (const int rows : {600, 20000}) {
    Record record = DischargeAlong(Smooth, rows);
    test::AddWhiteNoise(record, 0.01, 5);
    const auto fit =
        FitOpenCircuitVoltage(record, kCurveAlpha_C, 1.0, {.method = OcvMethod::kMonotoneCubic});
    double before = fit.curve(-0.1);
    for (int k = 1; k <= 20000; ++k) {
      const double voltage_V = fit.curve(-0.1 + 1.2 * k / 20000);
      EXPECT_GE(voltage_V, before - 1e-12) << k;  // rounding of the cubic
      before = voltage_V;
    }
    EXPECT_LT(WorstDifference(fit.curve, Smooth, 0.05, 0.95), 0.02);
  }
}

TEST(OcvFit, StaysFiniteAtHighDegrees) {
  Record record = DischargeAlong(Smooth, 5000);
  test::AddWhiteNoise(record, 1e-4, 6);
  const auto polynomial = FitOpenCircuitVoltage(
      record, kCurveAlpha_C, 1.0, {.method = OcvMethod::kPolynomial, .degree = 60});
  EXPECT_LT(WorstDifference(polynomial.curve, Smooth, 0.0, 1.0), 1e-3);
  EXPECT_TRUE(std::isfinite(polynomial.curve(-0.5)) && std::isfinite(polynomial.curve(1.5)));
  const auto fourier = FitOpenCircuitVoltage(
      record, kCurveAlpha_C, 1.0, {.method = OcvMethod::kFourier, .harmonics = 30});
  EXPECT_LT(WorstDifference(fourier.curve, Smooth, 0.0, 1.0), 5e-3);
}

TEST(OcvFit, CopesWithRowsThatStandTogether) {
  // Half the charge flows unseen, then 3000 rows see almost nothing of it.
  Record record;
  record.file = "low_rate.csv";
  record.time_s = {0.0};
  record.current_A = {0.0};
  record.voltage_V = {4.1};
  for (int k = 0; k < 3000; ++k) {
    record.time_s.push_back(10000.0 + 1e-4 * k);
    record.current_A.push_back(0.5);
    record.voltage_V.push_back(3.7 - 1e-6 * k);
  }
  for (const auto method : {OcvMethod::kLinear,
                            OcvMethod::kMonotoneCubic,
                            OcvMethod::kPolynomial,
                            OcvMethod::kFourier}) {
    const auto fit =
        FitOpenCircuitVoltage(record, kCurveAlpha_C, 1.0, {.method = method, .harmonics = 1});
    EXPECT_NEAR(fit.curve(fit.curve.soc_lo()), 3.7 - 0.003, 0.002);
    EXPECT_TRUE(std::isfinite(fit.curve(1.0)));
  }
}

TEST(OcvFit, TakesRowsAtAnyTimes) {
  // As loggers do that write when the voltage moved: rows bunch, and intervals between nodes may
  // hold few.
  std::mt19937 engine(4);
  std::exponential_distribution<double> wait(1.0);
  Record record;
  record.file = "low_rate.csv";
  double time_s = 0.0;
  for (int k = 0; time_s < 20000.0; ++k) {
    record.time_s.push_back(time_s);
    record.current_A.push_back(k == 0 ? 0.0 : 0.5);
    record.voltage_V.push_back(Smooth(1.0 - 0.5 * time_s / kCurveAlpha_C));
    time_s += 5.0 * wait(engine);
  }
  test::AddWhiteNoise(record, 1e-3, 8);
  for (const int knots : {200, 100000}) {
    const auto fit = FitOpenCircuitVoltage(record, kCurveAlpha_C, 1.0, {.knots = knots});
    EXPECT_LT(WorstDifference(fit.curve, Smooth, 0.001, 0.999), 0.03) << knots;
  }
}

TEST(OcvFit, RefusesALogOfTooFewRows) {
  const Record eleven = DischargeAlong(Smooth, 11);
  EXPECT_EQ(
      test::LoadErrorOf(
          [&] { static_cast<void>(FitOpenCircuitVoltage(eleven, kCurveAlpha_C, 1.0)); }),
      "low_rate.csv:1:1: error: expected at least 12 rows under load for this open-circuit voltage "
      "curve, found 11");
  EXPECT_NO_THROW(
      static_cast<void>(FitOpenCircuitVoltage(DischargeAlong(Smooth, 12), kCurveAlpha_C, 1.0)));
  EXPECT_EQ(
      test::LoadErrorOf([&] {
        static_cast<void>(FitOpenCircuitVoltage(
            DischargeAlong(Smooth, 29), kCurveAlpha_C, 1.0, {.method = OcvMethod::kPolynomial}));
      }),
      "low_rate.csv:1:1: error: expected at least 30 rows under load for this open-circuit "
      "voltage curve, found 29");
  EXPECT_EQ(test::LoadErrorOf([&] {
              static_cast<void>(FitOpenCircuitVoltage(
                  DischargeAlong(Smooth, 40), kCurveAlpha_C, 1.0, {.method = OcvMethod::kFourier}));
            }),
            "low_rate.csv:1:1: error: expected at least 45 rows under load for this open-circuit "
            "voltage curve, found 40");
  EXPECT_THROW(static_cast<void>(FitOpenCircuitVoltage(eleven, 0.0, 1.0)), PreconditionError);
}

TEST(OcvFit, OfRealLogsIsAsSharpAsTheInstrument) {
  const auto nissan = test::LabDataPath("nissan_leaf_33ah/low_rate_lead_compensated.csv");
  const auto dmegc = test::LabDataPath("dmegc_inr18650_26_r1/low_rate.csv");
  LIPOID_SKIP_WITHOUT(nissan);
  // 1 mV steps are 0.29 mV rms; rows at 60 s on the knee add to it.
  const auto leaf = FitOpenCircuitVoltage(test::ReadPlainCsv(nissan), 111739.59167, 1.0);
  EXPECT_LT(leaf.errors.rmse, 6e-4);
  EXPECT_LT(leaf.errors.mean_error_percent, 0.01);
  EXPECT_NEAR(leaf.charge_C, 108175.15, 0.1);
  EXPECT_NEAR(leaf.current_A, 2.17, 0.01);
  // 0.1 mV steps.
  const auto cell = FitOpenCircuitVoltage(test::ReadPlainCsv(dmegc), 9353.88696, 1.0);
  EXPECT_LT(cell.errors.rmse, 1e-4);
  EXPECT_LT(cell.errors.mean_error_percent, 0.002);
  EXPECT_NEAR(cell.charge_C, 9909.25, 0.1);
  EXPECT_NEAR(cell.curve.soc_lo(),
              -0.0594,
              1e-4);  // the times of the discharges say less than the slow one gave
}

}  // namespace
}  // namespace lipoid
