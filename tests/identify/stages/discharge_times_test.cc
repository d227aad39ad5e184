#include "identify/stages/discharge_times.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "model/battery/discharge_time.h"
#include "model/core/errors.h"
#include "model/core/special_values.h"

namespace lipoid {
namespace {

constexpr double kLineAlpha_C = 10000.0;
constexpr double kLineBeta = 0.2;
const std::vector<double> kCurrents_A = {1.0, 2.0, 4.0, 6.0};

std::vector<DischargeTime> Times(const std::vector<double>& currents_A,
                                 double alpha_C,
                                 double beta,
                                 DischargeForm form = DischargeForm::kSteady) {
  std::vector<DischargeTime> times;
  for (const double current_A : currents_A) {
    times.push_back({.file = "cc.csv",
                     .current_A = current_A,
                     .time_s = form == DischargeForm::kSteady
                                   ? SteadyDischargeTime(alpha_C, beta, current_A)
                                   : ExactDischargeTime(alpha_C, beta, current_A)});
  }
  return times;
}

std::vector<DischargeTime> Noisy(std::vector<DischargeTime> times,
                                 double noise_s,
                                 std::mt19937& engine) {
  std::normal_distribution<double> normal;
  for (auto& d : times) d.time_s += noise_s * normal(engine);
  return times;
}

// Real discharges: charge over time, and the time, as an independent reader found them.
const std::vector<DischargeTime> kNissan = {
    {"cc_1c.csv", 30.6, 3568.8}, {"cc_2c.csv", 61.2, 1763.0}, {"cc_3c.csv", 91.798635, 1126.4}};
const std::vector<DischargeTime> kDmegc = {{"cc_0p5c.csv", 1.299899, 7125.0},
                                           {"cc_1c.csv", 2.600769, 3498.0},
                                           {"cc_2c.csv", 5.199746, 1735.0}};
const std::vector<DischargeTime> kLgM50 = {{"cc_0p5c.csv", 2.499827, 6973.04},
                                           {"cc_1c.csv", 4.999909, 3443.478},
                                           {"cc_2c.csv", 9.999869, 1749.554}};

// Cramer's rule for min sum w² (L - alpha/I + c)².
struct WeightedLine {
  double alpha_C, lag_s, alpha_error_C, lag_error_s;
};
WeightedLine Solve(const std::vector<DischargeTime>& times, bool relative) {
  long double aa = 0, ac = 0, cc = 0, ay = 0, cy = 0;
  for (const auto& d : times) {
    const long double w = relative ? 1.0L / d.time_s : 1.0L;
    const long double a = w / d.current_A;
    const long double c = -w;
    const long double y = w * d.time_s;
    aa += a * a, ac += a * c, cc += c * c, ay += a * y, cy += c * y;
  }
  const long double det = aa * cc - ac * ac;
  const long double alpha = (ay * cc - cy * ac) / det;
  const long double lag = (aa * cy - ac * ay) / det;
  long double squares = 0;
  for (const auto& d : times) {
    const long double w = relative ? 1.0L / d.time_s : 1.0L;
    const long double e = w * (d.time_s - alpha / d.current_A + lag);
    squares += e * e;
  }
  const long double variance = squares / static_cast<long double>(times.size() - 2);
  return {static_cast<double>(alpha),
          static_cast<double>(lag),
          static_cast<double>(std::sqrt(variance * cc / det)),
          static_cast<double>(std::sqrt(variance * aa / det))};
}

TEST(DischargeTimes, RecoverTheirTruthInBothForms) {
  for (const double beta : {0.05, 0.2, 0.9}) {
    for (const auto form : {DischargeForm::kSteady, DischargeForm::kExact}) {
      for (const auto weighting : {TimeWeighting::kSeconds, TimeWeighting::kRelative}) {
        const auto fit = FitDischargeTimes(Times(kCurrents_A, kLineAlpha_C, beta, form),
                                           {.form = form, .weighting = weighting});
        EXPECT_NEAR(fit.alpha_C, kLineAlpha_C, 1e-8 * kLineAlpha_C);
        // 1e-12 of 10 000 s in a lag that is 4 s at beta = 0.9.
        EXPECT_NEAR(fit.beta_per_sqrt_s, beta, 1e-7 * beta);
        EXPECT_TRUE(fit.identifiable) << fit.reason;
        EXPECT_EQ(fit.reason, "");
        EXPECT_EQ(fit.beta_start_per_sqrt_s, fit.beta_per_sqrt_s);
        EXPECT_LT(fit.errors.rmse, 1e-6);
      }
    }
  }
}

// A cell that begins with 0.7 of its charge lasts as long as one of 0.7 alpha that begins full.
TEST(DischargeTimes, KnowHowFullADischargeBegins) {
  const std::vector<double> starts{0.7, 1.0, 0.6, 0.8};
  for (const auto form : {DischargeForm::kSteady, DischargeForm::kExact}) {
    std::vector<DischargeTime> times;
    for (std::size_t k = 0; k < kCurrents_A.size(); ++k) {
      times.push_back(Times({kCurrents_A[k]}, starts[k] * kLineAlpha_C, kLineBeta, form).front());
      times.back().initial_soc = starts[k];
    }
    const auto fit = FitDischargeTimes(times, {.form = form});
    EXPECT_NEAR(fit.alpha_C, kLineAlpha_C, 1e-8 * kLineAlpha_C);
    EXPECT_NEAR(fit.beta_per_sqrt_s, kLineBeta, 1e-7 * kLineBeta);
    EXPECT_EQ(fit.rows[0].current_A, kCurrents_A[0]);
    EXPECT_LT(fit.errors.rmse, 1e-6);
  }
}

TEST(DischargeTimes, NeedTheExactFormWhereTheyAreShort) {
  // beta² L = 0.0025 * 311 s at 8 A: the steady form takes the missing charge for a larger beta.
  const auto times = Times({2.0, 3.0, 5.0, 8.0}, kLineAlpha_C, 0.05, DischargeForm::kExact);
  const auto exact = FitDischargeTimes(times, {.form = DischargeForm::kExact});
  EXPECT_NEAR(exact.beta_per_sqrt_s, 0.05, 1e-8);
  EXPECT_NEAR(exact.alpha_C, kLineAlpha_C, 1e-5);
  const auto steady = FitDischargeTimes(times);
  EXPECT_GT(std::abs(steady.beta_per_sqrt_s - 0.05), 0.005);
}

TEST(DischargeTimes, OfRealCellsAgreeWithNormalEquationsInLongDouble) {
  for (const auto& times : {kNissan, kDmegc}) {
    for (const bool relative : {false, true}) {
      const auto expected = Solve(times, relative);
      const auto fit = FitDischargeTimes(
          times, {.weighting = relative ? TimeWeighting::kRelative : TimeWeighting::kSeconds});
      EXPECT_NEAR(fit.alpha_C, expected.alpha_C, 1e-9 * expected.alpha_C);
      EXPECT_NEAR(fit.beta_per_sqrt_s, BetaOfSteadyLag(expected.lag_s), 1e-9);
      EXPECT_NEAR(
          fit.alpha_standard_error_C, expected.alpha_error_C, 1e-8 * expected.alpha_error_C);
      EXPECT_NEAR(fit.beta_standard_error_per_sqrt_s,
                  fit.beta_per_sqrt_s * expected.lag_error_s / (2.0 * expected.lag_s),
                  1e-9);
    }
  }
}

TEST(DischargeTimes, OfRealCellsAgreeWithAnotherImplementation) {
  const auto nissan = FitDischargeTimes(kNissan);
  EXPECT_NEAR(nissan.alpha_C, 111739.59167, 0.01);  // its currents are printed to 8 digits
  EXPECT_NEAR(nissan.beta_per_sqrt_s, 0.20430300, 1e-7);
  EXPECT_NEAR(nissan.alpha_standard_error_C, 1272.690, 0.01);
  EXPECT_NEAR(nissan.beta_standard_error_per_sqrt_s, 0.03630810, 1e-7);
  EXPECT_TRUE(nissan.identifiable);
  ASSERT_EQ(nissan.rows.size(), 3U);
  const double off_s[] = {4.002, -16.008, 12.006};
  const double off_percent[] = {0.112, 0.908, 1.066};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(nissan.rows[k].file, kNissan[k].file);
    EXPECT_EQ(nissan.rows[k].current_A, kNissan[k].current_A);
    EXPECT_EQ(nissan.rows[k].measured_s, kNissan[k].time_s);
    EXPECT_NEAR(nissan.rows[k].predicted_s - nissan.rows[k].measured_s, off_s[k], 6e-4);
    EXPECT_NEAR(nissan.rows[k].error_percent, off_percent[k], 6e-4);
  }
  EXPECT_NEAR(nissan.errors.mean_error_percent, (0.112 + 0.908 + 1.066) / 3.0, 6e-4);
  EXPECT_NEAR(nissan.errors.max_error_percent, 1.066, 6e-4);
  EXPECT_NEAR(nissan.errors.rmse,
              std::sqrt((4.002 * 4.002 + 16.008 * 16.008 + 12.006 * 12.006) / 3.0),
              1e-3);

