#include "identify/vehicle/bench_fit.h"

#include <gtest/gtest.h>

#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <tuple>

#include "model/core/errors.h"
#include "model/statistics/normal_noise.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

struct Truth {
  double k_T = 1.4e-5;
  double k_N = 1.9e-7;
  double k_e = 0.0104;
  double r = 0.12;
  double b = 1.2e-5;
  double switching = 0.0;
};

// A row as the motor's two equations have it, solved by bracketing: no closed form.
BenchRow RowAt(const Truth& t, double duty, double voltage_V) {
  const auto surplus = [&](double speed) {
    const double motor_A = (t.b * speed + t.k_N * speed * speed) / t.k_e;
    return duty * voltage_V - t.k_e * speed - t.r * motor_A;
  };
  std::uintmax_t iterations = 200;
  const auto bracket = boost::math::tools::toms748_solve(
      surplus, 0.0, 1e4, boost::math::tools::eps_tolerance<double>(52), iterations);
  const double speed = 0.5 * (bracket.first + bracket.second);
  const double motor_A = (t.b * speed + t.k_N * speed * speed) / t.k_e;
  const double switching = duty < 1.0 ? t.switching : 0.0;
  return {duty, voltage_V, (duty + switching) * motor_A, t.k_T * speed * speed, speed};
}

BenchTable Table(const Truth& truth, bool has_speed, double noise = 0.0, std::uint64_t seed = 0) {
  BenchTable table;
  table.has_speed = has_speed;
  NormalNoise normal(seed, 1);
  for (int k = 3; k <= 10; ++k) {
    BenchRow row = RowAt(truth, 0.1 * k, 16.6 - 0.03 * k);
    row.speed_rad_per_s *= 1.0 + 0.3 * noise * normal();
    row.current_A *= 1.0 + noise * normal();
    row.thrust_N *= 1.0 + 0.7 * noise * normal();
    if (!has_speed) row.speed_rad_per_s = 0.0;
    table.rows.push_back(row);
  }
  return table;
}

constexpr double kExact = 1e-6;  // relative, of a solver that stops at 1e-12

TEST(BenchFit, FindsAMotorWithoutNoise) {
  const Truth truth;
  const BenchFit fit = FitBenchTable(Table(truth, true), {});
  ASSERT_TRUE(fit.converged) << fit.message;
  EXPECT_NEAR(fit.thrust_coefficient_N_s2.estimate, truth.k_T, kExact * truth.k_T);
  EXPECT_NEAR(fit.torque_coefficient_N_m_s2.estimate, truth.k_N, 10 * kExact * truth.k_N);
  EXPECT_NEAR(fit.motor_constant_N_m_per_A.estimate, truth.k_e, kExact * truth.k_e);
  EXPECT_NEAR(fit.resistance_Ohm.estimate, truth.r, 10 * kExact * truth.r);
  EXPECT_NEAR(fit.friction_N_m_s.estimate, truth.b, 100 * kExact * truth.b);
  EXPECT_FALSE(fit.switching_share.fitted);
}

TEST(BenchFit, FindsItWithoutSpeedsFromItsConstant) {
  const Truth truth;
  const BenchFit fit = FitBenchTable(Table(truth, false), {.motor_constant_N_m_per_A = truth.k_e});
  ASSERT_TRUE(fit.converged) << fit.message;
  EXPECT_NEAR(fit.thrust_coefficient_N_s2.estimate, truth.k_T, 1e-4 * truth.k_T);
  EXPECT_NEAR(fit.torque_coefficient_N_m_s2.estimate, truth.k_N, 1e-3 * truth.k_N);
  EXPECT_NEAR(fit.resistance_Ohm.estimate, truth.r, 1e-3 * truth.r);
  EXPECT_FALSE(fit.motor_constant_N_m_per_A.fitted);
  EXPECT_EQ(fit.speed_rms, 0.0);
  EXPECT_EQ(test::MessageOf<OptionError>([&] { (void)FitBenchTable(Table(truth, false), {}); }),
            "a bench table without a column of speeds does not say how fast the propeller turns: "
            "give the motor's constant (--kv-rpm-per-V)");
}

