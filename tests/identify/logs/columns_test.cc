#include "identify/logs/columns.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "model/core/errors.h"

namespace lipoid {
namespace {

// Around the four strands and the pieces of 65 536 rows.
constexpr std::size_t kSizes[] = {1, 2, 3, 4, 5, 9, 65535, 65536, 65537, 200003};

Record RandomRecord(std::size_t rows, Hold hold = Hold::kBackward) {
  std::mt19937_64 engine(rows);
  std::uniform_real_distribution<double> interval_s(0.01, 2.0);
  std::normal_distribution<double> current_A(0.0, 3.0);
  Record record;
  record.hold = hold;
  double t = 0.0;
  for (std::size_t k = 0; k < rows; ++k) {
    record.time_s.push_back(t += interval_s(engine));
    record.current_A.push_back(current_A(engine));
  }
  return record;
}

TEST(Columns, ExtentsAreThoseOfTheRows) {
  for (const std::size_t rows : kSizes) {
    const auto x = RandomRecord(rows).current_A;
    const Extent extent = FindExtent(x);
    EXPECT_EQ(extent.least, *std::min_element(x.begin(), x.end())) << rows;
    EXPECT_EQ(extent.most, *std::max_element(x.begin(), x.end())) << rows;
    EXPECT_EQ(LargestMagnitude(x), std::max(-extent.least, extent.most)) << rows;
  }
  EXPECT_EQ(LargestMagnitude(std::vector<double>{-3.0, 2.0}), 3.0);
}

TEST(Columns, SumsLoseNoRow) {
  for (const std::size_t rows : kSizes) {
    // Whole numbers add exactly in any order.
    std::vector<double> x(rows);
    for (std::size_t k = 0; k < rows; ++k) x[k] = static_cast<double>(k % 1000);
    double sum = 0.0;
    for (const double value : x) sum += value;
    EXPECT_EQ(Sum(x), sum) << rows;
  }
}

TEST(Columns, TheShortestIntervalIsFoundWhereverItStands) {
  for (const std::size_t rows : {2, 5, 65536, 65537, 200003}) {
    for (const std::size_t at : {std::size_t{1}, rows / 2 + 1, rows - 1}) {
      if (at >= rows) continue;
      std::vector<double> time_s(rows);
      for (std::size_t k = 1; k < rows; ++k) time_s[k] = time_s[k - 1] + (k == at ? 0.25 : 1.0);
      EXPECT_EQ(ShortestInterval(time_s), 0.25) << rows << " rows, at " << at;
    }
  }
}

TEST(Columns, NoRowsHaveNothing) {
  EXPECT_EQ(Sum({}), 0.0);
  EXPECT_EQ(LargestMagnitude({}), 0.0);
  EXPECT_GT(FindExtent({}).least, FindExtent({}).most);
  EXPECT_EQ(ShortestInterval({}), INFINITY);
  EXPECT_EQ(ShortestInterval(std::vector<double>{1.0}), INFINITY);
}

TEST(CountCharge, IsTheChargeDeliveredAndItsExtremes) {
  for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
    for (const std::size_t rows : kSizes) {
      const Record record = RandomRecord(rows, hold);
      const auto delivered_C = DeliveredCharge(record);
      for (const std::size_t from : {std::size_t{0}, rows / 3}) {
        const std::size_t to = rows - 1;
        const ChargeMoved moved = CountCharge(record, from, to);
        double least_C = 0.0;
        double most_C = 0.0;
        double absolute_C = 0.0;
        for (std::size_t k = from; k <= to; ++k) {
          least_C = std::min(least_C, delivered_C[k] - delivered_C[from]);
          most_C = std::max(most_C, delivered_C[k] - delivered_C[from]);
          absolute_C += 5.0;  // about what a row moves
        }
        // Other orders of adding differ by an epsilon of what is added.
        const double tolerance_C = 1e-15 * absolute_C;
        EXPECT_NEAR(moved.charge_C, delivered_C[to] - delivered_C[from], tolerance_C) << rows;
        EXPECT_NEAR(moved.least_C, least_C, tolerance_C) << rows;
        EXPECT_NEAR(moved.most_C, most_C, tolerance_C) << rows;
      }
    }
  }
}

TEST(CountCharge, GoesOnFromWhereItStopped) {
  const Record record = RandomRecord(1000);
  const ChargeMoved whole = CountCharge(record, 0, 999);
  ChargeMoved parts = CountCharge(record, 0, 300);
  parts.Append(CountCharge(record, 300, 300));
  parts.Append(CountCharge(record, 300, 999));
  EXPECT_NEAR(parts.charge_C, whole.charge_C, 1e-11);
  EXPECT_NEAR(parts.least_C, whole.least_C, 1e-11);
  EXPECT_NEAR(parts.most_C, whole.most_C, 1e-11);
}

TEST(CountCharge, RefusesRowsThatAreNone) {
  const Record record = RandomRecord(3);
  EXPECT_THROW((void)CountCharge(record, 0, 3), PreconditionError);
  EXPECT_THROW((void)CountCharge(record, 2, 1), PreconditionError);
}

TEST(Columns, TheBitsDoNotDependOnTheThreads) {
  const Record record = RandomRecord(500000);
  const auto all = [&] {
    const ChargeMoved moved = CountCharge(record, 0, record.size() - 1);
    return std::vector<double>{Sum(record.current_A), moved.charge_C, moved.least_C, moved.most_C};
  };
  const auto many = all();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(all(), many);
}

}  // namespace
}  // namespace lipoid
