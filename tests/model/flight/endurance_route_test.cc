#include "model/flight/endurance_route.h"

#include <gtest/gtest.h>

#include "model/battery/cell_file.h"
#include "model/battery/rest_voltage.h"
#include "model/core/errors.h"
#include "model/vehicle/vehicle_file.h"
#include "tests/support/text_files.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

EnduranceRequest Mambo() {
  EnduranceRequest request;
  request.vehicle = LoadVehicle("mambo-physical");
  request.cell = LoadCell("gifi-600mAh-1");
  return request;
}

TEST(EnduranceRoute, StayingWhereItIsTakesThePowerOfHover) {
  const auto file = test::WriteText("endurance_route_hover.toml",
                                    "[[waypoint]]\naltitude_m = 2.0\nstay_s = 3.0\n");
  EnduranceRequest request = Mambo();
  request.payload_kg = {0.004, 0.0};
  const PowerMission mission = FlyRoute(request, LoadGains("aware"), file);
  ASSERT_EQ(mission.legs.size(), 600U);
  Vehicle loaded = request.vehicle;
  loaded.mass_kg += 0.004;
  const LevelFlight hover = Cruise(loaded, 0.0);
  const double power_W = BatteryPower(loaded, hover, 3.7);
  // The controller rounds speeds to steps of its pulse width.
  for (const MissionLeg& leg : mission.legs) {
    ASSERT_NEAR(leg.power_W, power_W, 0.05 * power_W);
    ASSERT_NEAR(leg.least_V, hover.battery_V, 0.05 * hover.battery_V);
    ASSERT_NEAR(leg.ground_speed_m_per_s, 0.0, 1e-9);
  }
}

// Discharged the cell rests 50 mV below v_oc(A). What a controller loses by switching tells the voltage.
TEST(EnduranceRoute, StartsWhereTheEnduranceStarts) {
  const auto file = test::WriteText("endurance_route_start.toml",
                                    "[[waypoint]]\naltitude_m = 2.0\nstay_s = 0.1\n");
  EnduranceRequest request = Mambo();
  request.cell.hysteresis = Cell::Hysteresis{.folds = 30.0, .soc = {}, .half_V = {0.05}};
  request.vehicle.esc.switching_time_s = 1e-6;
  request.vehicle.esc.switching_frequency_Hz = 5e4;
  request.initial_voltage_V = 3.9;
  const double by_voltage_W = FlyRoute(request, LoadGains("aware"), file).legs[0].power_W;
  request.initial_voltage_V.reset();
  request.initial_soc = NearestSocAtRest(request.cell, 3.9);
  EXPECT_EQ(FlyRoute(request, LoadGains("aware"), file).legs[0].power_W, by_voltage_W);
  request.initial_soc = request.cell.open_circuit_voltage.SocAtVoltage(3.9);
  EXPECT_NE(FlyRoute(request, LoadGains("aware"), file).legs[0].power_W, by_voltage_W);
}

// A speed that the tilt does not hold against the drag is flown without it.
TEST(EnduranceRoute, SaysWhatItsSpeedLeavesOut) {
  const auto file = test::WriteText("endurance_route_fast.toml",
                                    "[[waypoint]]\naltitude_m = 2.0\n"
                                    "[[waypoint]]\naltitude_m = 5.0\nx_m = 4.0\nstay_s = 20.0\n");
  EnduranceRequest request = Mambo();
  const PowerMission slow = FlyRoute(request, LoadGains("aware"), file);
  EXPECT_EQ(slow.way_back_m, 5.0);
  ASSERT_EQ(slow.doubts.size(), 1U);
  EXPECT_NE(slow.doubts[0].find("without the drag of the air"), std::string::npos);
  // m g tan 20 degrees is 3.6 m/s² of drag per mass.
  request.vehicle.linear_drag_N_s_per_m = 8.0 * request.vehicle.mass_kg;
  const PowerMission fast = FlyRoute(request, LoadGains("aware"), file);
  ASSERT_EQ(fast.doubts.size(), 2U);
  EXPECT_NE(fast.doubts[1].find("holds 0.448 m/s: in the air it takes longer"), std::string::npos)
      << fast.doubts[1];
}

TEST(EnduranceRoute, SaysThatTheVehicleCrashes) {
  const auto file = test::WriteText("endurance_route_crash.toml",
                                    "[[waypoint]]\naltitude_m = 2.0\nstay_s = 20.0\n");
  Gains unstable = LoadGains("aware");
  unstable.altitude = {.proportional = -50.0, .integral = 0.0, .derivative = 0.0};
  const std::string message =
      test::MessageOf<OptionError>([&] { (void)FlyRoute(Mambo(), unstable, file); });
  EXPECT_NE(message.find("mambo-physical crashes on the route of"), std::string::npos) << message;
}

TEST(EnduranceRoute, SaysThatTheVehicleMissesAWaypoint) {
  const auto file = test::WriteText("endurance_route_far.toml",
                                    "[[waypoint]]\naltitude_m = 2.0\n"
                                    "[[waypoint]]\naltitude_m = 2.0\nx_m = 100.0\nstay_s = 5.0\n");
  const std::string message =
      test::MessageOf<OptionError>([&] { (void)FlyRoute(Mambo(), LoadGains("aware"), file); });
  EXPECT_NE(message.find("mambo-physical does not fly the route of"), std::string::npos) << message;
  EXPECT_NE(message.find("it missed 1 of 2 waypoints: "), std::string::npos) << message;
}

}  // namespace
}  // namespace lipoid
