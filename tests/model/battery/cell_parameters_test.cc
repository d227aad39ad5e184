#include "model/battery/cell_parameters.h"

#include <gtest/gtest.h>

#include "model/battery/cell_file.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

std::string OptionErrorOf(Cell cell, std::string_view name, double value) {
  try {
    SetCellParameter(cell, name, value);
  } catch (const OptionError& error) {
    return error.what();
  }
  return "no error";
}

TEST(CellParameters, AreNamedAsOnTheCommandLine) {
  const Cell cell = LoadCell("gifi-600mAh-1");
  EXPECT_EQ(CellParameterNames(cell),
            (std::vector<std::string>{"alpha", "beta", "r_s", "r_1", "c_1", "tau_1"}));
  EXPECT_EQ(CellParameter(cell, "alpha"), 1353.6);  // Table 4.11
  EXPECT_EQ(CellParameter(cell, "beta"), 0.1924);
  EXPECT_EQ(CellParameter(cell, "r_s"), 0.1314);
  EXPECT_EQ(CellParameter(cell, "c_1"), 10.1739);
  EXPECT_EQ(CellParameter(cell, "tau_1"), 2.3643e-5 * 10.1739);
  EXPECT_EQ(CellParameter(cell, "r_2"), std::nullopt);
}

TEST(CellParameters, ResistanceAndCapacitanceMakeTheTimeConstantInEitherOrder) {
  Cell a = LoadCell("gifi-600mAh-1");
  SetCellParameter(a, "r_1", 0.03);
  SetCellParameter(a, "c_1", 1500.0);
  Cell b = LoadCell("gifi-600mAh-1");
  SetCellParameter(b, "c_1", 1500.0);
  SetCellParameter(b, "r_1", 0.03);
  EXPECT_EQ(a.branches[0].time_constant_s, 45.0);
  EXPECT_EQ(b.branches[0].time_constant_s, 45.0);
}

TEST(CellParameters, AGivenTimeConstantStaysWhenTheResistanceChanges) {
  Cell cell = LoadCell("gifi-600mAh-1");
  SetCellParameter(cell, "tau_1", 60.0);
  SetCellParameter(cell, "r_1", 0.02);
  EXPECT_EQ(CellParameter(cell, "tau_1"), 60.0);
  EXPECT_EQ(CellParameter(cell, "c_1"), 3000.0);  // 60 s / 0.02 Ohm
}

TEST(CellParameters, TheNextResistanceAddsABranch) {
  Cell cell = LoadCell("gifi-600mAh-1");
  SetCellParameter(cell, "r_2", 0.01);
  SetCellParameter(cell, "tau_2", 5.0);
  ASSERT_EQ(cell.branches.size(), 2U);
  EXPECT_EQ(cell.branches[1].time_constant_s, 5.0);
}

TEST(CellParameters, WhatCannotBeIsRefused) {
  const Cell cell = LoadCell("gifi-600mAh-1");
  EXPECT_EQ(OptionErrorOf(cell, "beta", 1.5), "beta: expected a number in (0, 1], found 1.5");
  EXPECT_EQ(OptionErrorOf(cell, "alpha", 0.0), "alpha: expected a charge above 0 C, found 0");
  EXPECT_EQ(OptionErrorOf(cell, "r_s", -1.0),
            "r_s: expected a resistance of at least 0 Ohm, found -1");
  EXPECT_EQ(OptionErrorOf(cell, "c_2", 1.0),
            "c_2: the cell has 1 branch; give r_2 first to add one");
  EXPECT_EQ(OptionErrorOf(cell, "gamma", 1.0),
            "'gamma' is no parameter of this cell; it has alpha, beta, r_s, r_1, c_1, tau_1");
}

}  // namespace
}  // namespace lipoid
