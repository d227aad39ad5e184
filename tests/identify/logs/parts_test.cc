#include "identify/logs/parts.h"

#include <gtest/gtest.h>

#include "identify/logs/gaps.h"
#include "tests/support/synthetic_record.h"

namespace lipoid {
namespace {

using test::RecordOfSteps;

std::vector<LogPart> Parts(const Record& record) {
  return FindParts(record, FindSegments(record), FindGaps(record));
}

TEST(Parts, LieBetweenRecharges) {
  const Record record = RecordOfSteps({{600.0, -2.0},
                                       {60.0, 0.0},
                                       {600.0, 2.0},
                                       {60.0, 0.0},
                                       {1200.0, -1.0},
                                       {60.0, 0.0},
                                       {300.0, 4.0}});
  const auto parts = Parts(record);
  ASSERT_EQ(parts.size(), 2U);
  // Row k closes second k; the rests before and after belong to the test.
  EXPECT_EQ(parts[0].first, 601U);
  EXPECT_EQ(parts[0].last, 1320U);
  EXPECT_EQ(parts[1].first, 2521U);
  EXPECT_EQ(parts[1].last, record.size() - 1);
  EXPECT_FALSE(parts[1].after_gap);
  const Record rows = RowsOf(record, parts[0]);
  EXPECT_EQ(rows.size(), 720U);
  EXPECT_EQ(rows.time_s.front(), 0.0);
  EXPECT_EQ(rows.time_s.back(), 719.0);
  EXPECT_EQ(rows.current_A[59], 0.0);
  EXPECT_EQ(rows.current_A[60], 2.0);
}

// Regeneration and the charging steps of a random walk put back little each time.
TEST(Parts, ADriveCycleStaysWhole) {
  std::vector<test::CurrentStep> steps;
  for (int k = 0; k < 20; ++k) {
    steps.push_back({60.0, 3.0});
    steps.push_back({30.0, -1.0});
  }
  EXPECT_TRUE(Parts(RecordOfSteps(steps)).empty());
  EXPECT_TRUE(Parts(RecordOfSteps({{60.0, 0.0}, {600.0, 2.0}})).empty());
  EXPECT_TRUE(Parts(Record{}).empty());
}

TEST(Parts, AGapBeginsAnother) {
  Record record = RecordOfSteps({{60.0, 0.0}, {600.0, 2.0}});
  for (std::size_t k = 300; k < record.size(); ++k) record.time_s[k] += 400.0;
  const auto parts = Parts(record);
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0].last, 299U);
  EXPECT_EQ(parts[1].first, 300U);
  EXPECT_FALSE(parts[0].after_gap);
  EXPECT_TRUE(parts[1].after_gap);
}

}  // namespace
}  // namespace lipoid
