#include "identify/vehicle/vehicle_builder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "model/core/errors.h"
#include "model/vehicle/vehicle_file.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

BuilderNumbers Racer() {
  BuilderNumbers n;
  n.name = "racer";
  n.mass_g = 650.0;
  n.frame_mm = 220.0;
  n.series_cells = 4;
  n.kv_rpm_per_V = 2400.0;
  n.winding_resistance_Ohm = 0.06;
  n.no_load_A = 1.2;
  n.propeller_in = 5.0;
  n.pitch_in = 4.3;
  n.blades = 3;
  return n;
}

std::string Refusal(const BuilderNumbers& numbers) {
  return test::MessageOf<OptionError>([&] { (void)BuildVehicle(numbers, {}); });
}

TEST(VehicleBuilder, ConvertsWhatIsGiven) {
  BuilderNumbers n = Racer();
  n.payload_g = 50.0;
  n.pitch_in.reset();
  n.thrust_coefficient = 0.15;
  n.power_coefficient = 0.1;
  n.avionics_W = 4.0;
  const Vehicle v = BuildVehicle(n, {}).vehicle;
  EXPECT_DOUBLE_EQ(v.mass_kg, 0.7);
  EXPECT_DOUBLE_EQ(v.arm_m, 0.11);
  EXPECT_DOUBLE_EQ(v.nominal_voltage_V, 16.8);
  EXPECT_EQ(v.series_cells, 4);
  EXPECT_EQ(v.avionics_power_W, 4.0);
  EXPECT_DOUBLE_EQ(v.propeller_diameter_m, 0.127);
  // KV volts turn it without load: 2400 rpm at 1 V.
  EXPECT_NEAR(1.0 / v.motor_constant_N_m_per_A * 30.0 / std::numbers::pi, 2400.0, 1e-9);
  // Thrust and power at a hundred turns a second, by the definition of the coefficients.
  const double speed = 2.0 * std::numbers::pi * 100.0;
  EXPECT_NEAR(
      v.thrust_coefficient_N_s2 * speed * speed, 0.15 * 1.225 * 1e4 * std::pow(0.127, 4), 1e-12);
  EXPECT_NEAR(v.torque_coefficient_N_m_s2 * speed * speed * speed,
              0.1 * 1.225 * 1e6 * std::pow(0.127, 5),
              1e-12);
  // Without load, at 10 V, it draws 1.2 A at the speed that 10 V less the winding's share give.
  const double free_speed = (10.0 - 0.06 * 1.2) / v.motor_constant_N_m_per_A;
  EXPECT_NEAR(v.friction_N_m_s * free_speed / v.motor_constant_N_m_per_A, 1.2, 1e-12);
}

TEST(VehicleBuilder, SaysWhereEveryNumberIsFromAndWhatIsAssumed) {
  const VehicleDraft draft = BuildVehicle(Racer(), {});
  const std::string text = VehicleToToml(draft.vehicle, draft.sources);
  const Vehicle read = ParseVehicle(text, "v.toml");
  EXPECT_EQ(VehicleToToml(read, draft.sources), text);
  for (const auto& [key, from] : draft.sources) EXPECT_FALSE(from.empty()) << key;
  for (const std::string& key : draft.assumed) {
    const bool named = text.find(key + " = \"assumed") != std::string::npos;
    EXPECT_TRUE(named || key == "esc_resistance_Ohm") << key;
  }
  EXPECT_NE(std::find(draft.assumed.begin(), draft.assumed.end(), "inertia_kg_m2"),
            draft.assumed.end());
  EXPECT_EQ(std::find(draft.assumed.begin(), draft.assumed.end(), "mass_kg"), draft.assumed.end());
}

// The measured propeller comes back, more pitch and more blades give more thrust.
TEST(VehicleBuilder, TypicalPropellersAreScaledFromAMeasuredOne) {
  const auto apc = TypicalPropeller(0.47, 2);
  EXPECT_NEAR(apc.thrust, 0.1185, 1e-12);
  EXPECT_NEAR(apc.power, 0.048, 0.05 * 0.048);  // by a merit of 0.65, its own is 0.68
  EXPECT_GT(TypicalPropeller(0.5, 2).thrust, apc.thrust);
  EXPECT_GT(TypicalPropeller(0.47, 3).thrust, apc.thrust);
  // Coefficients of tests that were not used (CTU MRS, docs/vehicles.md): within 25 %.
  EXPECT_NEAR(TypicalPropeller(5.0 / 9.4, 2).thrust, 0.110, 0.25 * 0.110);
  EXPECT_NEAR(TypicalPropeller(4.5 / 10.0, 2).thrust, 0.108, 0.25 * 0.108);
  EXPECT_NEAR(TypicalPropeller(4.5 / 8.0, 2).thrust, 0.155, 0.25 * 0.155);
  EXPECT_NEAR(TypicalPropeller(5.5 / 15.0, 2).thrust, 0.095, 0.25 * 0.095);
  // Emax Eco 2306 with HQ 5 x 4 x 3, Mini Quad Test Bench (racer-5in): before, 0.262.
  EXPECT_NEAR(TypicalPropeller(0.8, 3).thrust, 0.1495, 0.25 * 0.1495);
  EXPECT_NEAR(TypicalPropeller(0.8, 3).power, 0.1134, 0.25 * 0.1134);
}

