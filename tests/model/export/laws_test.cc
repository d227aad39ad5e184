// The batteries of Gazebo, PX4 and equivalent circuits against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "model/export/curve_nodes.h"
#include "model/export/equivalent_circuit_law.h"
#include "model/export/gazebo_law.h"
#include "model/export/px4_law.h"
#include "tests/support/export_cases.h"

namespace lipoid {
namespace {

std::vector<double> Drawn(const ExportMission& mission) {
  std::vector<double> drawn_Ah{0.0};
  for (std::size_t k = 1; k < mission.time_s.size(); ++k) {
    drawn_Ah.push_back(drawn_Ah.back() +
                       (mission.time_s[k] - mission.time_s[k - 1]) * mission.current_A[k] / 3600.0);
  }
  return drawn_Ah;
}

TEST(GazeboLaw, StepOfCurrentIsSmoothedAndCounted) {
  const GazeboBattery battery{12.6, -2.0, 2.0, 0.1, 4.0};
  const auto mission = test::Steady(5.0, 60.0, 0.5);
  const auto volts = GazeboVoltage(battery, mission, Drawn(mission));
  // Step by step, as the plugin does.
  double s = 0.0;
  double q = 2.0;
  double v = 12.6;
  for (int n = 1; n <= 60000; ++n) {
    s += 1e-3 / 4.0 * (5.0 - s);
    q -= 1e-3 * s / 3600.0;
    v = 12.6 - 2.0 * (1.0 - q / 2.0) - 0.1 * s;
    if (n % 500 == 0) {
      ASSERT_NEAR(volts[static_cast<std::size_t>(n / 500)], v, 1e-10) << n;
    }
  }
  // Long after the step: the whole drop, and the charge less its lag.
  EXPECT_NEAR(v, 12.6 - 2.0 * 5.0 * (60.0 - 4.0) / 3600.0 / 2.0 - 0.5, 1e-3);
}

TEST(GazeboLaw, ASmoothingBelowAStepIsAStep) {
  const GazeboBattery battery{12.6, 0.0, 2.0, 0.1, 1e-6};
  const auto mission = test::Steady(5.0, 0.01, 0.001);
  EXPECT_NEAR(GazeboVoltage(battery, mission, Drawn(mission))[1], 12.1, 1e-12);
}

TEST(GazeboLaw, PowerIsTheCurrentTimesTheVoltageInTheEnd) {
  const GazeboBattery battery{12.0, 0.0, 100.0, 0.5, 0.5};
  const auto mission = test::Steady(1.0, 30.0, 0.1);
  const std::vector<double> power_W(mission.time_s.size(), 40.0);
  const double v = GazeboVoltageUnderPower(battery, mission, power_W, Drawn(mission)).back();
  EXPECT_NEAR(v * (12.0 - v) / 0.5, 40.0, 1e-6);
}

TEST(Px4Law, IsAStraightLineLessTheDrop) {
  const Px4Battery battery{3, 3.5, 4.15, 0.02, 1000.0};
  ExportMission mission;
  mission.time_s = {0.0, 1800.0};
  mission.current_A = {0.0, 1.0};
  const auto volts = Px4Voltage(battery, mission, {0.0, 0.5});
  EXPECT_NEAR(volts[0], 3.0 * 4.15, 1e-12);
  EXPECT_NEAR(volts[1], 3.0 * (3.825 - 0.02), 1e-12);
}

TEST(Px4Law, EstimatorFollowsABatteryThatHasItsLaw) {
  const Px4Battery battery{1, 3.5, 4.15, 0.02, 1000.0};
  const auto mission = test::Steady(1.0, 1800.0, 0.5);
  const auto drawn_Ah = Drawn(mission);
  const auto shown = Px4StateOfCharge(battery, mission, Px4Voltage(battery, mission, drawn_Ah));
  // The low-pass lags a second of 3600.
  constexpr double kLag = 2.0 / 3600.0;
  for (std::size_t k = 0; k < shown.size(); ++k)
    ASSERT_NEAR(shown[k], 1.0 - drawn_Ah[k], kLag) << mission.time_s[k];
}

TEST(Px4Law, EstimatorIsDrawnToALowVoltage) {
  const Px4Battery battery{1, 3.5, 4.15, 0.0, 1000.0};
  const auto mission = test::Steady(0.0, 60.0, 0.5);
  std::vector<double> volts(mission.time_s.size(), 3.5);
  volts[0] = 4.15;
  const auto shown = Px4StateOfCharge(battery, mission, volts);
  EXPECT_EQ(shown.front(), 1.0);
  EXPECT_LT(shown.back(), 0.01) << "3 % of the way in each of 6000 updates";
}

TEST(EquivalentCircuitLaw, StepResponseIsExact) {
  EquivalentCircuit circuit;
  circuit.capacity_Ah = 1e9;  // the charge does not matter
  circuit.open_circuit = {{0.0, 1.0}, {3.0, 4.0}};
  circuit.soc = {0.0, 1.0};
  circuit.series_Ohm = {0.1, 0.1};
  circuit.branches = {{{0.2, 0.2}, 5.0}, {{0.3, 0.3}, 50.0}};
  const auto mission = test::Steady(2.0, 100.0, 2.0);
  const auto volts = EquivalentCircuitVoltage(circuit, mission, Drawn(mission));
  for (std::size_t k = 0; k < volts.size(); ++k) {
    const double t = mission.time_s[k];
    ASSERT_NEAR(volts[k],
                4.0 - 0.2 - 0.4 * (1.0 - std::exp(-t / 5.0)) - 0.6 * (1.0 - std::exp(-t / 50.0)),
                1e-6)
        << t;
  }
}

TEST(EquivalentCircuitLaw, LongRowsAgreeWithShortOnes) {
  EquivalentCircuit circuit;
  circuit.capacity_Ah = 0.4;
  circuit.open_circuit = {{0.0, 1.0}, {3.0, 4.0}};
  circuit.soc = {0.0, 0.5, 1.0};
  circuit.series_Ohm = {0.1, 0.1, 0.1};
  circuit.branches = {{{0.5, 0.05, 0.2}, 30.0}};
  const auto coarse = test::Steady(1.0, 1200.0, 400.0);
  const auto fine = test::Steady(1.0, 1200.0, 0.1);
  const double coarse_V = EquivalentCircuitVoltage(circuit, coarse, Drawn(coarse)).back();
  const double fine_V = EquivalentCircuitVoltage(circuit, fine, Drawn(fine)).back();
  // Steps of 0.002 of the charge: a fraction of the drop's change over one.
  EXPECT_NEAR(coarse_V, fine_V, 2e-5);
}

TEST(CurveNodes, AreTheCurvesOwnOrKeepTheStraightLinesWithinTheTolerance) {
  const auto linear = OpenCircuitVoltage::Linear({0.0, 0.3, 1.0}, {3.0, 3.7, 4.2});
  EXPECT_EQ(NodesOf(linear).soc, linear.soc());
  const OpenCircuitVoltage curves[] = {
      OpenCircuitVoltage::MonotoneCubic({0.0, 0.1, 0.5, 1.0}, {3.0, 3.6, 3.8, 4.2}),
      OpenCircuitVoltage::Polynomial(0.0, 1.0, {3.7, 0.5, -0.1, 0.15, 0.05}),
      OpenCircuitVoltage::Fourier(0.0, 1.0, 2.0, {3.5, 0.2, 0.1}, {0.3, 0.1})};
  for (const auto& curve : curves) {
    const auto nodes = ExtendedNodesOf(curve);
    const auto lines = OpenCircuitVoltage::Linear(nodes.soc, nodes.voltage_V);
    for (int k = -400; k <= 1400; ++k) {
      const double soc = k / 1000.0;
      // Between the three places that are looked at the difference is little more.
      ASSERT_NEAR(lines(soc), curve(soc), 1.2 * kCurveTolerance_V) << soc;
    }
    EXPECT_LT(nodes.soc.size(), 1000U);
  }
}

}  // namespace
}  // namespace lipoid
