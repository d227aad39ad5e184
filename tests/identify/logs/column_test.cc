#include "identify/logs/column.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace lipoid {
namespace {

using Numbers = std::vector<double>;

TEST(Column, WhatIsLentIsNotCopied) {
  const auto keeper = std::make_shared<Numbers>(Numbers{1.0, 2.0, 3.0});
  const Column lent = Column::Lent(*keeper, keeper);
  const Column copy = lent;  // NOLINT(performance-unnecessary-copy-initialization): what is tested
  EXPECT_EQ(lent.data(), keeper->data());
  EXPECT_EQ(copy.data(), keeper->data());
  EXPECT_TRUE(copy.lent());
  EXPECT_EQ(copy, Column({1.0, 2.0, 3.0}));
}

TEST(Column, TheKeeperLivesAsLongAsItsLastColumn) {
  auto keeper = std::make_shared<Numbers>(Numbers{1.0, 2.0});
  const std::weak_ptr<Numbers> seen = keeper;
  {
    Column outlives;
    {
      const Column lent = Column::Lent(*keeper, keeper);
      keeper.reset();
      outlives = lent;
    }
    EXPECT_FALSE(seen.expired());
    EXPECT_EQ(outlives.back(), 2.0);
  }
  EXPECT_TRUE(seen.expired());
}

TEST(Column, WhoChangesItGetsNumbersOfItsOwn) {
  const auto keeper = std::make_shared<Numbers>(Numbers{1.0, 2.0});
  Column changed = Column::Lent(*keeper, keeper);
  for (double& number : changed) number *= 10.0;
  changed.push_back(30.0);
  changed[0] = 11.0;
  EXPECT_EQ(*keeper, (Numbers{1.0, 2.0}));
  EXPECT_EQ(changed, Column({11.0, 20.0, 30.0}));
  EXPECT_FALSE(changed.lent());
}

TEST(Column, CopiesOfItsOwnNumbersAreIndependent) {
  Column one({1.0, 2.0});
  const Column other = one;
  one[0] = 5.0;
  EXPECT_EQ(other, Column({1.0, 2.0}));
  const Column taken = std::move(one);
  EXPECT_EQ(taken, Column({5.0, 2.0}));
  EXPECT_TRUE(one.empty());  // NOLINT(bugprone-use-after-move): it is promised
}

TEST(Column, ReadsAndGrowsLikeAVector) {
  Column column;
  EXPECT_TRUE(column.empty());
  column.reserve(4);
  column.push_back(1.0);
  const Numbers more{2.0, 3.0};
  column.append(more.begin(), more.end());
  const Column& seen = column;
  EXPECT_EQ(seen.front(), 1.0);
  EXPECT_EQ(seen[1], 2.0);
  EXPECT_EQ(seen.ToVector(), (Numbers{1.0, 2.0, 3.0}));
  const std::span<const double> span = column;
  EXPECT_EQ(span.data(), seen.data());
  column.clear();
  EXPECT_EQ(column.size(), 0U);
}

}  // namespace
}  // namespace lipoid
