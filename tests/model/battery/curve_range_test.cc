#include "model/battery/curve_range.h"

#include <gtest/gtest.h>

#include "model/battery/cell_file.h"

namespace lipoid {
namespace {

Cell KnownBetween(double low, double high) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.name = "flown";
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({low, high}, {3.8, 4.0});
  return cell;
}

TEST(CurveRange, SaysWhichEndIsDrawnOn) {
  const Cell cell = KnownBetween(0.36, 0.6);
  EXPECT_EQ(DoubtAboutCurve(cell, 0.32, 0.64), "");
  EXPECT_EQ(
      DoubtAboutCurve(cell, 0.2, 0.6),
      "v_oc of flown is known between 0.36 and 0.6 of the charge: at 0.2 it is its end slope "
      "drawn on, which no log has shown and no interval counts. Logs that go so far would tell");
  EXPECT_NE(DoubtAboutCurve(cell, 0.4, 1.0).find("charge: at 1 it is"), std::string::npos);
  EXPECT_NE(DoubtAboutCurve(cell, -0.5, 0.6).find("charge: at 0 it is"), std::string::npos);
  EXPECT_NE(DoubtAboutCurve(cell, 0.2, 1.0).find("charge: at 0.2 and at 1 it is"),
            std::string::npos);
}

// A discharge to the cut-off ends a little above A = 0, and a charger a little above 1.
TEST(CurveRange, ADischargedCellIsKnownWhole) {
  EXPECT_TRUE(KnowsCurve(KnownBetween(0.04, 0.98), -0.1, 1.1));
  EXPECT_FALSE(KnowsCurve(KnownBetween(0.06, 1.0), 0.0, 1.0));
}

}  // namespace
}  // namespace lipoid
