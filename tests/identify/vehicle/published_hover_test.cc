// Hover of shipped vehicles against measurements of such vehicles: computed here from the numbers in
// the file, by the motor's equations, and not by lipoid's own trim.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "identify/logs/log.h"
#include "model/flight/trim.h"
#include "model/vehicle/level_flight.h"
#include "model/vehicle/vehicle_file.h"
#include "tests/support/paths.h"

namespace lipoid {
namespace {

constexpr double kAgrees = 0.10;  // the bound

// Power of one motor at the speed that carries its share of the weight, all losses of the file's
// resistance included. These vehicles have flat rotors and controllers without losses of their own.
double MotorPower_W(const Vehicle& v, double rotors) {
  const double speed = std::sqrt(v.mass_kg * 9.81 / rotors / v.thrust_coefficient_N_s2);
  const double torque = v.friction_N_m_s * speed + v.torque_coefficient_N_m_s2 * speed * speed;
  const double current_A = torque / v.motor_constant_N_m_per_A;
  return torque * speed + v.armature_resistance_Ohm * current_A * current_A;
}

TEST(PublishedHover, TheTrimIsThatOfTheMotorsEquations) {
  for (const char* name : {"f450", "camera-10in", "hexacopter", "racer-5in"}) {
    const Vehicle v = LoadVehicle(name);
    ASSERT_TRUE(v.esc.lossless()) << name;
    const double battery_V = 3.7 * v.series_cells;
    const Trim trim = HoverTrim(v, Supply<double>{battery_V, 0.0});
    const double rotors = double(v.rotor_count());
    EXPECT_TRUE(trim.possible()) << name;
    EXPECT_LT(trim.duty, 0.7) << name;  // what flies has thrust to spare
    EXPECT_NEAR(battery_V * trim.battery_A,
                rotors * MotorPower_W(v, rotors) + v.avionics_power_W,
                1e-9 * battery_V * trim.battery_A)
        << name;
  }
}

// CTU Prague, Multi-robot Systems group, motor tests: a 2312 motor of 920 rpm/V with a DJI 9450
// propeller lifts 401 g with 3.09 A at 16.66 V, a quarter of the f450.
TEST(PublishedHover, F450DrawsWhatItsMotorsWereMeasuredToDraw) {
  const Vehicle v = LoadVehicle("f450");
  const double per_motor_A = MotorPower_W(v, 4.0) / 16.66;
  const double measured_A = 3.09 * std::pow(v.mass_kg / 4.0 / 0.401, 1.5);  // momentum theory
  EXPECT_NEAR(per_motor_A, measured_A, kAgrees * measured_A);
}

// O. Duffy, X450 quadcopter, build of 21 May 2014 (owenduffy.net): 460 mm, propellers of 10 x 4.5 inch, some 1250 g with
// a battery of 4000 mAh, measured to endure 14.3 minutes of light flying. Three cells of 3.7 V, and a landing with
// a fifth of the charge, are taken, for the page says neither; were all of it used, 27 % more current flowed.
TEST(PublishedHover, F450OfKnownMassFliesAsLongAsOneWasMeasuredToFly) {
  Vehicle v = LoadVehicle("f450");
  v.mass_kg = 1.25;
  const double used_Wh = 0.8 * 4.0 * 3 * 3.7;
  const double minutes = 60.0 * used_Wh / (4.0 * MotorPower_W(v, 4.0) + v.avionics_power_W);
  EXPECT_NEAR(minutes, 14.3, kAgrees * 14.3);
}

// The 3DR Solo that made log171.bin hovers from 200 to 230 s of the log; `lipoid convert log171.bin`
// gives 14.4 A at 15.31 V there.
TEST(PublishedHover, CameraDroneDrawsWhatASoloWasLoggedToDraw) {
  const Vehicle v = LoadVehicle("camera-10in");
  const double power_W = 4.0 * MotorPower_W(v, 4.0) + v.avionics_power_W;
  EXPECT_NEAR(power_W / 15.30, 14.3, kAgrees * 14.3);
  const Log log = ReadLog(test::SourcePath("fixtures/flights/log171.bin"));
  std::vector<double> hovering_W;
  for (std::size_t k = 0; k < log.record.time_s.size(); ++k) {
    if (log.record.time_s[k] < 200.0 || log.record.time_s[k] > 230.0) continue;
    hovering_W.push_back(log.record.current_A[k] * log.record.voltage_V[k]);
  }
  ASSERT_GT(hovering_W.size(), 100u);
  std::nth_element(hovering_W.begin(), hovering_W.begin() + 150, hovering_W.end());
  EXPECT_NEAR(power_W, hovering_W[150], kAgrees * hovering_W[150]);
}

// The whole of log171.bin has speeds by GPS: tests/reference/cruise_power.py prints this table of speed over the ground
// and power. Wind is not known, and 500 m of altitude make the air 5 % thinner than at sea level.
TEST(PublishedHover, CameraDroneCruisesWithThePowerASoloWasLoggedToTake) {
  struct Measured {
    double speed_m_per_s;
    double power_W;
  };
  const Vehicle v = LoadVehicle("camera-10in");
  const LevelFlightOptions air{.air_density_kg_per_m3 = 1.167};  // the standard atmosphere at 500 m
  for (const Measured& at :
       {Measured{0.17, 230.2}, {1.02, 222.9}, {2.93, 214.3}, {5.01, 215.4}, {6.66, 224.7}}) {
    const double power_W = BatteryPower(v, Cruise(v, at.speed_m_per_s, air), 15.3);
    EXPECT_NEAR(power_W, at.power_W, kAgrees * at.power_W) << at.speed_m_per_s << " m/s";
  }
  // Beyond, the drag area decides, which is assumed: half of it would do.
  const Measured fast{11.32, 238.5};
  const double assumed_W = BatteryPower(v, Cruise(v, fast.speed_m_per_s, air), 15.3);
  EXPECT_GT(assumed_W, 1.1 * fast.power_W);
  LevelFlightOptions slender = air;
  slender.flat_plate_area_m2 = 0.5 * std::pow(v.mass_kg / 500.0, 2.0 / 3.0);
  const double slender_W = BatteryPower(v, Cruise(v, fast.speed_m_per_s, slender), 15.3);
  std::printf("%.1f W with the assumed drag area, %.1f W with half of it\n", assumed_W, slender_W);
  EXPECT_NEAR(slender_W, fast.power_W, kAgrees * fast.power_W);
}

}  // namespace
}  // namespace lipoid
