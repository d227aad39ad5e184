// When a voltage falls to the cut-off: closed forms of straight lines.
#include "identify/logs/cutoff_crossing.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lipoid {
namespace {

TEST(CutoffCrossing, LiesBetweenTwoRowsOfOneLoad) {
  CutoffCrossing crossing(3.0);
  crossing.Row(10.0, 1.0, 3.01);
  EXPECT_TRUE(std::isnan(crossing.time_s()));
  crossing.Row(20.0, 1.02, 2.97);
  EXPECT_NEAR(crossing.time_s(), 12.5, 1e-9);
  crossing.Row(30.0, 1.0, 2.9);
  EXPECT_NEAR(crossing.time_s(), 12.5, 1e-9) << "it is reached once";
}

TEST(CutoffCrossing, OfALoadThatBeginsIsAtItsRow) {
  CutoffCrossing crossing(3.0);
  crossing.Row(0.0, 0.0, 4.2);
  crossing.Row(1.0, 100.0, 1.0);
  EXPECT_EQ(crossing.time_s(), 1.0);
  CutoffCrossing first(3.0);
  first.Row(5.0, 1.0, 2.0);
  EXPECT_EQ(first.time_s(), 5.0) << "nothing comes before the first row";
  CutoffCrossing none(3.0);
  none.Row(0.0, 1.0, 3.1);
  none.Row(1.0, 1.0, std::nan(""));
  EXPECT_EQ(none.time_s(), 1.0);
}

TEST(CutoffCrossing, AVoltageThatRisesAgainHasNotReachedIt) {
  CutoffCrossing crossing(3.0);
  crossing.Row(0.0, 1.0, 3.01);
  crossing.Row(1.0, 1.0, 2.999);
  crossing.Row(2.0, 0.5, 3.05);
  EXPECT_TRUE(std::isnan(crossing.time_s()));
  crossing.Row(3.0, 0.5, 3.04);
  crossing.Row(4.0, 0.5, 2.96);
  EXPECT_NEAR(crossing.time_s(), 3.5, 1e-9);
}

TEST(CutoffCrossing, AnEmptyCellReachesItWhereALoadBegins) {
  CutoffCrossing crossing(3.0);
  crossing.Row(0.0, 0.0, 2.98);
  crossing.Row(1.0, -0.5, 2.99);
  EXPECT_TRUE(std::isnan(crossing.time_s()));
  crossing.Row(2.0, 0.5, 2.97);
  EXPECT_EQ(crossing.time_s(), 2.0);
}

}  // namespace
}  // namespace lipoid
