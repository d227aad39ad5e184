#include "identify/health/unresolved_current.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "identify/logs/columns.h"

namespace lipoid::test {
namespace {

constexpr double kHover_A = 20.0;
constexpr double kWaver_A = 6.0;
constexpr std::size_t kTakeOff_s = 60;
constexpr std::size_t kSeconds = 400;
constexpr std::size_t kPerSecond = 20;

// Idle, then a hover whose current is another twentieth of a second by twentieth of a second.
Record Fly(std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  Record record;
  for (std::size_t k = 0; k < kSeconds * kPerSecond; ++k) {
    record.time_s.push_back(static_cast<double>(k) / static_cast<double>(kPerSecond));
    const bool flies = k >= kTakeOff_s * kPerSecond;
    record.current_A.push_back(flies ? kHover_A + kWaver_A * normal(engine) : 0.3);
  }
  record.hold = Hold::kForward;
  return record;
}

Record Every(const Record& record, std::size_t rows) {
  Record some;
  some.hold = record.hold;
  for (std::size_t k = 0; k < record.size(); k += rows) {
    some.time_s.push_back(record.time_s[k]);
    some.current_A.push_back(record.current_A[k]);
  }
  return some;
}

TEST(UnresolvedCurrent, IsNoneWhereTheValuesFollow) {
  Record record;
  for (int k = 0; k < 400; ++k) {
    record.time_s.push_back(k);
    record.current_A.push_back(k < 60 ? 0.0 : 20.0 + 5.0 * std::sin(0.1 * k));
  }
  EXPECT_FALSE(FindUnresolved(record, 1.0).any());
}

TEST(UnresolvedCurrent, IsNoneOfARecordOfAFewRows) {
  EXPECT_FALSE(FindUnresolved(Every(Fly(1), 400), 20.0).any());
}

// Of rows a second apart the mean since the row before is known to the deviation of a value, and the charge to that
// of the sum. Deviations by 31 values are right to a quarter.
TEST(UnresolvedCurrent, IsWhatValuesTooFarApartDoNotShow) {
  const Record seconds = Every(Fly(2), kPerSecond);
  const UnresolvedCurrent found = FindUnresolved(seconds, 1.0);
  ASSERT_TRUE(found.any());
  EXPECT_EQ(found.between_s, 1.0);
  double sum_A2 = 0.0;
  for (std::size_t k = 100; k < kSeconds; ++k) sum_A2 += std::pow(found.deviation_A[k], 2) / 300.0;
  EXPECT_NEAR(std::sqrt(sum_A2), kWaver_A, 0.2 * kWaver_A);
  for (std::size_t k = 0; k < 40; ++k) EXPECT_LT(found.deviation_A[k], 1e-9);
  EXPECT_NEAR(found.charge_C, kWaver_A * std::sqrt(340.0), 0.25 * kWaver_A * std::sqrt(340.0));
}

// Hold backward a value is that of the time before it, and the first of none.
TEST(UnresolvedCurrent, IsTheSameWhicheverWayValuesHold) {
  Record seconds = Every(Fly(5), kPerSecond);
  const UnresolvedCurrent forward = FindUnresolved(seconds, 1.0);
  seconds.hold = Hold::kBackward;
  const UnresolvedCurrent backward = FindUnresolved(seconds, 1.0);
  EXPECT_EQ(forward.deviation_A, backward.deviation_A);
  for (std::size_t k = 2; k < seconds.size(); ++k)
    EXPECT_EQ(forward.flowed_A[k], backward.flowed_A[k - 1]) << k;
  EXPECT_EQ(backward.flowed_A[0], seconds.current_A[0]);
}

// Of a hundred flights the charge that really flowed stays within what is said of it.
TEST(UnresolvedCurrent, TheChargeIsKnownToItsDeviation) {
  double squares = 0.0;
  constexpr int kFlights = 100;
  for (int flight = 0; flight < kFlights; ++flight) {
    const Record all = Fly(static_cast<std::uint64_t>(100 + flight));
    const Record seconds = Every(all, kPerSecond);
    const UnresolvedCurrent found = FindUnresolved(seconds, 1.0);
    const double true_C = DeliveredCharge(all)[(seconds.size() - 1) * kPerSecond];
    double flowed_C = 0.0;
    for (std::size_t k = 1; k < seconds.size(); ++k) flowed_C += found.flowed_A[k];
    squares += std::pow((flowed_C - true_C) / found.charge_C, 2) / kFlights;
  }
  // Of a hundred squares the root of the mean is known to 7 %.
  EXPECT_NEAR(std::sqrt(squares), 1.0, 0.25);
}

// What is held until the next value is in the mean since then with all its error; the neighbours' mean is nearer.
TEST(UnresolvedCurrent, WhatFlowedIsNearerThanAValueThatIsHeld) {
  const Record all = Fly(3);
  const Record seconds = Every(all, kPerSecond);
  const UnresolvedCurrent found = FindUnresolved(seconds, 1.0);
  const Column charge_C = DeliveredCharge(all);
  double held = 0.0, taken = 0.0, with_value = 0.0;
  for (std::size_t k = 100; k < kSeconds; ++k) {
    const double true_A = charge_C[k * kPerSecond] - charge_C[(k - 1) * kPerSecond];
    held += std::pow(seconds.current_A[k - 1] - true_A, 2) / 300.0;
    taken += std::pow(found.flowed_A[k] - true_A, 2) / 300.0;
    with_value += (found.flowed_A[k] - true_A) * (seconds.current_A[k - 1] - kHover_A) / 300.0;
  }
  EXPECT_NEAR(std::sqrt(held), kWaver_A, 0.15 * kWaver_A);
  EXPECT_LT(std::sqrt(taken), 0.55 * kWaver_A);
  EXPECT_LT(std::abs(with_value),
            0.4 * kWaver_A * kWaver_A);  // held, it would be 0.95 of that square
}

// The modes are orthonormal over the values, so that their squares sum to the variance of the charge that was asked for
// by all of them.
TEST(UnresolvedCurrent, ModesAreOrthogonalAndHoldTheCharge) {
  const Record seconds = Every(Fly(4), kPerSecond);
  const UnresolvedCurrent found = FindUnresolved(seconds, 1.0);
  const auto count = static_cast<int>(found.rows.size());
  const Eigen::MatrixXd modes = found.Modes(count);
  ASSERT_EQ(modes.rows(), static_cast<Eigen::Index>(seconds.size()));
  const Eigen::VectorXd charges_C = modes.colwise().sum();
  EXPECT_NEAR(charges_C.norm(), found.charge_C, 0.01 * found.charge_C);
  EXPECT_GT(charges_C.head(32).norm(), 0.97 * charges_C.norm());
  EXPECT_EQ(UnresolvedCurrent{}.Modes(32).cols(), 0);
}

}  // namespace
}  // namespace lipoid::test
