#include "model/flight/trim.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/battery/cell_file.h"
#include "model/vehicle/plant.h"
#include "model/vehicle/vehicle_file.h"

namespace lipoid {
namespace {

// Every rate of the plant at the trim, save the delivered charge's; accelerations of the rotors are
// thousands of rad/s² when a millivolt is missing.
double LargestRate(const Vehicle& vehicle, const Trim& trim, const Supply<double>& supply) {
  return ForRotorsOf(vehicle, [&](auto rotors) {
    constexpr std::size_t kRotors = rotors;
    const RotorPlant<kRotors> plant(vehicle, {});
    PlantState<double, plant::States(kRotors)> x{};
    x[plant::kPosition + 2] = -1.0;
    for (std::size_t i = 0; i < kRotors; ++i) x[plant::kSpeeds + i] = trim.speed_rad_per_s;
    PlantInputs<double, kRotors> inputs;
    inputs.duty.fill(trim.duty);
    inputs.supply = supply;
    auto rate = x;
    plant.Derivative(x, inputs, rate);
    EXPECT_NEAR(rate[plant::Charge(kRotors)], trim.battery_A, 1e-9 * trim.battery_A);
    rate[plant::Charge(kRotors)] = 0.0;
    double largest = 0.0;
    for (const double r : rate) largest = std::max(largest, std::abs(r));
    return largest;
  });
}

TEST(HoverTrim, IsAnEquilibriumOnAnIdealSource) {
  const Vehicle vehicle = LoadVehicle("mambo-thesis");
  for (const double xi : {0.75, 0.9, 1.0}) {
    const Supply<double> supply{xi * vehicle.nominal_voltage_V, 0.0};
    const Trim trim = HoverTrim(vehicle, supply);
    EXPECT_TRUE(trim.possible());
    // Rounding of speeds of 2000 rad/s with time constants of 18 ms.
    EXPECT_LT(LargestRate(vehicle, trim, supply), 1e-9) << xi;
  }
}

TEST(HoverTrim, IsAnEquilibriumOnEveryCellThatCanCarryTheVehicle) {
  int flying = 0;
  for (const char* vehicle_name : {"mambo-coupled", "mambo-physical"}) {
    const Vehicle vehicle = LoadVehicle(vehicle_name);
    for (const std::string& cell_name : ShippedCellNames()) {
      for (const double soc : {1.0, 0.5}) {
        BatterySupply battery(LoadCell(cell_name), soc);
        const Trim trim = HoverTrim(vehicle, battery);
        if (!trim.possible()) continue;
        ++flying;
        EXPECT_LT(LargestRate(vehicle, trim, battery.Linearize()), 1e-9)
            << vehicle_name << " on " << cell_name << " at " << soc;
        // What leaves the battery is what the motors take.
        EXPECT_NEAR(trim.battery_V * trim.battery_A, 4.0 * trim.motor_V * trim.motor_A, 1e-12);
      }
    }
  }
  EXPECT_GE(flying, 12);
}

// The drop of charge transfer is taken by tangents, which end at the current of hover.
TEST(HoverTrim, IsAnEquilibriumOnACellWithTablesAndChargeTransfer) {
  const Vehicle vehicle = LoadVehicle("mambo-coupled");
  Cell cell = LoadCell("gifi-600mAh-1");
  const double plain_V = [&] {
    BatterySupply battery(cell, 0.8);
    return HoverTrim(vehicle, battery).battery_V;
  }();
  cell.series_resistance_Ohm = {{0.0, 0.4, 1.0}, {0.2, 0.13, 0.12}};
  cell.charge_transfer = {.current_A = 0.4, .resistance_Ohm = {{0.0, 0.5}, {0.09, 0.04}}};
  BatterySupply battery(cell, 0.8);
  const Trim trim = HoverTrim(vehicle, battery);
  ASSERT_TRUE(trim.possible());
  EXPECT_LT(LargestRate(vehicle, trim, battery.Linearize()), 1e-9);
  // The cell's own equation at the current of hover.
  const CellModel<double> model(cell.Parameters());
  EXPECT_NEAR(model.Voltage(model.Relaxed(0.8), trim.battery_A), trim.battery_V, 1e-13);
  EXPECT_LT(trim.battery_V, plain_V - 0.01);
}

TEST(HoverTrim, AgreesWithTheFiguresOfTheCorrections) {
  BatterySupply coupled(LoadCell("gifi-600mAh-1"), 1.0);
  BatterySupply physical(LoadCell("gifi-600mAh-1"), 1.0);
  // "about 3.3 A" and "about 2.4 A".
  EXPECT_NEAR(HoverTrim(LoadVehicle("mambo-coupled"), coupled).battery_A, 3.3, 0.05);
  EXPECT_NEAR(HoverTrim(LoadVehicle("mambo-physical"), physical).battery_A, 2.4, 0.05);
}

TEST(HoverTrim, CommandsTheSpeedItselfWithCompensation) {
  const Vehicle vehicle = LoadVehicle("mambo-coupled");
  BatterySupply battery(LoadCell("gifi-600mAh-1"), 0.7);
  const Trim trim = HoverTrim(vehicle, battery, /*compensate=*/true);
  EXPECT_NEAR(trim.commanded_speed_rad_per_s, trim.speed_rad_per_s, 1e-9);
  const Trim nominal = HoverTrim(vehicle, battery);
  EXPECT_GT(nominal.commanded_speed_rad_per_s, 1.05 * nominal.speed_rad_per_s);
}

TEST(HoverTrim, SaysThatASupplyIsTooWeak) {
  const Vehicle vehicle = LoadVehicle("mambo-thesis");
  const Trim low = HoverTrim(vehicle, Supply<double>{2.9, 0.0});
  EXPECT_TRUE(low.power_suffices);
  EXPECT_GT(low.duty, 1.0);
  EXPECT_FALSE(low.possible());
  // E²/(4 R) is the most that a source gives: here 1.8 W, where the motors need 27 W.
  const Trim soft = HoverTrim(vehicle, Supply<double>{4.2, 2.45});
  EXPECT_FALSE(soft.power_suffices);
  EXPECT_FALSE(soft.possible());
  EXPECT_DOUBLE_EQ(soft.battery_V, 2.1);
}

TEST(HoverTrim, IsAnEquilibriumOfEveryLayoutWithLossesAndAvionics) {
  for (const auto& [layout, name] : OptionNames(RotorLayout{})) {
    for (const bool synchronous : {true, false}) {
      Vehicle vehicle = LoadVehicle("mambo-physical");
      vehicle.layout = layout;
      vehicle.mass_kg *= double(vehicle.rotor_count()) / 4.0;
      if (RotorsOf(layout)[1].lower) vehicle.lower_rotor_thrust_ratio = 0.85;
      vehicle.esc = {.resistance_Ohm = 0.02,
                     .switching_time_s = 2e-7,
                     .switching_frequency_Hz = 2e4,
                     .diode_V = synchronous ? 0.0 : 0.3,
                     .synchronous = synchronous};
      vehicle.avionics_power_W = 0.5;
      const Supply<double> supply{4.2, 0.05};
      const Trim trim = HoverTrim(vehicle, supply);
      EXPECT_TRUE(trim.possible()) << name;
      // Rounding of speeds of 2000 rad/s with time constants of 18 ms.
      EXPECT_LT(LargestRate(vehicle, trim, supply), 1e-8) << name;
    }
  }
}

}  // namespace
}  // namespace lipoid
