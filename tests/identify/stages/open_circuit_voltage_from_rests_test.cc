#include "identify/stages/open_circuit_voltage_from_rests.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "identify/logs/discharge.h"
#include "identify/stages/open_circuit_voltage_file.h"
#include "model/battery/cell_file.h"
#include "model/core/errors.h"
#include "tests/support/load_error.h"
#include "tests/support/paths.h"
#include "tests/support/synthetic_campaign.h"

namespace lipoid {
namespace {

// Table 4.11 (1/beta² = 27 s) with a branch of 45 s, or another.
Cell TruthRelaxingIn(double time_constant_s = 45.0) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.branches = {{Resistance<double>(0.03), time_constant_s, time_constant_s / 0.03}};
  return cell;
}

// Pulses of load_s at current_A, one every period_s, until cut-off.
Record Pulses(const Cell& cell, double current_A, double load_s, double period_s) {
  return test::SimulateLog(
      cell,
      1.0,
      1e6,
      [=](double t) { return std::fmod(t - 1e-6, period_s) < load_s ? current_A : 0.0; },
      "pulses.csv");
}

// What the rests of one record give.
OcvFromRests Find(const Record& record, double alpha_C, double initial_soc = 1.0) {
  const auto segments = FindPulses(record);
  return FindOpenCircuitVoltageFromRests(
      {{.record = &record, .segments = &segments, .initial_soc = initial_soc}}, alpha_C);
}

// Half an hour is 40 time constants of the branch and 66 of the diffusion: e^-40 of 50 mV is
// nothing, and what is left is rounding.
constexpr double kSettled_V = 1e-9;

TEST(OpenCircuitVoltageFromRests, RestsOfHalfAnHourLieOnTheTruth) {
  const Cell truth = TruthRelaxingIn();
  const Record record = Pulses(truth, 0.6, 225.0, 2025.0);
  const OcvFromRests found = Find(record, truth.alpha_C());
  ASSERT_GE(found.rests.size(), 9U);
  EXPECT_NEAR(found.rests.back().soc, 1.0, 1e-12);  // the start
  for (const SettledRest& rest : found.rests) {
    EXPECT_NEAR(rest.voltage_V, truth.open_circuit_voltage(rest.soc), kSettled_V) << rest.soc;
    EXPECT_EQ(found.curve(rest.soc), rest.voltage_V);
  }
  EXPECT_LT(found.largest_drift_V, 1e-6);  // e^-20 of 50 mV is 0.1 uV
  // Every pulse takes 135 C.
  EXPECT_NEAR(found.rests[1].soc - found.rests[0].soc, 135.0 / truth.alpha_C(), 1e-12);
}

// A branch of half the rest has not settled: e^-2 of its drop is still to come, and the second half
// of the rest showed e^-1 - e^-2 of it, 1.7 times as much.
TEST(OpenCircuitVoltageFromRests, WhatIsStillToComeIsLessThanTheDriftItReports) {
  const double rest_s = 900.0;
  const Cell truth = TruthRelaxingIn(0.5 * rest_s);
  const Record record = Pulses(truth, 0.6, 225.0, 225.0 + rest_s);
  const OcvFromRests found = Find(record, truth.alpha_C());
  ASSERT_GE(found.rests.size(), 9U);
  for (std::size_t k = 0; k + 1 < found.rests.size(); ++k) {  // all but the start
    const SettledRest& rest = found.rests[k];
    const double left_V = truth.open_circuit_voltage(rest.soc) - rest.voltage_V;
    EXPECT_NEAR(rest.rest_s, rest_s, 1.0);
    EXPECT_GT(left_V, 5e-4) << rest.soc;
    EXPECT_LT(left_V, rest.drift_V) << rest.soc;
    // Straight lines through a quarter of the rest, half a time constant, miss the exponential by 1
    // to 2 % of what is left and of e times as much.
    EXPECT_NEAR(rest.drift_V / left_V, std::exp(1.0) - 1.0, 0.15) << rest.soc;
    EXPECT_NEAR(rest.slope_V_per_s / (left_V / (0.5 * rest_s)), 1.0, 0.35) << rest.soc;
    EXPECT_LE(rest.drift_V, found.largest_drift_V);
  }
}

// 1 mV of noise on every row: a line through the last quarter of 1,800 rows is known to
// 2 sigma/sqrt(450) = 0.1 mV at its end; a single row would miss 0.5 mV in two of three rests.
TEST(OpenCircuitVoltageFromRests, AveragesTheNoiseOfTheLastQuarter) {
  constexpr double kNoise_V = 0.001;
  const Cell truth = TruthRelaxingIn();
  Record record = Pulses(truth, 0.6, 225.0, 2025.0);
  std::mt19937_64 engine(7);
  std::normal_distribution<double> noise(0.0, kNoise_V);
  for (double& v : record.voltage_V) v += noise(engine);
  const OcvFromRests found = Find(record, truth.alpha_C());
  ASSERT_GE(found.rests.size(), 9U);
  for (std::size_t k = 0; k + 1 < found.rests.size(); ++k) {
    const SettledRest& rest = found.rests[k];
    EXPECT_NEAR(rest.voltage_V, truth.open_circuit_voltage(rest.soc), 0.5 * kNoise_V) << rest.soc;
    EXPECT_LT(std::abs(rest.drift_V), kNoise_V);
  }
}

// The last pulse runs into the cut-off without a rest behind it.
TEST(OpenCircuitVoltageFromRests, TwoGuessesEncloseTheTruthBelowTheLowestRest) {
  for (const double load_s : {150.0, 225.0, 270.0, 400.0}) {
    SCOPED_TRACE(load_s);
    const Cell truth = TruthRelaxingIn();
    const Record record = Pulses(truth, 0.6, load_s, load_s + 1800.0);
    const OcvFromRests found = Find(record, truth.alpha_C());
    ASSERT_TRUE(found.guessed_to_soc);
    const double end = *found.guessed_to_soc;
    ASSERT_LT(end, found.rests.front().soc - 0.01);
    EXPECT_EQ(found.curve.soc_lo(), end);
    // What it says of its error holds, and is not a mere excuse.
    EXPECT_GT(found.half_gap_V, 0.01);
    EXPECT_NEAR(found.curve(end), truth.open_circuit_voltage(end), found.half_gap_V);
    const auto& voltage_V = found.curve.voltage_V();
    EXPECT_TRUE(std::is_sorted(voltage_V.begin(), voltage_V.end()));
    EXPECT_GT(voltage_V.size(), found.rests.size() + 2);
  }
}

TEST(OpenCircuitVoltageFromRests, OfRestsAtOneStateOfChargeTheLongestCounts) {
  const Cell truth = TruthRelaxingIn(450.0);
  // Ten percent, half an hour of rest; a tenth of a percent, ten minutes of rest; and so on.
  const double long_s = 225.0 + 1800.0;
  const double period_s = long_s + 2.0 + 600.0;
  const Record record = test::SimulateLog(
      truth,
      1.0,
      1e6,
      [=](double t) {
        const double in_s = std::fmod(t - 1e-6, period_s);
        return in_s < 225.0 || (in_s >= long_s && in_s < long_s + 2.0) ? 0.6 : 0.0;
      },
      "pulses.csv");
  const OcvFromRests found = Find(record, truth.alpha_C());
  ASSERT_GE(found.rests.size(), 8U);
  for (std::size_t k = 0; k + 1 < found.rests.size(); ++k)
    EXPECT_NEAR(found.rests[k].rest_s, 1800.0, 2.0) << found.rests[k].soc;
}

TEST(OpenCircuitVoltageFromRests, StartsOfSeveralLogsAreRests) {
  const Cell truth = TruthRelaxingIn();
  std::vector<Record> records;
  std::vector<std::vector<Segment>> segments;
  std::vector<LogOfRests> logs;
  const std::vector<double> starts{0.9, 0.5, 0.2};
  for (const double soc : starts) {
    Record record;
    record.file = "pulse.csv";
    for (int k = 0; k <= 40; ++k) {
      record.time_s.push_back(k);
      record.current_A.push_back(k >= 1 && k <= 10 ? 1.2 : 0.0);
    }
    record.voltage_V = Predict(truth, record.time_s, record.current_A, record.hold, soc).voltage_V;
    records.push_back(record);
    segments.push_back(FindPulses(record));
  }
  for (std::size_t k = 0; k < starts.size(); ++k)
    logs.push_back({.record = &records[k], .segments = &segments[k], .initial_soc = starts[k]});
  const OcvFromRests found = FindOpenCircuitVoltageFromRests(logs, truth.alpha_C());
  ASSERT_EQ(found.rests.size(), 3U);
  for (const double soc : starts)
    EXPECT_NEAR(found.curve(soc), truth.open_circuit_voltage(soc), kSettled_V);
  EXPECT_FALSE(found.guessed_to_soc);
}

TEST(OpenCircuitVoltageFromRests, RefusesTooFewRestsAndSaysWhatItFound) {
  const Cell truth = TruthRelaxingIn();
  // Rests of four minutes: none counts but the start.
  const Record record = Pulses(truth, 0.6, 60.0, 300.0);
  EXPECT_EQ(test::LoadErrorOf([&] { static_cast<void>(Find(record, truth.alpha_C())); }),
            "pulses.csv:1:1: error: expected rests of at least 300 s at 3 or more states of "
            "charge, from which the open-circuit voltage follows where there is no low-rate log, "
            "found 1 (the rested start counts as one); add a low-rate log, or give the curve with "
            "--open-circuit-voltage FILE");
}

TEST(ChargeToCutoff, IsTheChargeOverTheStateOfChargeAtTheStart) {
  Record record;
  record.time_s = {0, 10, 20, 30, 40};
  record.current_A = {0, 2, 2, 2, 0};
  record.voltage_V = {4.2, 3.8, 3.4, 3.001, 3.3};
  const std::vector<Segment> segments;
  const auto charge = [&](double soc, double cutoff_V) {
    return ChargeToCutoff({{.record = &record, .segments = &segments, .initial_soc = soc}},
                          cutoff_V);
  };
  EXPECT_EQ(charge(1.0, 3.0), 60.0);
  EXPECT_EQ(charge(0.5, 3.0), 120.0);
  EXPECT_EQ(charge(1.0, 3.4), 40.0);
  EXPECT_FALSE(charge(1.0, 2.9));
}

// ---- a real cell at five ages -------------------------------------------------------------------

// The derived curve has the last record of each rest, rounded to 1 mV, and its charge in steps of
// whole pulses: half a millivolt, and 0.0001 of the charge at 1 V per unit. Their drift, up to
// 9 mV, is in both.
constexpr double kDerived_V = 0.001;

// alpha for which the rests of that record lie on that curve.
std::optional<AlphaOfRests> AlphaOf(const Record& record, const OpenCircuitVoltage& curve) {
  const auto segments = FindPulses(record);
  return FindAlphaOfRests({{.record = &record, .segments = &segments}}, curve);
}

TEST(OpenCircuitVoltageFromRests, SettledRestsTellTheAlphaOfAGivenCurve) {
  const Cell truth = TruthRelaxingIn();
  const auto found = AlphaOf(Pulses(truth, 0.6, 225.0, 2025.0), truth.open_circuit_voltage);
  ASSERT_TRUE(found);
  EXPECT_GE(found->rests, 8U);
  // 1 uV is e^-20 of what was dropped; v_oc rises by more than 0.1 V over the charge.
  EXPECT_NEAR(found->alpha_C, truth.alpha_C(), 1e-5 * truth.alpha_C());
  EXPECT_LT(found->error_C, 1e-4 * truth.alpha_C());
}

// e^-2 of the branch is still to come: rests lie below the curve, and alpha comes out too small.
TEST(OpenCircuitVoltageFromRests, AlphaOfRestsThatHaveNotSettledIsWithinItsError) {
  const double rest_s = 900.0;
  const Cell truth = TruthRelaxingIn(0.5 * rest_s);
  const auto found = AlphaOf(Pulses(truth, 0.6, 225.0, 225.0 + rest_s), truth.open_circuit_voltage);
  ASSERT_TRUE(found);
  EXPECT_LT(found->alpha_C, (1.0 - 1e-3) * truth.alpha_C());
  EXPECT_GT(found->alpha_C + found->error_C, truth.alpha_C());
  EXPECT_LT(found->error_C, 0.05 * truth.alpha_C());
}

TEST(OpenCircuitVoltageFromRests, RestsNearFullOrBeyondTheCurveTellNoAlpha) {
  const Cell truth = TruthRelaxingIn();
  Record record = Pulses(truth, 0.6, 225.0, 2025.0);
  const auto high = OpenCircuitVoltage::Linear({0.0, 1.0}, {4.3, 4.4});
  EXPECT_FALSE(AlphaOf(record, high));
  for (auto* column : {&record.time_s, &record.current_A, &record.voltage_V})
    column->resize(4 * 2025);  // four tenths of the charge
  EXPECT_FALSE(AlphaOf(record, truth.open_circuit_voltage));
}

TEST(OpenCircuitVoltageFromRests, NasaAsTheLastRecordsOfItsRestsHaveIt) {
  for (const int age : {1, 2, 3, 4, 5}) {
    const std::string folder = "nasa_rw26_ageing/age" + std::to_string(age) + "/";
    const auto file = test::LabDataPath(folder + "pulse.csv");
    LIPOID_SKIP_WITHOUT(file);
    SCOPED_TRACE(folder);
    const Record record = ReadLog(file).record;
    const auto segments = FindPulses(record);
    const std::vector<LogOfRests> logs{{.record = &record, .segments = &segments}};
    const auto alpha_C = ChargeToCutoff(logs, 3.2);
    ASSERT_TRUE(alpha_C);
    const OcvFromRests found = FindOpenCircuitVoltageFromRests(logs, *alpha_C);
    EXPECT_GE(found.rests.size(), 12U);
    EXPECT_LT(found.largest_drift_V, 0.010);
    const OpenCircuitVoltage derived =
        ReadOpenCircuitVoltageFile(test::LabDataPath(folder + "ocv_from_rests.csv"));
    std::size_t compared = 0;
    for (const double soc : derived.soc()) {
      if (soc < found.rests.front().soc - 1e-4) continue;
      EXPECT_NEAR(found.curve(soc), derived(soc), kDerived_V) << soc;
      ++compared;
    }
    EXPECT_EQ(compared, found.rests.size());
    // The two hours of rest after the test are not in this log: they judge the guess below it.
    EXPECT_NEAR(found.curve(0.0), derived(0.0), found.half_gap_V);
  }
}

}  // namespace
}  // namespace lipoid
