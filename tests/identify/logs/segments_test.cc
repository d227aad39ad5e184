#include "identify/logs/segments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>

#include "tests/support/paths.h"
#include "tests/support/plain_csv.h"
#include "tests/support/synthetic_record.h"

namespace lipoid {
namespace {

using test::CurrentStep;
using test::RecordOfSteps;

constexpr auto kRest = SegmentKind::kRest;
constexpr auto kConstant = SegmentKind::kConstantCurrent;
constexpr auto kPulse = SegmentKind::kPulse;
constexpr auto kVarying = SegmentKind::kVarying;

std::vector<SegmentKind> Kinds(const std::vector<Segment>& segments) {
  std::vector<SegmentKind> kinds;
  for (const Segment& segment : segments) kinds.push_back(segment.kind);
  return kinds;
}

std::ptrdiff_t Count(const std::vector<Segment>& segments,
                     SegmentKind kind,
                     double current_A,
                     double within_A) {
  return std::count_if(segments.begin(), segments.end(), [&](const Segment& segment) {
    return segment.kind == kind && std::abs(segment.current_A - current_A) <= within_A;
  });
}

// What the header promises for any record.
void ExpectCovers(const std::vector<Segment>& segments, const Record& record) {
  ASSERT_FALSE(segments.empty());
  EXPECT_EQ(segments.front().first, 0U);
  EXPECT_EQ(segments.back().last, record.size() - 1);
  EXPECT_EQ(segments.front().start_s, record.time_s.front());
  EXPECT_EQ(segments.back().end_s, record.time_s.back());
  double charge_C = 0.0;
  for (std::size_t k = 0; k < segments.size(); ++k) {
    ASSERT_LE(segments[k].first, segments[k].last);
    charge_C += segments[k].charge_C;
    if (k == 0) continue;
    EXPECT_EQ(segments[k].first, segments[k - 1].last + 1);
    EXPECT_EQ(segments[k].start_s, segments[k - 1].end_s);
  }
  const double moved_C = DeliveredCharge(record).back();
  EXPECT_NEAR(charge_C, moved_C, 1e-9 * (1.0 + std::abs(moved_C)));  // rounding of the sums
}

class SegmentsHolds : public testing::TestWithParam<Hold> {};
INSTANTIATE_TEST_SUITE_P(Both,
                         SegmentsHolds,
                         testing::Values(Hold::kBackward, Hold::kForward),
                         [](const auto& each) {
                           return each.param == Hold::kBackward ? "Backward" : "Forward";
                         });

TEST_P(SegmentsHolds, StartEndAndChargeOfEveryStepAreThoseOfTheSchedule) {
  // Rest, discharge, rest, charge, rest at 0.25 s to 60 s.
  const std::vector<CurrentStep> steps = {{600.0, 0.0, 60.0},
                                          {30.0, 3.0, 0.25},
                                          {1800.0, 0.0, 10.0},
                                          {10.0, -1.5, 0.25},
                                          {600.0, 0.0, 60.0}};
  const auto record = RecordOfSteps(steps, GetParam());
  const auto segments = FindSegments(record);
  ExpectCovers(segments, record);
  ASSERT_EQ(Kinds(segments), (std::vector{kRest, kPulse, kRest, kPulse, kRest}));
  double start_s = 0.0;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    EXPECT_EQ(segments[k].start_s, start_s) << k;  // quarters are exact in binary
    start_s += steps[k].duration_s;
    EXPECT_EQ(segments[k].end_s, start_s) << k;
    EXPECT_EQ(segments[k].charge_C, steps[k].current_A * steps[k].duration_s) << k;
    EXPECT_EQ(segments[k].current_A, steps[k].current_A) << k;
  }
}

TEST(Segments, OfAnEmptyRecordThereAreNone) { EXPECT_TRUE(FindSegments(Record{}).empty()); }

TEST(Segments, OfOneRow) {
  Record record;
  record.time_s = {5.0};
  record.current_A = {2.0};
  record.voltage_V = {3.7};
  const auto segments = FindSegments(record);
  ExpectCovers(segments, record);
  ASSERT_EQ(segments.size(), 1U);
  EXPECT_EQ(segments[0].charge_C, 0.0);
  EXPECT_EQ(segments[0].current_A, 2.0);
}

TEST(Segments, RecordAllAtRestIsOneRest) {
  const auto record = RecordOfSteps({{3600.0, 0.0, 1.0}});
  EXPECT_EQ(Kinds(FindSegments(record)), std::vector{kRest});
}

TEST(Segments, FullDischargeWithRestsIsConstantCurrent) {
  const auto record = RecordOfSteps({{60.0, 0.0}, {3600.0, 2.6}, {1800.0, 0.0}});
  EXPECT_EQ(Kinds(FindSegments(record)), (std::vector{kRest, kConstant, kRest}));
}

TEST(Segments, DischargeWithoutAnyRestIsConstantCurrent) {
  auto record = RecordOfSteps({{50.0, 2.6}});
  record.current_A[0] = 2.6;
  EXPECT_EQ(Kinds(FindSegments(record)), std::vector{kConstant});
}

TEST(Segments, OneRowAtCoarseSamplingIsAPulse) {
  const auto record = RecordOfSteps({{600.0, 0.0, 60.0}, {10.0, 2.0, 10.0}, {1200.0, 0.0, 60.0}});
  const auto segments = FindSegments(record);
  ASSERT_EQ(Kinds(segments), (std::vector{kRest, kPulse, kRest}));
  EXPECT_EQ(segments[1].charge_C, 20.0);
}

TEST(Segments, LowRateDischargeBesideAFastOneInOneFileIsNoRest) {
  // C/20 and 5C, as in a vendor file of several tests; the fast one is short against the record.
  const auto record = RecordOfSteps({{600.0, 0.0, 10.0},
                                     {720.0, 15.0},
                                     {3600.0, 0.0, 10.0},
                                     {10800.0, -1.0, 10.0},
                                     {3600.0, 0.0, 10.0},
                                     {72000.0, 0.15, 10.0},
                                     {600.0, 0.0, 10.0}});
  const auto segments = FindSegments(record);
  ASSERT_EQ(Kinds(segments),
            (std::vector{kRest, kConstant, kRest, kConstant, kRest, kConstant, kRest}));
  EXPECT_DOUBLE_EQ(segments[5].current_A, 0.15);
  EXPECT_DOUBLE_EQ(segments[3].current_A, -1.0);
}

TEST(Segments, StepsWithoutRestsAreVaryingOneByOne) {
  std::vector<CurrentStep> steps = {{120.0, 0.0, 10.0}};
  for (const double current_A : {4.9, 5.4, 0.8, 5.5, 3.8, 0.6, 1.7})
    steps.push_back({120.0, current_A, 10.0});
  const auto segments = FindSegments(RecordOfSteps(steps));
  ASSERT_EQ(segments.size(), steps.size());
  for (std::size_t k = 1; k < steps.size(); ++k) {
    EXPECT_EQ(segments[k].kind, kVarying) << k;
    EXPECT_DOUBLE_EQ(segments[k].current_A, steps[k].current_A);
  }
}

TEST(Segments, TaperAfterAChargeIsOneVaryingSegment) {
  auto record = RecordOfSteps({{600.0, 0.0, 10.0}, {5400.0, -2.0, 10.0}});
  const double start_s = record.time_s.back();
  for (int k = 1; k <= 300; ++k) {
    record.time_s.push_back(start_s + 10.0 * k);
    record.current_A.push_back(-2.0 * std::exp(-k / 100.0));
    record.voltage_V.push_back(4.2);
  }
  const auto segments = FindSegments(record);
  ExpectCovers(segments, record);
  ASSERT_EQ(Kinds(segments), (std::vector{kRest, kConstant, kVarying}));
  // The first rows of the taper differ by 1 % from the level and may be counted to it.
  EXPECT_NEAR(segments[2].start_s, start_s, 20.0);
}

TEST(Segments, TaperOfFewRowsIsNoEdgeOfTheChargeBeforeIt) {
  // Rows of 60 s: 6700 s at -15 A, then 1000 s down to -1.5 A; currents of 30 A elsewhere hide its
  // last slope.
  auto record = RecordOfSteps(
      {{600.0, 0.0, 60.0}, {3600.0, 30.0, 60.0}, {600.0, 0.0, 60.0}, {6720.0, -15.0, 60.0}});
  for (int k = 1; k <= 30; ++k) {
    record.time_s.push_back(record.time_s.back() + 60.0);
    record.current_A.push_back(-0.5 - 14.5 * std::exp(-k / 6.0));
    record.voltage_V.push_back(4.2);
  }
  const auto segments = FindSegments(record);
  ExpectCovers(segments, record);
  EXPECT_EQ(Kinds(segments), (std::vector{kRest, kConstant, kRest, kConstant, kVarying}));
}

TEST(Segments, DriveCycleIsOneVaryingSegmentBetweenItsRests) {
  auto record = RecordOfSteps({{600.0, 0.0}});
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> current(-2.0, 10.0);
  for (int k = 0; k < 1200; ++k) {
    record.time_s.push_back(record.time_s.back() + 1.0);
    record.current_A.push_back(k % 17 == 5 ? 0.0 : current(engine));
    record.voltage_V.push_back(3.7);
  }
  for (int k = 0; k < 600; ++k) {
    record.time_s.push_back(record.time_s.back() + 1.0);
    record.current_A.push_back(0.0);
    record.voltage_V.push_back(3.7);
  }
  const auto segments = FindSegments(record);
  ExpectCovers(segments, record);
  ASSERT_EQ(Kinds(segments), (std::vector{kRest, kVarying, kRest}));
  // A mean of 4 A with a deviation of 3.5 A: an edge is off by d rows with a chance of exp(-d / 6)
  // or so.
  EXPECT_NEAR(segments[1].start_s, 600.0, 40.0);
  EXPECT_NEAR(segments[1].end_s, 1800.0, 40.0);
}

TEST(Segments, SlowEdgeBelongsToItsLevel) {
  auto record = RecordOfSteps({{600.0, 0.0}, {100.0, 3.0}, {1000.0, 0.0}});
  record.current_A[601] = 1.2;  // the first rows of the load
  record.current_A[602] = 2.7;
  const auto segments = FindSegments(record);
  ASSERT_EQ(Kinds(segments), (std::vector{kRest, kPulse, kRest}));
  EXPECT_EQ(segments[1].first, 601U);
  EXPECT_EQ(segments[1].last, 700U);
}

TEST(Segments, CoarseInstrumentDoesNotCutLevels) {
  // Resolution 0.02 A: a last digit flickers at zero and at 1.31 A.
  auto record =
      RecordOfSteps({{300.0, 0.0}, {60.0, 1.31}, {600.0, 0.0}, {60.0, 1.31}, {600.0, 0.0}});
  std::mt19937 engine(3);
  std::normal_distribution<double> noise(0.0, 0.006);
  for (double& i : record.current_A) i = 0.02 * std::round((i + noise(engine)) / 0.02);
  const auto segments = FindSegments(record);
  ASSERT_EQ(Kinds(segments), (std::vector{kRest, kPulse, kRest, kPulse, kRest}));
  EXPECT_EQ(segments[1].first, 301U);
  EXPECT_EQ(segments[1].last, 360U);
}

TEST(Segments, RareFlickerOfTheZeroDoesNotCutRests) {
  auto record = RecordOfSteps({{1000.0, 0.0}, {60.0, 1.3}, {1000.0, 0.0}});
  for (const std::size_t k : {10U, 200U, 201U, 500U, 1500U}) record.current_A[k] = 0.02;
  EXPECT_EQ(Kinds(FindSegments(record)), (std::vector{kRest, kPulse, kRest}));
}

class SegmentsNoise : public testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Seeds, SegmentsNoise, testing::Range(1U, 11U));

