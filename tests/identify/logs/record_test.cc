#include "identify/logs/record.h"

#include <gtest/gtest.h>

#include <vector>

namespace lipoid {
namespace {

Record Sample(Hold hold) {
  return {.file = "x.csv",
          .time_s = {0.0, 1.0, 3.0, 63.0},
          .current_A = {8.0, 2.0, 4.0, -1.0},
          .voltage_V = {8.0, 7.5, 7.25, 8.0},
          .temperature_degC = {},
          .hold = hold};
}

TEST(DeliveredCharge, IsCountedByTheHoldOfTheRecord) {
  EXPECT_EQ(DeliveredCharge(Sample(Hold::kBackward)), (std::vector<double>{0.0, 2.0, 10.0, -50.0}));
  EXPECT_EQ(DeliveredCharge(Sample(Hold::kForward)), (std::vector<double>{0.0, 8.0, 12.0, 252.0}));
}

TEST(DeliveredCharge, OfNoRowsIsNone) { EXPECT_TRUE(DeliveredCharge(Record{}).empty()); }

TEST(DivideByPack, MakesThePackOneCell) {
  Record record = Sample(Hold::kBackward);
  DivideByPack(record, 2, 4);
  EXPECT_EQ(record.voltage_V, (std::vector<double>{4.0, 3.75, 3.625, 4.0}));
  EXPECT_EQ(record.current_A, (std::vector<double>{2.0, 0.5, 1.0, -0.25}));
  EXPECT_EQ(record.time_s, (std::vector<double>{0.0, 1.0, 3.0, 63.0}));
}

}  // namespace
}  // namespace lipoid
