// The battery of ArduPilot's simulator against its closed forms.
#include "model/export/ardupilot_law.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/export_cases.h"

namespace lipoid {
namespace {

// A float of 12 V is known to 5e-7 V; the filter stops short of its goal by half a rounding over its
// share of 5 % in a step.
constexpr double kFloat_V = 2e-5;

std::vector<double> DrawnSteadily(const ExportMission& mission) {
  std::vector<double> drawn_Ah;
  for (std::size_t k = 0; k < mission.time_s.size(); ++k)
    drawn_Ah.push_back(mission.time_s[k] * mission.current_A[k] / 3600.0);
  return drawn_Ah;
}

TEST(ArduPilotLaw, RestsAtItsFullVoltage) {
  const auto mission = test::Steady(0.0, 10.0, 0.1);
  for (const double v : ArduPilotVoltage({12.6, 2.0, 0.05}, mission, DrawnSteadily(mission)))
    EXPECT_NEAR(v, 12.6, kFloat_V);
}

TEST(ArduPilotLaw, TableHasItsRowsAndStraightLines) {
  EXPECT_NEAR(ArduPilotRestingVoltage(100.0), 4.173, 1e-6);
  EXPECT_NEAR(ArduPilotRestingVoltage(50.0), 3.742, 1e-6);
  EXPECT_NEAR(ArduPilotRestingVoltage(0.5 * (50.0 + 46.15)), 0.5 * (3.742 + 3.715), 1e-6);
  EXPECT_NEAR(ArduPilotRestingVoltage(0.0), 0.001, 1e-9);
}

TEST(ArduPilotLaw, StepOfCurrentIsFilteredAtTenHertz) {
  // So large that the charge does not matter; one time constant is 1/(20 pi) s.
  ExportMission mission = test::Steady(10.0, 1.0, 0.1);
  const double tau_s = 1.0 / (20.0 * 3.14159265358979);
  mission.time_s = {0.0, tau_s, 1.0};
  mission.current_A = {10.0, 10.0, 10.0};
  const auto volts = ArduPilotVoltage({4.2, 1e6, 0.1}, mission, {0.0, 0.0, 0.0});
  EXPECT_NEAR(volts[0], 4.2, kFloat_V) << "it starts at rest";
  // Nineteen backward-Euler steps of tau/19 leave (1 + 1/19)^-19 of the step.
  EXPECT_NEAR(volts[1], 4.2 - (1.0 - std::pow(1.0 + 1.0 / 19.0, -19.0)), 1e-4);
  EXPECT_NEAR(volts[2], 3.2, kFloat_V);
}

TEST(ArduPilotLaw, HalfTheCapacityIsTheMiddleOfTheTable) {
  // 64 Ah/2 over 64 steps of 0.5 Ah: sums of floats without any rounding.
  ExportMission mission;
  std::vector<double> drawn_Ah;
  mission.time_s = {0.0, 1.0 / kArduPilotSteps_per_s};
  mission.current_A = {0.0, 32.0 * 3600.0 * kArduPilotSteps_per_s};
  mission.time_s.push_back(10.0);
  mission.current_A.push_back(0.0);
  const auto volts = ArduPilotVoltage({3.0 * 4.173, 64.0, 0.0}, mission, {0.0, 32.0, 32.0});
  EXPECT_NEAR(volts.back(), 3.0 * 3.742, kFloat_V);
}

TEST(ArduPilotLaw, FloatCountsASmallCurrentWrongly) {
  // At 0.6 Ah a float is good to 6e-8 Ah, a step of 1.65 A takes 3.8e-7 Ah: the sum of the rounded
  // steps is off by up to 8 %, and the smooth law is not.
  const auto mission = test::Steady(1.65, 360.0, 0.1);
  const auto drawn_Ah = DrawnSteadily(mission);
  const ArduPilotBattery battery{4.2, 0.6, 0.1};
  const double exact_V = ArduPilotVoltageSmooth(battery, mission, drawn_Ah).back();
  EXPECT_NEAR(exact_V,
              4.2 * ArduPilotRestingVoltage(100.0 * (1.0 - 0.165 / 0.6)) / 4.173 - 0.165,
              1e-6);  // the table is in float
  const double float_V = ArduPilotVoltage(battery, mission, drawn_Ah).back();
  EXPECT_GT(std::abs(float_V - exact_V), 1e-3);
  EXPECT_LT(std::abs(float_V - exact_V), 3e-2);
}

TEST(ArduPilotLaw, StartsWithWhatHasAlreadyLeft) {
  const auto mission = test::Steady(0.0, 1.0, 0.1);
  const std::vector<double> drawn_Ah(mission.time_s.size(), 1.0);
  const auto volts = ArduPilotVoltage({4.173, 2.0, 0.05}, mission, drawn_Ah);
  EXPECT_NEAR(volts.front(), 3.742, kFloat_V);
  EXPECT_NEAR(volts.back(), 3.742, kFloat_V);
}

}  // namespace
}  // namespace lipoid