TEST_P(SegmentsNoise, OfATwentiethOfTheCurrentMovesNoEdge) {
  const auto record = RecordOfSteps(
      {{60.0, 0.0, 0.1}, {30.0, 0.6, 0.1}, {600.0, 0.0, 0.1}, {30.0, 0.6, 0.1}, {600.0, 0.0, 0.1}},
      Hold::kBackward,
      0.03,
      GetParam());
  const auto segments = FindSegments(record);
  ASSERT_EQ(Kinds(segments), (std::vector{kRest, kPulse, kRest, kPulse, kRest}));
  // Half the step is ten deviations away: no row can be on the wrong side.
  EXPECT_EQ(segments[1].first, 601U);
  EXPECT_EQ(segments[1].last, 900U);
  EXPECT_EQ(segments[3].first, 6901U);
  EXPECT_EQ(segments[3].last, 7200U);
}

TEST_P(SegmentsNoise, NearlyAsLargeAsTheCurrentStillLeavesTheDischarge) {
  // A low-rate test of 50 mA with 20 mA of noise in every row.
  const auto record = RecordOfSteps(
      {{300.0, 0.0}, {40000.0, 0.05}, {3000.0, 0.0}}, Hold::kBackward, 0.02, GetParam());
  const auto segments = FindSegments(record);
  ASSERT_EQ(Kinds(segments), (std::vector{kRest, kConstant, kRest}));
  // The most likely edge is off by d rows with a chance of about exp(-d (0.05 / 0.02)² / 8): e^-9
  // at 12 rows.
  EXPECT_NEAR(segments[1].start_s, 300.0, 12.0);
  EXPECT_NEAR(segments[1].end_s, 40300.0, 12.0);
}

