#include "identify/logs/stuck_voltage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <regex>
#include <string>

#include "tests/support/synthetic_record.h"

namespace lipoid {
namespace {

// Rests and discharges at 2 A and 1 A, each of 300 s, with a slope of 0.1 mV for each ampere and second.
Record Discharges() {
  Record record = test::RecordOfSteps(
      {{300.0, 0.0}, {300.0, 2.0}, {300.0, 0.0}, {300.0, 1.0}, {300.0, 2.0}, {300.0, 0.0}});
  double charge_C = 0.0;
  for (std::size_t k = 0; k < record.size(); ++k) {
    charge_C += record.current_A[k];
    record.voltage_V[k] += 0.5 - 1e-4 * charge_C;
  }
  return record;
}

Record Noisy() {
  Record record = Discharges();
  test::AddWhiteNoise(record, 5e-4, 1);
  return record;
}

bool Matches(const std::string& said, const char* pattern) {
  return std::regex_match(said, std::regex(pattern));
}

// Values of a sensor of such steps.
Record InSteps(Record record, double step_V) {
  for (double& v : record.voltage_V) v = step_V * std::round(v / step_V);
  return record;
}

TEST(StuckVoltage, ASensorAtTheEndOfItsRangeIsSaid) {
  for (Record record : {Noisy(), InSteps(Noisy(), 1e-3)}) {
    EXPECT_EQ(DoubtAboutStuckVoltage(record), "");
    for (double& v : record.voltage_V) v = std::min(v, 4.07);
    const std::string said = DoubtAboutStuckVoltage(record);
    EXPECT_TRUE(Matches(
        said,
        "the voltage shows 4\\.07 V from 0 to 4\\d\\d s, while the current moves by 2 A, which elsewhere "
        "moves it by [0-9.]+ mV, and once more: it was not measured there \\(a sensor at the end of its "
        "range, or one that is not read anew\\), and these rows bend what is found, unless a part is "
        "read without them \\(start_s, end_s\\)"))
        << said;
  }
}

TEST(StuckVoltage, AValueThatIsRepeatedUntilTheVoltageJumpsIsSaid) {
  Record record = Noisy();
  for (const std::size_t from : {350U, 1000U, 1250U}) {
    for (std::size_t k = from; k < from + 150; ++k) record.voltage_V[k] = record.voltage_V[from];
  }
  const std::string said = DoubtAboutStuckVoltage(record);
  EXPECT_TRUE(Matches(
      said,
      "the voltage shows 4\\.09\\d+ V from 350 to 499 s, and then jumps by (29|30|31)\\.?\\d* mV, while "
      "the current does not, and 2 times more: it was not measured there .*"))
      << said;
}

// A slow discharge by coarse steps; a meter that is read every 25 s; rests; a voltage that is held by a charger, or by
// a load while the current falls.
TEST(StuckVoltage, WhatStandsByItselfIsNotStuck) {
  EXPECT_EQ(DoubtAboutStuckVoltage(InSteps(Noisy(), 0.02)), "");
  EXPECT_EQ(DoubtAboutStuckVoltage(InSteps(Discharges(), 0.02)), "");
  EXPECT_EQ(DoubtAboutStuckVoltage(Discharges()), "");  // whose rests show one value each
  Record slow = Noisy();
  for (std::size_t k = 0; k < slow.size(); ++k) slow.voltage_V[k] = slow.voltage_V[k / 25 * 25];
  EXPECT_EQ(DoubtAboutStuckVoltage(slow), "");
  for (const double sign : {1.0, -1.0}) {
    Record held = Noisy();
    for (std::size_t k = 900; k < held.size(); ++k) {
      held.current_A[k] = sign * 2.0 * std::exp(-static_cast<double>(k - 900) / 200.0);
      held.voltage_V[k] = sign > 0.0 ? 3.0 : 4.2;
    }
    EXPECT_EQ(DoubtAboutStuckVoltage(held), "") << sign;
  }
}

}  // namespace
}  // namespace lipoid
