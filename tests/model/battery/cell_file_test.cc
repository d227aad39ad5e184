#include "model/battery/cell_file.h"

#include <gtest/gtest.h>

#include "model/core/errors.h"
#include "tests/support/paths.h"

namespace lipoid {
namespace {

TEST(CellFile, ShippedCellsAreThoseOfTheTables) {
  struct Row {
    const char* name;
    double alpha_C, beta, series_Ohm, branch_Ohm, branch_F;
  };
  // Tables 4.8-4.13; alpha of 4.12 and 4.13 corrected by a factor of 100.
  const Row rows[] = {{"gifi-600mAh-1", 1353.6, 0.1924, 0.1314, 2.3643e-5, 10.1739},
                      {"gifi-600mAh-2", 1355.5, 0.2038, 0.1316, 1.9728e-5, 10.1826},
                      {"gifi-600mAh-3", 1353.3, 0.1966, 0.1315, 1.0077e-5, 10.1325},
                      {"grepow-32Ah-1", 1.1586e5, 0.2074, 0.0016, 1.0238e-6, 500.0597},
                      {"grepow-32Ah-2", 1.1590e5, 0.1810, 0.0017, 4.5346e-6, 500.2820},
                      {"grepow-32Ah-3", 1.1603e5, 0.2018, 0.0017, 2.7461e-6, 500.9338}};
  ASSERT_EQ(ShippedCellNames().size(), std::size(rows));
  for (const Row& row : rows) {
    SCOPED_TRACE(row.name);
    const Cell cell = LoadCell(row.name);
    EXPECT_EQ(cell.name, row.name);
    ASSERT_TRUE(cell.diffusion.has_value());
    EXPECT_EQ(cell.diffusion->alpha_C, row.alpha_C);
    EXPECT_EQ(cell.diffusion->beta_per_sqrt_s, row.beta);
    EXPECT_EQ(cell.series_resistance_Ohm.resistance_Ohm[0], row.series_Ohm);
    ASSERT_EQ(cell.branches.size(), 1U);
    EXPECT_EQ(cell.branches[0].resistance_Ohm.resistance_Ohm[0], row.branch_Ohm);
    EXPECT_EQ(cell.branches[0].capacitance_F, row.branch_F);
    EXPECT_TRUE(cell.open_circuit_voltage_assumed);
    EXPECT_EQ(cell.open_circuit_voltage(0.3), 3.74);
  }
}

}  // namespace
}  // namespace lipoid