TEST(Segments, TenMillionRowsTakeWellUnderASecond) {
  // 27 hours at 10 ms: 30 s pulses with 29 min 30 s of rest, noise in both.
  std::vector<CurrentStep> steps;
  for (int k = 0; k < 56; ++k) {
    steps.push_back({30.0, 3.6, 0.01});
    steps.push_back({1770.0, 0.0, 0.01});
  }
  const auto record = RecordOfSteps(steps, Hold::kBackward, 0.005);
  ASSERT_GT(record.size(), 10'000'000U);
  const auto start = std::chrono::steady_clock::now();
  const auto segments = FindSegments(record);
  const double wall_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  RecordProperty("wall_s", std::to_string(wall_s));
  std::printf("%zu rows in %.3f s\n", record.size(), wall_s);
  EXPECT_EQ(Count(segments, kPulse, 3.6, 0.01), 56);
  EXPECT_EQ(segments.size(), 113U);
}

TEST(RestThreshold, LiesBetweenTheNoiseOfZeroAndTheLoad) {
  const auto record =
      RecordOfSteps({{600.0, 0.0}, {60.0, 4.0}, {600.0, 0.0}}, Hold::kBackward, 0.02);
  EXPECT_GT(RestThreshold(record), 3.0 * 0.02);
  EXPECT_LT(RestThreshold(record), 0.05 * 4.0);
}

