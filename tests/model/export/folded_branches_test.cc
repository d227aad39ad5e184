#include "model/export/folded_branches.h"

#include <gtest/gtest.h>

#include "model/battery/cell_file.h"
#include "tests/support/export_cases.h"

namespace lipoid {
namespace {

TEST(FoldedBranches, ThesisBranchBecomesSeriesResistanceAndIsNamed) {
  const auto folded = FoldFastBranches(LoadCell("gifi-600mAh-1"));
  EXPECT_TRUE(folded.cell.branches.empty());
  EXPECT_DOUBLE_EQ(folded.cell.series_resistance_Ohm(0.5), 0.1314 + 2.3643e-05);
  ASSERT_EQ(folded.notes.size(), 1U);
  EXPECT_EQ(
      folded.notes[0],
      "Branch 1 of the cell (at most 2.364e-05 Ohm, 0.0002405 s) is too fast to be seen and is "
      "part of the series resistance here.");
}

TEST(FoldedBranches, SlowBranchStaysHoweverSmall) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.branches = {{Resistance<double>(1e-6), 100.0, {}},   // small but slow
                   {Resistance<double>(1e-6), 0.5, {}},     // small and fast
                   {Resistance<double>(0.05), 0.01, {}},    // large, and not faster than 5 ms
                   {Resistance<double>(0.05), 0.004, {}}};  // faster
  const auto folded = FoldFastBranches(cell);
  ASSERT_EQ(folded.cell.branches.size(), 2U);
  EXPECT_EQ(folded.cell.branches[0].time_constant_s, 100.0);
  EXPECT_EQ(folded.cell.branches[1].time_constant_s, 0.01);
  EXPECT_DOUBLE_EQ(folded.cell.series_resistance_Ohm(0.5), 0.1314 + 1e-6 + 0.05);
}

TEST(FoldedBranches, TablesAddUpBetweenTheNodesOfBoth) {
  const Resistance<double> a({0.1, 0.5, 0.9}, {3.0, 1.0, 2.0});
  const Resistance<double> b({0.3, 0.5, 0.8}, {0.5, 0.1, 0.7});
  const auto sum = Sum(a, b);
  EXPECT_EQ(sum.soc, (std::vector<double>{0.1, 0.3, 0.5, 0.8, 0.9}));
  // Both are straight between the nodes of the sum, so only rounding differs.
  for (double soc = -0.2; soc < 1.2; soc += 0.013)
    EXPECT_NEAR(sum(soc), a(soc) + b(soc), 1e-14) << soc;
}

}  // namespace
}  // namespace lipoid