// Of 650 g and 110 mm: m l² is 0.0079 kg m², a propeller of 5 inch 2.9e-6 kg m².
TEST(VehicleBuilder, CautionsOfSizesThatAreInAnotherUnit) {
  const auto cautions = [](const BuilderNumbers& n) {
    std::string all;
    for (const std::string& caution : BuildVehicle(n, {}).cautions) all += caution + "\n";
    return all;
  };
  const auto says = [&](const BuilderNumbers& n, const std::string& what) {
    return cautions(n).find(what) != std::string::npos;
  };
  BuilderNumbers n = Racer();
  n.inertia_kg_m2 = {0.002, 0.002, 0.0036};
  n.rotor_inertia_kg_m2 = 5e-6;
  n.drag_N_s_per_m = 0.3;
  for (const char* option : {"--inertia", "--rotor-inertia", "--drag"})
    EXPECT_FALSE(says(n, option));
  n.inertia_kg_m2 = {200.0, 200.0, 360.0};
  n.rotor_inertia_kg_m2 = 0.36;
  n.drag_N_s_per_m = 480.0;
  EXPECT_TRUE(
      says(n,
           "--inertia-kg-m2 360 is 4.6e+04 times mass times arm squared, 0.0079 kg m²: it is in "
           "kg m²"))
      << cautions(n);
  EXPECT_TRUE(says(n, "--rotor-inertia-kg-m2 0.36 is 1.3e+05 times that of a typical propeller"))
      << cautions(n);
  EXPECT_TRUE(says(n, "--drag-N-s-per-m 480 is 2.5e+03 times 0.3 per second of the mass"))
      << cautions(n);
  n.propeller_g = 4.0;
  EXPECT_EQ(
      Refusal(n),
      "option --propeller-g: it says how heavy the rotor is to turn, which --rotor-inertia-kg-m2 says "
      "already; leave one of the two out");
}

TEST(VehicleBuilder, RefusesWhatNoVehicleCanBe) {
  BuilderNumbers n = Racer();
  n.mass_g = 20000.0;
  EXPECT_EQ(Refusal(n).substr(0, 70),
            "this vehicle cannot hover: at 14.8 V (4 cells of 3.7 V) its 4 rotors g");
  EXPECT_TRUE(Refusal(n).ends_with("Give more cells, larger propellers, another KV or less mass"));
  n = Racer();
  n.winding_resistance_Ohm = 60.0;
  n.no_load_A = 0.1;
  EXPECT_TRUE(Refusal(n).ends_with(
      "Its motors would take 0.25 A when they are held: is --winding-resistance-Ohm in mOhm?"))
      << Refusal(n);
  n = Racer();
  n.propeller_in = 7.0;
  EXPECT_EQ(Refusal(n),
            "the propellers would touch: 7 inch are 178 mm, and neighbouring motors of a quad-x of "
            "220 mm are 156 mm apart. Give a smaller --propeller-in or a larger --frame-mm");
  n = Racer();
  n.pitch_in.reset();
  EXPECT_EQ(Refusal(n),
            "nothing says what the propeller does: give --bench-table, or --thrust-coefficient and "
            "--power-coefficient, or --pitch-in");
  n.thrust_coefficient = 0.2;
  EXPECT_EQ(Refusal(n),
            "options --thrust-coefficient and --power-coefficient: give both, or --pitch-in for "
            "typical ones");
  n.power_coefficient = 0.05;
  EXPECT_EQ(Refusal(n).substr(0, 52), "the propeller's figure of merit would be 1.43, and n");
  n = Racer();
  n.winding_resistance_Ohm.reset();
  EXPECT_EQ(Refusal(n),
            "the motor's resistance is missing: give --winding-resistance-Ohm, between two of its "
            "three wires, or --bench-table");
  n = Racer();
  n.no_load_A = 200.0;
  EXPECT_EQ(Refusal(n),
            "--no-load-A 200 through --winding-resistance-Ohm 0.06 takes more than the 10 V of "
            "--no-load-V: one of the three is wrong");
  n = Racer();
  n.lower_rotor_thrust_ratio = 0.8;
  EXPECT_EQ(Refusal(n),
            "option --lower-rotor-thrust-ratio: the layout has no lower rotors; leave it out, or "
            "give --layout y6 or x8");
}

