#include "model/flight/live_plant.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/battery/cell_file.h"
#include "model/core/errors.h"
#include "model/flight/trim.h"
#include "model/vehicle/vehicle_file.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

constexpr double kFrame_s = 1.0 / 400.0;

LiveSetup OnTheGround() {
  return {.vehicle = LoadVehicle("mambo-coupled"), .cell = LoadCell("gifi-600mAh-1")};
}

PerMotor<double> All(double duty) { return {duty, duty, duty, duty}; }

void Fly(LivePlant& plant, const PerMotor<double>& duty, double seconds, double dt_s = kFrame_s) {
  const auto frames = std::llround(seconds / dt_s);
  for (long long k = 0; k < frames; ++k) plant.Advance(duty, dt_s);
}

TEST(LivePlant, LiesStillOnTheGround) {
  const auto plant = MakeLivePlant(OnTheGround());
  Fly(*plant, All(0.0), 5.0);
  const LiveState& s = plant->state();
  // The springs carry the weight to rounding.
  EXPECT_NEAR(s.specific_force_m_per_s2[2], -kGravity_m_per_s2, 1e-12);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(s.position_m[k], 0.0, 1e-12);
    EXPECT_NEAR(s.velocity_m_per_s[k], 0.0, 1e-12);
    EXPECT_EQ(s.angles_rad[k], 0.0);
  }
  EXPECT_EQ(s.battery_A, 0.0);
  EXPECT_EQ(s.battery_V, 4.2);
  EXPECT_NEAR(s.time_s, 5.0, 1e-9);
  EXPECT_FALSE(plant->report().takeoff_s.has_value());
}

// Trim by its closed form: 1 % less does not lift, 1 % more does.
TEST(LivePlant, LiftsWhereThrustExceedsWeight) {
  for (const double share : {0.99, 1.01}) {
    const LiveSetup setup = OnTheGround();
    const auto plant = MakeLivePlant(setup);
    // The voltage falls as it waits: of the state of charge at the end.
    Fly(*plant, All(0.5), 2.0);
    BatterySupply battery(setup.cell, plant->state().soc);
    const double duty = HoverTrim(setup.vehicle, battery).duty;
    Fly(*plant, All(share * duty), 2.0);
    EXPECT_EQ(plant->report().takeoff_s.has_value(), share > 1.0) << share;
  }
}

// The charge is the integral of the current, and its flow is what the motors take.
TEST(LivePlant, TheBatteryGivesWhatTheMotorsTake) {
  const auto plant = MakeLivePlant(OnTheGround());
  double charge_C = 0.0;
  double before_A = 0.0;
  for (int k = 0; k < 4000; ++k) {
    plant->Advance(All(0.5), kFrame_s);
    const double now_A = plant->state().battery_A;
    charge_C += 0.5 * kFrame_s * (before_A + now_A);
    before_A = now_A;
  }
  // 10 s of about 2 A; the first frame's jump of the current is what the trapezium misses.
  EXPECT_NEAR(plant->report().charge_C / charge_C, 1.0, 2e-3);
  EXPECT_LT(plant->state().battery_V, 4.0);
  // After a rest of many beta^-2 the state of charge is that of the charge alone.
  Fly(*plant, All(0.0), 600.0, 0.02);
  EXPECT_NEAR(plant->state().soc, 1.0 - plant->report().charge_C / 1353.6, 1e-6);
}

TEST(LivePlant, TheRateOfFramesDoesNotMatter) {
  std::vector<LiveState> ends;
  for (const double rate_Hz : {50.0, 400.0, 1200.0}) {
    const auto plant = MakeLivePlant(OnTheGround());
    Fly(*plant, All(0.5), 1.0, 1.0 / rate_Hz);
    Fly(*plant, {0.7, 0.695, 0.69, 0.7}, 1.0, 1.0 / rate_Hz);
    ends.push_back(plant->state());
  }
  // The cell sees the mean current of each step of 2.5 ms or less.
  for (const LiveState& end : ends) {
    EXPECT_NEAR(end.battery_V, ends.back().battery_V, 1e-4);
    EXPECT_NEAR(end.position_m[2], ends.back().position_m[2], 2e-3);
    EXPECT_NEAR(end.angles_rad[0], ends.back().angles_rad[0], 2e-3);
  }
  EXPECT_LT(ends.back().position_m[2], -0.1);
}

