// The sign of the current: right or unclear, never wrong.
#include "identify/logs/current_sign.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/paths.h"
#include "tests/support/plain_csv.h"

namespace lipoid {
namespace {

// A cell of 30 mOhm and a slower 20 mOhm in 30 s on a straight open-circuit voltage, 2 Ah; by its
// own recurrence.
Record Simulate(const std::vector<double>& current_A,
                double interval_s,
                double noise_V,
                unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  Record record;
  double slow_V = 0.0;
  double charge_C = 0.0;
  for (std::size_t k = 0; k < current_A.size(); ++k) {
    const double i_A = current_A[k];
    charge_C += k > 0 ? i_A * interval_s : 0.0;
    slow_V += (0.02 * i_A - slow_V) * (1.0 - std::exp(-interval_s / 30.0));
    record.time_s.push_back(interval_s * static_cast<double>(k));
    record.current_A.push_back(i_A);
    record.voltage_V.push_back(4.0 - 0.8 * charge_C / 7200.0 - 0.03 * i_A - slow_V +
                               noise_V * noise(random));
  }
  return record;
}

std::vector<double> Profile(std::initializer_list<std::pair<int, double>> parts) {
  std::vector<double> current_A;
  for (const auto& [rows, i_A] : parts)
    current_A.insert(current_A.end(), static_cast<std::size_t>(rows), i_A);
  return current_A;
}

enum class Written { kAsItIs, kTurned, kUnsigned };

CurrentSign Find(Record record, Written how) {
  for (double& i : record.current_A)
    i = how == Written::kTurned ? -i : how == Written::kUnsigned ? std::abs(i) : i;
  return FindSignFromPhysics(record).sign;
}

TEST(CurrentSign, IsFoundFromTheVoltage) {
  const std::vector<std::vector<double>> profiles{
      Profile({{1, 0}, {1000, 2}}),                            // constant current from a rest row
      Profile({{1000, 2}}),                                    // and without one
      Profile({{10, 0}, {30, 6}, {60, 0}, {30, 6}, {60, 0}}),  // pulses
      Profile({{1000, -2}}),                                   // a charge
      Profile({{10, 0}, {30, 6}, {40, 0}, {10, -4}, {200, 2}, {60, 0}}),  // with regeneration
      Profile({{60, 0.5}, {60, 5}, {60, 1}, {60, 4}, {60, 0.2}, {60, 3}}),
  };
  for (const double noise_V : {0.0, 1e-4, 1e-3, 3e-3}) {
    for (std::size_t k = 0; k < profiles.size(); ++k) {
      SCOPED_TRACE(testing::Message() << "profile " << k << " noise " << noise_V);
      const Record record = Simulate(profiles[k], 1.0, noise_V, 1);
      EXPECT_EQ(Find(record, Written::kAsItIs), CurrentSign::kDischargePositive);
      EXPECT_EQ(Find(record, Written::kTurned), CurrentSign::kDischargeNegative);
    }
  }
}

// Up to a seventh of the load, which is what a cheap sensor adds to a low rate: steps from row to row that the
// voltage does not follow are none of a charge. An amount of both directions stays unclear.
TEST(CurrentSign, NoiseOfASteadyCurrentIsNoCharge) {
  for (const double noise_A : {0.003, 0.005, 0.01}) {
    for (unsigned seed = 1; seed <= 6; ++seed) {
      SCOPED_TRACE(testing::Message() << noise_A << " A, seed " << seed);
      std::mt19937_64 random(100 + seed);
      std::normal_distribution<double> noise(0.0, noise_A);
      const auto written = [&](std::initializer_list<std::pair<int, double>> parts) {
        Record record = Simulate(Profile(parts), 10.0, 2e-4, seed);
        for (double& i : record.current_A) i += noise(random);
        return record;
      };
      const Record discharge = written({{4000, 0.07}});
      EXPECT_EQ(Find(discharge, Written::kAsItIs), CurrentSign::kDischargePositive);
      EXPECT_EQ(Find(discharge, Written::kTurned), CurrentSign::kDischargeNegative);
      if (noise_A < 0.01) {  // more hides where the rests end
        EXPECT_EQ(Find(written({{60, 0.0}, {4000, 0.07}, {60, 0.0}}), Written::kAsItIs),
                  CurrentSign::kDischargePositive);
      }
      EXPECT_NE(Find(written({{2000, 0.07}, {2000, -0.07}}), Written::kUnsigned),
                CurrentSign::kDischargeNegative);
      EXPECT_EQ(Find(written({{2000, 0.07}, {2000, -0.07}}), Written::kUnsigned),
                CurrentSign::kUnclear);
    }
  }
}

TEST(CurrentSign, OfAnAmountAloneIsUnclear) {
  for (const auto& profile :
       {Profile({{10, 0}, {600, 2}, {100, 0}, {600, -2}, {10, 0}}),
        Profile({{10, 0}, {30, 6}, {40, 0}, {10, -4}, {40, 0}, {30, 6}, {40, 0}, {10, -4}}),
        Profile({{10, 0}, {900, 2}, {900, -2}})}) {
    EXPECT_EQ(Find(Simulate(profile, 1.0, 1e-4, 2), Written::kUnsigned), CurrentSign::kUnclear);
  }
}

// Of 60 mOhm in the cold, a third when it is warm: the voltage rises by 0.2 V under a load that goes on. Where the
// current changes its direction instead, and only its amount is written, it rises as much, but at once.
TEST(CurrentSign, ACellThatWarmsUnderItsLoadIsNoCharge) {
  const auto log = [](bool is_charged_after) {
    Record record;
    for (int k = 0; k < 300; ++k) {
      const double t_s = 5.0 * (k - 6);
      const bool loaded = k >= 6;
      const bool charged = is_charged_after && k >= 150;
      const double warm = 1.0 - std::exp(-std::max(t_s, 0.0) / 300.0);
      const double charge_C = 10.0 * std::max(0.0, t_s - (charged ? 2.0 * (t_s - 720.0) : 0.0));
      const double resistance_Ohm = is_charged_after ? 0.06 : 0.06 * (1.0 - 0.7 * warm);
      const double current_A = !loaded ? 0.0 : charged ? -10.0 : 10.0;
      record.time_s.push_back(5.0 * k);
      record.current_A.push_back(std::abs(current_A));
      record.voltage_V.push_back(4.2 - 0.5 * charge_C / 18000.0 - resistance_Ohm * current_A);
    }
    return record;
  };
  const Record warms = log(false);
  EXPECT_GT(warms.voltage_V[100], warms.voltage_V[6] + 0.2);
  EXPECT_EQ(Find(warms, Written::kAsItIs), CurrentSign::kDischargePositive);
  EXPECT_EQ(Find(warms, Written::kTurned), CurrentSign::kDischargeNegative);
  EXPECT_EQ(Find(log(true), Written::kAsItIs), CurrentSign::kUnclear);
}

// A charge that is held at its voltage from the first row on, and, after a rest or at once, a
// discharge; of either only the amount.
TEST(CurrentSign, OfAChargeHeldAtItsVoltageAndADischargeIsUnclear) {
  for (const double drop_V : {0.08, 0.2}) {
    for (const int rest_rows : {0, 30}) {
      Record record;
      const auto add = [&](double current_A, double voltage_V) {
        record.time_s.push_back(10.0 * static_cast<double>(record.size()));
        record.current_A.push_back(current_A);
        record.voltage_V.push_back(voltage_V);
      };
      for (int k = 0; k < 300; ++k) add(2.0 * std::exp(-k / 80.0), 4.2 + 1e-4 * (k % 2));
      const SignFinding held = FindSignFromPhysics(record);
      EXPECT_EQ(held.sign, CurrentSign::kUnclear);
      EXPECT_TRUE(held.contradictory) << "no other log may settle it";
      for (int k = 0; k < rest_rows; ++k) add(0.0, 4.195);
      for (int k = 0; k < 300; ++k) add(2.0, 4.2 - drop_V - 0.0033 * k);
      EXPECT_EQ(FindSignFromPhysics(record).sign, CurrentSign::kUnclear)
          << drop_V << " V, " << rest_rows << " rows of rest";
    }
  }
}

// Currents whose squares are 0 or infinite.
TEST(CurrentSign, IsFoundOfCurrentsOfAnySize) {
  for (const double scale : {1e-310, 1e-200, 1e200}) {
    Record record = Simulate(Profile({{1000, 1}}), 1.0, 0.0, 1);
    for (double& i : record.current_A) i *= scale;
    EXPECT_EQ(Find(record, Written::kAsItIs), CurrentSign::kDischargePositive) << scale;
    EXPECT_EQ(Find(record, Written::kTurned), CurrentSign::kDischargeNegative) << scale;
  }
}

TEST(CurrentSign, OfTooFewRowsIsUnclearBecauseOfThat) {
  EXPECT_EQ(FindSignFromPhysics(Simulate({0.0, 1.0}, 1.0, 0.0, 1)).reason,
            "a log of 2 rows is too short to show how the voltage moves with the current");
}

TEST(CurrentSign, OfNothingIsUnclear) {
  EXPECT_EQ(Find(Simulate(Profile({{100, 0}}), 1.0, 1e-3, 3), Written::kAsItIs),
            CurrentSign::kUnclear);
  // A current too small to move a noisy voltage.
  EXPECT_EQ(Find(Simulate(Profile({{100, 0}, {100, 0.001}}), 1.0, 1e-3, 3), Written::kAsItIs),
            CurrentSign::kUnclear);
}

// The recovery after a heavy load, under a light one, looks like charging.
TEST(CurrentSign, RecoveryIsNotTakenForACharge) {
  Record record = Simulate(Profile({{300, 6}, {40, 0.3}}), 1.0, 0.0, 4);
  Record tail;
  for (std::size_t k = 300; k < record.size(); ++k) {
    tail.time_s.push_back(record.time_s[k]);
    tail.current_A.push_back(record.current_A[k]);
    tail.voltage_V.push_back(record.voltage_V[k]);
  }
  ASSERT_GT(tail.voltage_V.back(), tail.voltage_V.front()) << "it does rise";
  EXPECT_EQ(Find(tail, Written::kAsItIs), CurrentSign::kUnclear);
}

// Windows of real logs whose discharge is known to be positive: cut anywhere, turned or not.
TEST(CurrentSign, IsNeverWrongOnWindowsOfRealLogs) {
  std::size_t found = 0;
  std::size_t tried = 0;
  for (const char* name : {"nissan_leaf_33ah/pulse.csv",
                           "nissan_leaf_33ah/cc_1c.csv",
                           "nissan_leaf_33ah/low_rate.csv",
                           "dmegc_inr18650_26_r1/pulse.csv",
                           "dmegc_inr18650_26_r1/random_walk_01.csv",
                           "lg_m50_5ah/cc_0p5c.csv",
                           "lg_m50_5ah/cc_2c.csv"}) {
    const std::string path = test::LabDataPath(name);
    LIPOID_SKIP_WITHOUT(path);
    const Record whole = test::ReadPlainCsv(path);
    std::mt19937_64 random(5);
    for (int round = 0; round < 300; ++round) {
      const std::size_t rows =
          3 +
          random() % (round % 2 ? std::min<std::size_t>(whole.size(), 300) - 3 : whole.size() - 3);
      const auto first = static_cast<std::ptrdiff_t>(random() % (whole.size() - rows + 1));
      const auto last = first + static_cast<std::ptrdiff_t>(rows);
      Record window;
      window.time_s = Column(whole.time_s.begin() + first, whole.time_s.begin() + last);
      window.current_A = Column(whole.current_A.begin() + first, whole.current_A.begin() + last);
      window.voltage_V = Column(whole.voltage_V.begin() + first, whole.voltage_V.begin() + last);
      ++tried;
      const auto as_it_is = Find(window, Written::kAsItIs);
      found += as_it_is == CurrentSign::kDischargePositive ? 1 : 0;
      EXPECT_NE(as_it_is, CurrentSign::kDischargeNegative)
          << name << " rows " << first << " + " << rows;
      EXPECT_NE(Find(window, Written::kTurned), CurrentSign::kDischargePositive)
          << name << " rows " << first << " + " << rows;
    }
  }
  EXPECT_GT(found, tried / 2) << "an answer that is always unclear is never wrong, and useless";
}

// A discharge from 4 to 3 V and the charge back, under amounts of current.
TEST(HasNoSign, OfACurrentUnderWhichTheVoltageGoesBothWays) {
  Record record;
  for (int k = 0; k < 40; ++k) {
    record.time_s.push_back(k);
    record.current_A.push_back(k == 20 ? 0.0 : 2.0);
    record.voltage_V.push_back(k < 20 ? 4.0 - 0.05 * k : 2.0 + 0.05 * k);
  }
  EXPECT_TRUE(HasNoSign(record));
  for (std::size_t k = 21; k < 40; ++k) record.current_A[k] = -2.0;
  EXPECT_FALSE(HasNoSign(record));
  // A lighter load under which a cold cell recovers.
  for (std::size_t k = 21; k < 40; ++k) {
    record.current_A[k] = 0.5;
    record.voltage_V[k] = 3.6 + 0.01 * static_cast<double>(k - 21);
  }
  EXPECT_FALSE(HasNoSign(record));
  record.voltage_V.clear();
  EXPECT_FALSE(HasNoSign(record));
}

TEST(CurrentSign, IsFoundFromStates) {
  Record record = Simulate(Profile({{2, 0}, {2, 2}, {2, 0}, {2, -1}}), 1.0, 0.0, 6);
  const std::vector<std::int8_t> states{0, 0, 1, 1, 0, 0, -1, -1};
  EXPECT_EQ(FindSignFromStates(record, states).sign, CurrentSign::kDischargePositive);
  EXPECT_EQ(FindSignFromStates(record, states).reason,
            "the state column says discharge where the current is positive (2 rows) and charge "
            "where the current is "
            "negative (2 rows)");
  for (double& i : record.current_A) i = -i;
  EXPECT_EQ(FindSignFromStates(record, states).sign, CurrentSign::kDischargeNegative);
  for (double& i : record.current_A) i = std::abs(i);
  EXPECT_EQ(FindSignFromStates(record, states).sign, CurrentSign::kUnsigned);
  record.current_A = {0, 0, 2, -2, 0, 0, 1, -1};
  EXPECT_EQ(FindSignFromStates(record, states).sign, CurrentSign::kUnclear);
  record.current_A = {
      0, 0, 2, 2, 2, 0, 1, 1};  // amounts, and one in a state that says no direction
  EXPECT_EQ(FindSignFromStates(record, states).sign, CurrentSign::kUnclear);
  EXPECT_EQ(FindSignFromStates(record, {}).sign, CurrentSign::kUnclear);
}

}  // namespace
}  // namespace lipoid
