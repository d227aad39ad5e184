#include "identify/logs/unlike_discharges.h"

#include <gtest/gtest.h>

namespace lipoid {
namespace {

TEST(UnlikeDischarges, NamesTheTwoThatAreFarthestApart) {
  const std::string doubt = DoubtAboutDischarges({{"new.csv", 2.9, 10080.0},
                                                  {"repeat.csv", 2.91, 9936.0},
                                                  {"aged.csv", 2.89, 8503.2},
                                                  {"fast.csv", 5.8, 7200.0}});
  EXPECT_EQ(
      doubt.find("at 2.9 A new.csv delivers 2.8 Ah until the cut-off and aged.csv 2.362 Ah: look"),
      0U)
      << doubt;
}

TEST(UnlikeDischarges, RepeatsOtherCurrentsAndOtherTemperaturesAreNone) {
  EXPECT_EQ(DoubtAboutDischarges({}), "");
  EXPECT_EQ(DoubtAboutDischarges({{"a.csv", 1.0, 1000.0}, {"b.csv", 1.0, 1049.0}}), "");
  EXPECT_EQ(DoubtAboutDischarges({{"a.csv", 1.0, 1200.0}, {"b.csv", 1.04, 1000.0}}), "");
  EXPECT_EQ(DoubtAboutDischarges({{"a.csv", 1.0, 1000.0, 0.0}, {"b.csv", 1.0, 1200.0, 25.0}}), "");
  EXPECT_NE(DoubtAboutDischarges({{"a.csv", 1.0, 1000.0, 24.0}, {"b.csv", 1.0, 1200.0, 25.0}}), "");
  EXPECT_NE(DoubtAboutDischarges({{"a.csv", 1.0, 1000.0}, {"b.csv", 1.0, 1200.0, 25.0}}), "");
}

// Two cells, or two scales of the current: of one cell the slower one delivers more.
TEST(UnlikeDischarges, ASlowerOneThatDeliversLessIsOne) {
  EXPECT_EQ(DoubtAboutDischarges({{"slow.csv", 1.0, 1000.0}, {"fast.csv", 2.0, 1090.0}}), "");
  const std::string doubt =
      DoubtAboutDischarges({{"slow.csv", 2.6, 9097.0}, {"fast.csv", 5.0, 17217.0}});
  EXPECT_EQ(doubt.find("at 5 A fast.csv delivers 4.782 Ah until the cut-off and at 2.6 A only "
                       "slow.csv 2.527 Ah: look"),
            0U)
      << doubt;
  // In the cold a fast discharge warms the cell.
  EXPECT_EQ(
      DoubtAboutDischarges({{"slow.csv", 1.0, 1000.0, -10.0}, {"fast.csv", 2.0, 1300.0, -10.0}}),
      "");
}

}  // namespace
}  // namespace lipoid