TEST(VehicleBuilder, PropellersWeighLessThanTheVehicleAndHaveAPitch) {
  BuilderNumbers n = Racer();
  n.mass_g = 0.65;
  // 0.085 g for each of 25 square inches.
  EXPECT_EQ(
      Refusal(n),
      "the propellers would outweigh the vehicle: 4 of 2.125 g (assumed from their diameter) "
      "are 8.5 g, and --mass-g is 0.65 g with them. Check --mass-g and --propeller-g, both in g");
  n = Racer();
  n.propeller_g = 200.0;
  EXPECT_TRUE(Refusal(n).starts_with(
      "the propellers would outweigh the vehicle: 4 of 200 g are 800 g, and --mass-g is 650 g"));
  n = Racer();
  n.pitch_in = 0.0;
  EXPECT_TRUE(
      Refusal(n).starts_with("option --pitch-in: a propeller without pitch is a flat plate"));
}

TEST(VehicleBuilder, LossesBySwitchingNeedTimeAndFrequency) {
  BuilderNumbers n = Racer();
  n.esc.switching_time_s = 1e-7;
  EXPECT_EQ(Refusal(n),
            "option --esc-switching-ns: the losses by switching are the product of time and "
            "frequency, and there is no frequency; give --esc-pwm-kHz too, or leave both out");
  n.esc.switching_frequency_Hz = 24e3;
  EXPECT_NEAR(BuildVehicle(n, {}).vehicle.esc.SwitchingShare(), 2.4e-3, 1e-15);
  n.esc.switching_time_s = 0.0;
  EXPECT_TRUE(Refusal(n).starts_with("option --esc-pwm-kHz: "));
}

// A fit at its bound has no error, and no losses have no frequency.
TEST(VehicleBuilder, ABenchTableMayShowNoSwitching) {
  BuilderNumbers n = Racer();
  n.bench_name = "bench.csv";
  n.esc.switching_frequency_Hz = 24e3;
  BenchFit fit;
  fit.thrust_coefficient_N_s2 = {"thrust_coefficient_N_s2", 1.4e-6, 1e-8, 1.3e-6, 1.5e-6, true};
  fit.torque_coefficient_N_m_s2 = {"torque_coefficient_N_m_s2", 2e-8, 1e-10, 1.9e-8, 2.1e-8, true};
  fit.motor_constant_N_m_per_A = {"motor_constant_N_m_per_A", 0.004, 0.0, 0.004, 0.004, false};
  fit.resistance_Ohm = {"armature_resistance_Ohm", 0.08, 0.002, 0.076, 0.084, true};
  fit.friction_N_m_s = {"friction_N_m_s", 1e-6, 1e-8, 0.9e-6, 1.1e-6, true};
  const double none = std::numeric_limits<double>::quiet_NaN();
  fit.switching_share = {"switching_share", 0.0, none, none, none, true};
  fit.throttle_exponent = {"throttle_exponent", 1.0, 0.01, 0.98, 1.02, true};
  const VehicleDraft draft = BuildVehicle(n, fit);
  EXPECT_EQ(draft.vehicle.esc.SwitchingShare(), 0.0);
  EXPECT_EQ(VehicleToToml(draft.vehicle, draft.sources).find("nan"), std::string::npos);
  EXPECT_EQ(draft.cautions.back(),
            "bench.csv shows no losses by switching, so that --esc-pwm-kHz changes nothing");
}