TEST(BenchFit, FindsTheLossesOfSwitching) {
  Truth truth;
  truth.switching = 0.008;
  const BenchFit fit =
      FitBenchTable(Table(truth, true), {.motor_constant_N_m_per_A = truth.k_e, .switching = true});
  ASSERT_TRUE(fit.converged) << fit.message;
  EXPECT_NEAR(fit.switching_share.estimate, truth.switching, 1e-3 * truth.switching);
  EXPECT_NEAR(fit.resistance_Ohm.estimate, truth.r, 1e-3 * truth.r);
  // What is not there is not found: at its bound, without an error.
  truth.switching = 0.0;
  const BenchFit none =
      FitBenchTable(Table(truth, true), {.motor_constant_N_m_per_A = truth.k_e, .switching = true});
  EXPECT_NEAR(none.switching_share.estimate, 0.0, 1e-6);
}

// Before, one row gave every quantity with an interval of no width.
TEST(BenchFit, NeedsMoreValuesThanUnknowns) {
  const Truth truth;
  const BenchGiven given{.motor_constant_N_m_per_A = truth.k_e};
  BenchTable table = Table(truth, true, 0.01, 1);
  table.rows = {table.rows[2], table.rows[2], table.rows[2]};
  EXPECT_EQ(
      test::MessageOf<OptionError>([&] { (void)FitBenchTable(table, given); }),
      "the bench table has 1 operating point, and a fit of 4 numbers needs 2: give rows at other "
      "throttles, or leave --bench-table out and say what is known of motor and propeller");
  table.rows.back() = RowAt(truth, 0.9, 16.3);
  EXPECT_GT(FitBenchTable(table, given).degrees_of_freedom, 0.0);
  table.has_speed = false;
  EXPECT_THROW((void)FitBenchTable(table, given), OptionError);
}

// 95 % intervals of 100 tables with errors of 1 % hold the truth in 88 to 100 of them.
class BenchCoverage : public testing::TestWithParam<std::tuple<bool, bool>> {};

TEST_P(BenchCoverage, IntervalsHoldTheTruth) {
  const Truth truth;
  const auto [has_speed, friction_given] = GetParam();
  {
    std::map<std::string, int> held;
    double mean_rms = 0.0;
    const std::map<std::string, double> values{{"thrust_coefficient_N_s2", truth.k_T},
                                               {"torque_coefficient_N_m_s2", truth.k_N},
                                               {"armature_resistance_Ohm", truth.r},
                                               {"friction_N_m_s", truth.b}};
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
      const BenchFit fit =
          FitBenchTable(Table(truth, has_speed, 0.01, seed),
                        {.motor_constant_N_m_per_A = truth.k_e,
                         .friction_N_m_s = friction_given ? std::optional(truth.b) : std::nullopt});
      ASSERT_TRUE(fit.converged) << "seed " << seed << ": " << fit.message;
      for (const BenchQuantity& q : fit.Quantities()) {
        const auto value = values.find(q.name);
        if (value == values.end()) continue;
        // What is given is exact but for its scale.
        const double rounding = 1e-12 * value->second;
        if (q.low_95 - rounding <= value->second && value->second <= q.high_95 + rounding) {
          ++held[q.name];
        }
      }
      mean_rms += 0.01 * fit.current_rms;
    }
    for (const auto& [name, count] : held) {
      std::printf("%-26s %3d of 100 intervals hold the truth\n", name.c_str(), count);
      EXPECT_GE(count, 88) << name;
    }
    EXPECT_EQ(held.size(), values.size());
    EXPECT_NEAR(mean_rms, 0.01, 0.002);  // what was put in
  }
}

INSTANTIATE_TEST_SUITE_P(BenchFit,
                         BenchCoverage,
                         testing::Combine(testing::Bool(), testing::Bool()),
                         [](const auto& of) {
                           std::string name = std::get<0>(of.param) ? "Speeds" : "NoSpeeds";
                           return name +=
                                  std::get<1>(of.param) ? "FrictionGiven" : "FrictionFitted";
                         });

}  // namespace
}  // namespace lipoid