TEST(SegmentsOfRealLogs, PulsesOfDmegcAreEleven) {
  const auto file = test::LabDataPath("dmegc_inr18650_26_r1/pulse.csv");
  LIPOID_SKIP_WITHOUT(file);
  const auto record = test::ReadPlainCsv(file);
  const auto segments = FindSegments(record);
  ExpectCovers(segments, record);
  EXPECT_EQ(Count(segments, kPulse, 1.3, 0.001), 11);
  for (const Segment& segment : segments) {
    if (segment.kind == kPulse) {
      EXPECT_DOUBLE_EQ(segment.duration_s(), 600.0);
    }
  }
}

TEST(SegmentsOfRealLogs, PulsesOfNissanAreTheSequenceOfItsReadme) {
  const auto file = test::LabDataPath("nissan_leaf_33ah/pulse.csv");
  LIPOID_SKIP_WITHOUT(file);
  const auto record = test::ReadPlainCsv(file);
  const auto segments = FindSegments(record);
  ExpectCovers(segments, record);
  // Per 10 % of charge: 1 h rest, 30 s at 30 A, 40 s rest, 10 s at -22.5 A, 18 min at 10 A. The
  // first regeneration runs into the voltage limit: it rises, holds 2 s and tapers.
  EXPECT_EQ(Count(segments, kPulse, 30.0, 0.01), 10);
  EXPECT_EQ(Count(segments, kPulse, -22.49, 0.01), 10);
  EXPECT_EQ(Count(segments, kPulse, 10.0, 0.01), 10);
  EXPECT_EQ(Count(segments, kRest, 0.0, 0.011), 20);
  EXPECT_EQ(Count(segments, kVarying, -20.0, 3.0), 2);
  EXPECT_EQ(segments.size(), 52U);
}

TEST(SegmentsOfRealLogs, RandomWalkOfDmegcIsTwentySteps) {
  const auto file = test::LabDataPath("dmegc_inr18650_26_r1/random_walk_01.csv");
  LIPOID_SKIP_WITHOUT(file);
  const auto segments = FindSegments(test::ReadPlainCsv(file));
  ASSERT_EQ(segments.size(), 21U);
  EXPECT_EQ(segments[0].kind, kRest);
  for (std::size_t k = 1; k < segments.size(); ++k) {
    EXPECT_EQ(segments[k].kind, kVarying) << k;
    if (k + 1 < segments.size()) {
      EXPECT_DOUBLE_EQ(segments[k].duration_s(), 120.0);
    }
  }
}

TEST(SegmentsOfRealLogs, DischargesAreARestRowAndOneLevel) {
  for (const char* name : {"nissan_leaf_33ah/cc_1c.csv",
                           "nissan_leaf_33ah/cc_3c.csv",
                           "nissan_leaf_33ah/low_rate.csv",
                           "dmegc_inr18650_26_r1/cc_0p5c.csv",
                           "dmegc_inr18650_26_r1/low_rate.csv",
                           "lg_m50_5ah/cc_2c.csv",
                           "lg_m50_5ah/low_rate.csv"}) {
    const auto file = test::LabDataPath(name);
    LIPOID_SKIP_WITHOUT(file);
    EXPECT_EQ(Kinds(FindSegments(test::ReadPlainCsv(file))), (std::vector{kRest, kConstant}))
        << name;
  }
}

}  // namespace
}  // namespace lipoid
