// The error that every export states.
#include "model/export/export_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "model/battery/cell_file.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

ExportMission ThreeRows() {
  ExportMission mission;
  mission.time_s = {0.0, 10.0, 30.0};
  mission.current_A = {1.0, 2.0, 3.0};
  return mission;
}

Prediction ThreeVoltages() {
  Prediction cell;
  cell.voltage_V = {4.0, 3.9, 3.8};
  cell.soc = {1.0, 0.9, 0.8};
  return cell;
}

TEST(ExportError, IsTheRootMeanSquareOverTheRowsAndSaysWhereTheWorstIs) {
  const Prediction cell = ThreeVoltages();
  const auto error = VoltageError(cell, ThreeRows(), std::vector<double>{4.0, 3.8, 3.82});
  EXPECT_NEAR(error.rmse_V, std::sqrt((0.01 + 0.0004) / 3.0), 1e-15);
  EXPECT_NEAR(error.max_error_V, 0.1, 1e-15);
  EXPECT_EQ(error.worst_s, 10.0);
  EXPECT_EQ(error.worst_soc, 0.9);
}

TEST(ExportError, AVoltageThatIsNoNumberIsNotPassedOver) {
  const Prediction cell = ThreeVoltages();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto error = VoltageError(cell, ThreeRows(), std::vector<double>{4.0, nan, 0.0});
  EXPECT_TRUE(std::isnan(error.rmse_V));
  EXPECT_TRUE(std::isnan(error.max_error_V));
  EXPECT_EQ(error.worst_s, 10.0);
}

TEST(ExportError, AskingForOtherRowsIsAMistake) {
  const Prediction cell = ThreeVoltages();
  EXPECT_THROW((void)VoltageError(cell, ThreeRows(), std::vector<double>{4.0}), PreconditionError);
}

TEST(ExportError, ChargeIsCountedByTheHoldFromTheInitialState) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.parallel = 2;
  ExportMission mission = ThreeRows();
  mission.initial_soc = 0.5;
  const double first_Ah = 0.5 * 2.0 * 1353.6 / 3600.0;
  const auto backward = ChargeDrawn_Ah(cell, mission);
  EXPECT_NEAR(backward[0], first_Ah, 1e-15);
  EXPECT_NEAR(backward[2], first_Ah + (10.0 * 2.0 + 20.0 * 3.0) / 3600.0, 1e-15);
  mission.hold = Hold::kForward;
  EXPECT_NEAR(
      ChargeDrawn_Ah(cell, mission)[2], first_Ah + (10.0 * 1.0 + 20.0 * 2.0) / 3600.0, 1e-15);
}

}  // namespace
}  // namespace lipoid