TEST(LivePlant, AnEmptyBatteryGivesNothingAndAResetIsAFreshOne) {
  LiveSetup setup = OnTheGround();
  setup.initial_soc = 0.03;
  const auto plant = MakeLivePlant(setup);
  Fly(*plant, All(0.45), 60.0);
  const LiveReport& report = plant->report();
  ASSERT_TRUE(report.cutoff_s.has_value());
  ASSERT_TRUE(report.empty_s.has_value());
  EXPECT_LT(*report.cutoff_s, *report.empty_s);
  EXPECT_NEAR(plant->state().battery_A, 0.0, 1e-9);
  EXPECT_LT(plant->state().speed_rad_per_s[0], 1.0);
  EXPECT_LT(report.minimum_voltage_V, 3.0);
  plant->Reset();
  EXPECT_FALSE(plant->report().empty_s.has_value());
  EXPECT_EQ(plant->state().time_s, 0.0);
  EXPECT_NEAR(plant->state().soc, 0.03, 1e-15);
  EXPECT_EQ(plant->report().charge_C, 0.0);
}

TEST(LivePlant, AtAPitchOf90DegreesItIsOverAndStaysSo) {
  const auto plant = MakeLivePlant(OnTheGround());
  Fly(*plant, All(0.8), 0.5);
  Fly(*plant, {0.9, 0.1, 0.1, 0.9}, 3.0);
  ASSERT_TRUE(plant->report().over.has_value());
  EXPECT_NE(plant->report().over->find("gimbal lock"), std::string::npos);
  const double time_s = plant->state().time_s;
  plant->Advance(All(0.0), kFrame_s);
  EXPECT_EQ(plant->state().time_s, time_s);
}

TEST(LivePlant, GustsAreThoseOfTheSeed) {
  LiveSetup setup = OnTheGround();
  setup.wind.gusts_m_per_s = 10.0;
  std::vector<double> ends;
  for (const std::uint64_t seed : {1, 1, 2}) {
    setup.seed = seed;
    const auto plant = MakeLivePlant(setup);
    Fly(*plant, All(0.65), 2.0);
    ends.push_back(plant->state().position_m[0]);
  }
  EXPECT_EQ(ends[0], ends[1]);
  EXPECT_NE(ends[0], ends[2]);
  EXPECT_NE(ends[0], 0.0);
}

TEST(LivePlant, SaysWhatCannotBeFlown) {
  LiveSetup setup = OnTheGround();
  setup.initial_soc = 0.0;
  EXPECT_EQ(test::MessageOf<OptionError>([&] { (void)MakeLivePlant(setup); }),
            "the cell is empty at a state of charge of 0: nothing to fly with. Give --initial-soc "
            "between 0 and 1");
  setup = OnTheGround();
  setup.wind.wind_x_m_per_s = 1.0;
  setup.vehicle.linear_drag_N_s_per_m = 0.0;
  EXPECT_EQ(
      test::MessageOf<OptionError>([&] { (void)MakeLivePlant(setup); }),
      "drag and wind need a vehicle with linear_drag_N_s_per_m; mambo-coupled has none. Write "
      "it into a vehicle file and give that");
  setup = OnTheGround();
  setup.vehicle.armature_inductance_H = 1e-9;
  EXPECT_EQ(test::MessageOf<OptionError>([&] { (void)MakeLivePlant(setup); }),
            "the armature current of mambo-coupled has a time constant of 2.04e-09 s, which needs "
            "steps below 1e-05 s. Give the vehicle an armature_inductance_H of 0: its motors are "
            "then as fast as they are");
}

// Motors with an inductance are another state; slow ones end where those without do.
TEST(LivePlant, AnInductanceIsFollowed) {
  LiveSetup setup = OnTheGround();
  setup.vehicle.armature_inductance_H = 5e-5;
  const auto with = MakeLivePlant(setup);
  const auto without = MakeLivePlant(OnTheGround());
  Fly(*with, All(0.5), 2.0);
  Fly(*without, All(0.5), 2.0);
  EXPECT_NEAR(with->state().battery_V, without->state().battery_V, 1e-4);
  EXPECT_NE(with->state().battery_V, without->state().battery_V);
}

}  // namespace
}  // namespace lipoid
