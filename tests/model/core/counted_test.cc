#include "model/core/counted.h"

#include <gtest/gtest.h>

namespace lipoid {
namespace {

TEST(Counted, IsPluralButForOne) {
  EXPECT_EQ(Counted(0, "row"), "0 rows");
  EXPECT_EQ(Counted(1, "row"), "1 row");
  EXPECT_EQ(Counted(12U, "log"), "12 logs");
}

}  // namespace
}  // namespace lipoid