  const auto dmegc = FitDischargeTimes(kDmegc);
  EXPECT_NEAR(dmegc.alpha_C, 9353.88696, 0.01);  // its currents are printed to 7 digits
  EXPECT_NEAR(dmegc.beta_per_sqrt_s, 0.20565672, 1e-6);
  EXPECT_NEAR(dmegc.beta_standard_error_per_sqrt_s, 0.04200049, 1e-6);

  // beta² L > 47: the exact form says the same.
  for (const auto& times : {kNissan, kDmegc}) {
    const auto exact = FitDischargeTimes(times, {.form = DischargeForm::kExact});
    const auto steady = FitDischargeTimes(times);
    EXPECT_NEAR(exact.alpha_C, steady.alpha_C, 1e-7 * steady.alpha_C);
    EXPECT_NEAR(exact.beta_per_sqrt_s, steady.beta_per_sqrt_s, 1e-6 * steady.beta_per_sqrt_s);
    EXPECT_NEAR(exact.alpha_standard_error_C,
                steady.alpha_standard_error_C,
                1e-5 * steady.alpha_standard_error_C);
    EXPECT_NEAR(exact.beta_standard_error_per_sqrt_s,
                steady.beta_standard_error_per_sqrt_s,
                1e-5 * steady.beta_standard_error_per_sqrt_s);
  }
}

// Simulated discharges of gifi-600mAh-1, 1C to 6C, to 3 V and to 3.5 V: the drop over 0.13 Ohm ends those, which the law
// does not know.
TEST(DischargeTimes, LeaveTheLawWhereTheDropEndsThem) {
  const auto leave = [](const std::vector<double>& times_s) {
    std::vector<DischargeTime> discharges;
    for (std::size_t k = 0; k < times_s.size(); ++k) {
      discharges.push_back(
          {.file = "cc.csv", .current_A = 0.6 * static_cast<double>(k + 1), .time_s = times_s[k]});
    }
    return FitDischargeTimes(discharges).LeaveTheLaw();
  };
  EXPECT_FALSE(leave({2155.3, 1027.3, 651.27, 461.98, 344.90, 265.36}));
  EXPECT_TRUE(leave({1957.4, 862.16, 446.42, 199.08, 81.282, 29.501}));
}

TEST(DischargeTimes, RelativeWeightsOfRealCells) {
  const auto fit = FitDischargeTimes(kNissan, {.weighting = TimeWeighting::kRelative});
  EXPECT_NEAR(fit.alpha_C, 112684.2294, 0.01);
  EXPECT_NEAR(fit.beta_per_sqrt_s, 0.18535704, 1e-7);
}

TEST(DischargeTimes, OfTheLgCellDoNotIdentifyBeta) {
  for (const auto form : {DischargeForm::kSteady, DischargeForm::kExact}) {
    const auto fit = FitDischargeTimes(kLgM50, {.form = form});
    EXPECT_FALSE(fit.identifiable);
    // 17431, 17217, 17495 C: the last is the largest.
    EXPECT_EQ(fit.reason,
              "the delivered charge does not fall with the current (1.743e+04 C at 2.5 A, 1.75e+04 "
              "C at 10 A)");
    EXPECT_NEAR(fit.alpha_C, 17443.756, 0.01);
    EXPECT_GT(fit.beta_lower_bound_per_sqrt_s, 0.0);
    EXPECT_GE(fit.beta_start_per_sqrt_s, fit.beta_lower_bound_per_sqrt_s);
    EXPECT_LE(fit.beta_start_per_sqrt_s, 1.0);
  }
  // The lag is 15.04164 s with a standard error of 46.27497 s and one degree of freedom, whose 95 %
  // quantile of Student's t is 6.313752: at most 307.2 s.
  const auto fit = FitDischargeTimes(kLgM50);
  EXPECT_NEAR(
      fit.beta_lower_bound_per_sqrt_s, BetaOfSteadyLag(15.04163 + 6.313752 * 46.27497), 1e-5);
  EXPECT_EQ(fit.beta_start_per_sqrt_s, 0.2);  // a typical value, above the bound of 0.103
}

TEST(DischargeTimes, DominatedByNoiseDoNotIdentifyBeta) {
  // Charges fall, but by less than their scatter: 82 s of lag and errors of +-150 s.
  auto times = Times({1.0, 1.5, 2.0, 3.0, 4.0}, kLineAlpha_C, kLineBeta);
  const double off_s[] = {0.0, 150.0, -150.0, 150.0, -150.0};
  for (std::size_t k = 0; k < times.size(); ++k) times[k].time_s += off_s[k];
  const auto fit = FitDischargeTimes(times);
  EXPECT_FALSE(fit.identifiable);
  const auto expected = Solve(times, false);
  ASSERT_GT(expected.lag_error_s, expected.lag_s);
  ASSERT_GT(expected.lag_s, 0.0);
  EXPECT_NE(fit.reason.find("standard error"), std::string::npos) << fit.reason;
  EXPECT_GE(fit.beta_start_per_sqrt_s, fit.beta_lower_bound_per_sqrt_s);
}

TEST(DischargeTimes, OfARisingChargeStandAtTheBoundOfBeta) {
  // 1 % more charge at four times the current: the unconstrained lag is negative.
  std::vector<DischargeTime> times = {{"a", 1.0, 10000.0}, {"b", 2.0, 5025.0}, {"c", 4.0, 2525.0}};
  for (const auto form : {DischargeForm::kSteady, DischargeForm::kExact}) {
    const auto fit = FitDischargeTimes(times, {.form = form});
    EXPECT_FALSE(fit.identifiable);
    EXPECT_DOUBLE_EQ(fit.beta_per_sqrt_s, 1.0);
    // alpha is the best for that beta: least squares of L + c = alpha/I.
    double numerator = 0.0;
    double denominator = 0.0;
    for (const auto& d : times) {
      numerator += (d.time_s + SteadyLag(1.0)) / d.current_A;
      denominator += 1.0 / (d.current_A * d.current_A);
    }
    EXPECT_NEAR(fit.alpha_C, numerator / denominator, 1e-6 * fit.alpha_C);
  }
}

// beta of the truth lies beyond its bound: no lag at all, where the fit holds one of 3.29 s.
TEST(DischargeTimes, AtTheBoundAlphaIsAsUncertainAsTheLag) {
  constexpr double kTwoSided95 = 1.96;
  for (const auto form : {DischargeForm::kSteady, DischargeForm::kExact}) {
    std::vector<DischargeTime> times;
    for (const double current_A : {3.6, 7.2, 10.8})
      times.push_back(
          {.file = "cc.csv", .current_A = current_A, .time_s = kLineAlpha_C / current_A});
    const auto result = FitDischargeTimes(times, {.form = form});
    EXPECT_FALSE(result.identifiable);
    EXPECT_GT(result.alpha_C - kLineAlpha_C, 10.0);
    EXPECT_GT(kTwoSided95 * result.alpha_standard_error_C, result.alpha_C - kLineAlpha_C);
    EXPECT_LT(kTwoSided95 * result.alpha_standard_error_C, 3.0 * (result.alpha_C - kLineAlpha_C));
    // Who says that there is no diffusion has the mean charge.
    const auto without = FitDischargeTimes(times, {.form = form}, {}, kInfinity);
    EXPECT_NEAR(without.alpha_C, kLineAlpha_C, 1e-9 * kLineAlpha_C);
    EXPECT_LT(without.alpha_standard_error_C, 1e-9 * kLineAlpha_C);
    EXPECT_EQ(without.degrees_of_freedom, 2);
    EXPECT_EQ(without.reason, "there is no diffusion");
    EXPECT_NEAR(without.rows[2].predicted_s, times[2].time_s, 1e-9 * times[2].time_s);
  }
}

// Times of beta = 0.2 with noise, and that beta given: alpha by hand, and its error from the scatter.
TEST(DischargeTimes, WithBetaGivenFindAlpha) {
  for (const auto form : {DischargeForm::kSteady, DischargeForm::kExact}) {
    auto times = Times(kCurrents_A, kLineAlpha_C, kLineBeta, form);
    const std::vector<double> noise_s{3.0, -2.0, 1.0, 2.5};
    double with_noise = 0.0, squares = 0.0;
    for (std::size_t k = 0; k < times.size(); ++k) {
      times[k].time_s += noise_s[k];
      with_noise += noise_s[k] / kCurrents_A[k];
      squares += 1.0 / (kCurrents_A[k] * kCurrents_A[k]);
    }
    const double off_C = with_noise / squares;
    double left_s2 = 0.0;
    for (std::size_t k = 0; k < times.size(); ++k)
      left_s2 += std::pow(noise_s[k] - off_C / kCurrents_A[k], 2);
    const auto result = FitDischargeTimes(times, {.form = form}, {}, kLineBeta);
    // The slope of the exact time in alpha differs from 1/I by some tenths of a per cent.
    EXPECT_NEAR(result.alpha_C, kLineAlpha_C + off_C, 0.01 * off_C);
    EXPECT_NEAR(result.alpha_standard_error_C, std::sqrt(left_s2 / 3.0 / squares), 0.01);
    EXPECT_DOUBLE_EQ(result.beta_per_sqrt_s, kLineBeta);
    EXPECT_DOUBLE_EQ(result.beta_start_per_sqrt_s, kLineBeta);
    const auto both = FitDischargeTimes(times, {.form = form}, kLineAlpha_C, kLineBeta);
    EXPECT_EQ(both.alpha_C, kLineAlpha_C);
    EXPECT_NEAR(both.rows[1].measured_s - both.rows[1].predicted_s, noise_s[1], 1e-6);
  }
}

TEST(DischargeTimes, OfTwoLogsHaveNoStandardErrors) {
  const auto fit = FitDischargeTimes(Times({1.0, 3.0}, kLineAlpha_C, kLineBeta));
  EXPECT_NEAR(fit.beta_per_sqrt_s, kLineBeta, 1e-9);
  EXPECT_TRUE(std::isnan(fit.alpha_standard_error_C));
  EXPECT_TRUE(std::isnan(fit.beta_standard_error_per_sqrt_s));
  EXPECT_EQ(fit.beta_lower_bound_per_sqrt_s, 0.0);  // none is implied
  EXPECT_TRUE(fit.identifiable);
}

TEST(DischargeTimes, WithAlphaGivenFindBetaFromOneLog) {
  const auto one = FitDischargeTimes(Times({2.0}, kLineAlpha_C, kLineBeta), {}, kLineAlpha_C);
  EXPECT_EQ(one.alpha_C, kLineAlpha_C);
  EXPECT_NEAR(one.beta_per_sqrt_s, kLineBeta, 1e-12);
  EXPECT_TRUE(one.identifiable);
  EXPECT_TRUE(std::isnan(one.beta_standard_error_per_sqrt_s));
  const auto exact =
      FitDischargeTimes(Times({2.0, 50.0}, kLineAlpha_C, kLineBeta, DischargeForm::kExact),
                        {.form = DischargeForm::kExact},
                        kLineAlpha_C);
  EXPECT_EQ(exact.alpha_C, kLineAlpha_C);
  EXPECT_EQ(exact.alpha_standard_error_C, 0.0);
  EXPECT_NEAR(exact.beta_per_sqrt_s, kLineBeta, 1e-8);
  // Less charge than the log delivered: beta cannot be found.
  const auto none = FitDischargeTimes({{"a", 2.0, 5100.0}}, {}, kLineAlpha_C);
  EXPECT_FALSE(none.identifiable);
  EXPECT_DOUBLE_EQ(none.beta_per_sqrt_s, 1.0);
  EXPECT_EQ(none.reason.find("nan"), std::string::npos) << none.reason;
}

TEST(DischargeTimes, StandardErrorsAreTheSpreadOfManyDraws) {
  // 2000 draws: the spread is known to 1/sqrt(4000) = 1.6 %, the mean of the estimated variances to
  // less.
  constexpr int kDraws = 2000;
  constexpr double kNoise_s = 4.0;
  for (const auto form : {DischargeForm::kSteady, DischargeForm::kExact}) {
    const auto truth =
        Times({1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0}, kLineAlpha_C, kLineBeta, form);
    std::mt19937 engine(20);
    double alpha = 0.0, alpha_squares = 0.0, beta = 0.0, beta_squares = 0.0, alpha_variance = 0.0,
           beta_variance = 0.0;
    const int draws = form == DischargeForm::kSteady ? kDraws : 400;
    for (int draw = 0; draw < draws; ++draw) {
      const auto fit = FitDischargeTimes(Noisy(truth, kNoise_s, engine), {.form = form});
      alpha += fit.alpha_C - kLineAlpha_C;
      alpha_squares += std::pow(fit.alpha_C - kLineAlpha_C, 2);
      beta += fit.beta_per_sqrt_s - kLineBeta;
      beta_squares += std::pow(fit.beta_per_sqrt_s - kLineBeta, 2);
      alpha_variance += std::pow(fit.alpha_standard_error_C, 2);
      beta_variance += std::pow(fit.beta_standard_error_per_sqrt_s, 2);
    }
    const double tolerance = 4.0 / std::sqrt(2.0 * draws);  // four deviations of a sample's spread
    EXPECT_NEAR(
        std::sqrt(alpha_variance / draws) / std::sqrt(alpha_squares / draws), 1.0, tolerance);
    // beta is curved in the lag: a lag of 82 +- 3 s makes 1 % more of it.
    EXPECT_NEAR(
        std::sqrt(beta_variance / draws) / std::sqrt(beta_squares / draws), 1.0, tolerance + 0.02);
    EXPECT_LT(std::abs(alpha / draws),
              4.0 * std::sqrt(alpha_squares / draws) / std::sqrt(1.0 * draws));
    EXPECT_LT(std::abs(beta / draws),
              4.0 * std::sqrt(beta_squares / draws) / std::sqrt(1.0 * draws) + 0.002);
  }
}

TEST(DischargeTimes, BoundHoldsInNineteenOfTwentyDraws) {
  constexpr int kDraws = 4000;
  // Large noise too: the bound must hold where beta is not identifiable, cut off at beta = 1 as it
  // is.
  for (const double noise_s : {5.0, 60.0}) {
    const auto truth = Times(kCurrents_A, kLineAlpha_C, kLineBeta);
    std::mt19937 engine(7);
    int covered = 0;
    for (int draw = 0; draw < kDraws; ++draw) {
      covered +=
          FitDischargeTimes(Noisy(truth, noise_s, engine)).beta_lower_bound_per_sqrt_s <= kLineBeta;
    }
    // Binomial: 95 % +- 3 * 0.34 %; a negative lag is lifted to 0, which can only widen the bound.
    EXPECT_GE(covered, 0.94 * kDraws) << noise_s;
    if (noise_s < 10.0) {
      EXPECT_LE(covered, 0.96 * kDraws);
    }
  }
}

TEST(DischargeTimes, RepeatsAreOneCurrent) {
  const std::vector<DischargeTime> repeats = {{"a", 30.6, 3568.8},
                                              {"b", 30.6, 3564.0},
                                              {"c", 30.59, 3570.0},
                                              {"d", 61.2, 1763.0},
                                              {"e", 61.21, 1759.0}};
  EXPECT_EQ(CountDifferentCurrents(repeats), 2);
  EXPECT_EQ(CountDifferentCurrents({repeats[0], repeats[1], repeats[2]}), 1);
  EXPECT_EQ(CountDifferentCurrents({}), 0);
  EXPECT_THROW(static_cast<void>(FitDischargeTimes({repeats[0], repeats[1]})), PreconditionError);
  const auto fit = FitDischargeTimes(repeats);
  EXPECT_NEAR(fit.alpha_C, Solve(repeats, false).alpha_C, 1e-4);
  EXPECT_TRUE(fit.identifiable);
  EXPECT_EQ(fit.rows.size(), 5U);
  // 2 % is the border.
  EXPECT_EQ(CountDifferentCurrents({{"a", 1.0, 1.0}, {"b", 1.019, 1.0}}), 1);
  EXPECT_EQ(CountDifferentCurrents({{"a", 1.0, 1.0}, {"b", 1.021, 1.0}}), 2);
}

TEST(DischargeTimes, DoNotDependOnTheirOrder) {
  auto reversed = kNissan;
  std::swap(reversed[0], reversed[2]);
  const auto fit = FitDischargeTimes(kNissan);
  const auto other = FitDischargeTimes(reversed);
  EXPECT_NEAR(fit.alpha_C, other.alpha_C, 1e-9 * fit.alpha_C);
  EXPECT_NEAR(fit.beta_per_sqrt_s, other.beta_per_sqrt_s, 1e-9);
  EXPECT_EQ(fit.identifiable, other.identifiable);
}

TEST(DischargeTimes, RefuseWhatHasNoMeaning) {
  EXPECT_THROW(static_cast<void>(FitDischargeTimes({})), PreconditionError);
  EXPECT_THROW(static_cast<void>(FitDischargeTimes({{"a", 1.0, 100.0}, {"b", -2.0, 50.0}})),
               PreconditionError);
  EXPECT_THROW(static_cast<void>(FitDischargeTimes({{"a", 1.0, 100.0}, {"b", 2.0, 0.0}})),
               PreconditionError);
  EXPECT_THROW(static_cast<void>(FitDischargeTimes({{"a", 1.0, 100.0}})), PreconditionError);
}

TEST(DischargeTimesOptions, AreSetByName) {
  DischargeTimesOptions options;
  EXPECT_EQ(options.form, DischargeForm::kSteady);
  EXPECT_EQ(options.weighting, TimeWeighting::kSeconds);
  SetOption(options, "form", "exact");
  SetOption(options, "weighting", "relative");
  EXPECT_EQ(options.form, DischargeForm::kExact);
  EXPECT_EQ(options.weighting, TimeWeighting::kRelative);
  EXPECT_THROW(SetOption(options, "form", "approximate"), OptionError);
}

// A log of twice the weight counts as two, and one of next to none has no say.
TEST(DischargeTimes, CountByTheirWeights) {
  for (const auto form : {DischargeForm::kSteady, DischargeForm::kExact}) {
    auto weighted = Times(kCurrents_A, kLineAlpha_C, kLineBeta, form);
    weighted[1].time_s += 20.0;
    weighted[3].time_s -= 5.0;
    auto repeated = weighted;
    repeated.push_back(weighted[1]);
    weighted[1].weight = 2.0;
    const auto one = FitDischargeTimes(weighted, {.form = form});
    const auto two = FitDischargeTimes(repeated, {.form = form});
    constexpr double kSolver = 1e-6;
    EXPECT_NEAR(one.alpha_C / two.alpha_C, 1.0, kSolver);
    EXPECT_NEAR(one.beta_per_sqrt_s / two.beta_per_sqrt_s, 1.0, kSolver);
    weighted[1].weight = weighted[3].weight = 1e-6;
    const auto without = FitDischargeTimes(weighted, {.form = form});
    EXPECT_NEAR(without.alpha_C / kLineAlpha_C, 1.0, 1e-4);
    EXPECT_GT(std::abs(two.alpha_C / kLineAlpha_C - 1.0), 1e-4);
  }
}

}  // namespace
}  // namespace lipoid