// Each is one number in another unit.
TEST(VehicleBuilder, WhatCanHardlyBeMeantIsDoubted) {
  // The law of the propeller is poor at three blades and a pitch of 0.86 diameters.
  const auto doubts = BuildVehicle(Racer(), {}).cautions;
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_TRUE(doubts[0].starts_with(
      "thrust and power of a propeller of 3 blades and a pitch of 0.86 diameters may be off by "
      "40 %: beyond 2 blades"))
      << doubts[0];
  BuilderNumbers plain = Racer();
  plain.blades = 2;
  plain.pitch_in = 2.2;
  EXPECT_TRUE(BuildVehicle(plain, {}).cautions.empty());
  const auto cautions = [](auto&& change) {
    BuilderNumbers n = Racer();
    change(n);
    std::string all;
    for (const std::string& caution : BuildVehicle(n, {}).cautions) all += caution + "\n";
    return all;
  };
  const auto says = [](const std::string& all, std::string_view part) {
    return all.find(part) != std::string::npos;
  };
  const std::string light = cautions([](auto& n) { n.mass_g = 65.0; });
  EXPECT_TRUE(says(light, "times the weight, and no multirotor has more than 20 times: check"))
      << light;
  const std::string pitch = cautions([](auto& n) { n.pitch_in = 10.0; });
  EXPECT_TRUE(says(pitch, "is 2 diameters of the propeller, where 0.2 to 1.5 are usual")) << pitch;
  try {
    (void)cautions([](auto& n) { n.pitch_in = 4.3 * 25.4; });
    ADD_FAILURE() << "a pitch in mm was believed";
  } catch (const OptionError& error) {
    EXPECT_TRUE(says(error.what(), "expected a pitch of 0.05 to 3 diameters of the propeller"))
        << error.what();
  }
  const std::string kv = cautions([](auto& n) { n.kv_rpm_per_V = 24000.0; });
  EXPECT_TRUE(says(kv, "% of their power into that of the propellers")) << kv;
  const std::string avionics = cautions([](auto& n) { n.avionics_W = 5000.0; });
  EXPECT_TRUE(says(avionics, "--avionics-W 5000 is more than the 143 W that the motors take"))
      << avionics;
}

// What the bench sees in series is winding and controller.
TEST(VehicleBuilder, AGivenWindingLeavesTheRestToTheController) {
  BuilderNumbers n = Racer();
  n.bench_name = "bench.csv";
  BenchFit fit;
  fit.thrust_coefficient_N_s2 = {"thrust_coefficient_N_s2", 1.4e-6, 1e-8, 1.3e-6, 1.5e-6, true};
  fit.torque_coefficient_N_m_s2 = {"torque_coefficient_N_m_s2", 2e-8, 1e-10, 1.9e-8, 2.1e-8, true};
  fit.motor_constant_N_m_per_A = {"motor_constant_N_m_per_A", 0.004, 0.0, 0.004, 0.004, false};
  fit.resistance_Ohm = {"armature_resistance_Ohm", 0.08, 0.002, 0.076, 0.084, true};
  fit.friction_N_m_s = {"friction_N_m_s", 1e-6, 1e-8, 0.9e-6, 1.1e-6, true};
  fit.switching_share = {"switching_share", 0.0, 0.0, 0.0, 0.0, false};
  fit.throttle_exponent = {"throttle_exponent", 1.0, 0.01, 0.98, 1.02, true};
  const Vehicle v = BuildVehicle(n, fit).vehicle;
  EXPECT_DOUBLE_EQ(v.armature_resistance_Ohm, 0.06);
  EXPECT_DOUBLE_EQ(v.esc.resistance_Ohm, 0.02);
  EXPECT_EQ(v.thrust_coefficient_N_s2, 1.4e-6);
  // A winding that the fit cannot tell from its own leaves nothing; a larger one cannot be.
  n.winding_resistance_Ohm = 0.083;
  EXPECT_EQ(BuildVehicle(n, fit).vehicle.armature_resistance_Ohm, 0.08);
  n.winding_resistance_Ohm = 5.0;
  const auto refusal = [&] {
    return test::MessageOf<OptionError>([&] { (void)BuildVehicle(n, fit); });
  };
  EXPECT_EQ(
      refusal(),
      "option --winding-resistance-Ohm: 5 Ohm are more than the 0.08 Ohm that the fit to "
      "bench.csv finds for winding and controller together; leave the option out, or give the "
      "resistance between two of the three wires");
  n.winding_resistance_Ohm = 0.06;
  n.esc.resistance_Ohm = 0.005;
  EXPECT_TRUE(refusal().starts_with(
      "option --esc-resistance-mOhm: the fit to bench.csv finds winding and controller together"));
  n.esc.resistance_Ohm = 0.0;
  EXPECT_TRUE(BuildVehicle(n, fit).cautions.empty());
  fit.current_rms = 0.08;
  fit.switching_share.estimate = 0.1;
  EXPECT_EQ(BuildVehicle(n, fit).cautions.size(), 2u);
  n.winding_resistance_Ohm.reset();
  const Vehicle whole = BuildVehicle(n, fit).vehicle;
  EXPECT_DOUBLE_EQ(whole.armature_resistance_Ohm, 0.08);
  EXPECT_EQ(whole.esc.resistance_Ohm, 0.0);
}

}  // namespace
}  // namespace lipoid
