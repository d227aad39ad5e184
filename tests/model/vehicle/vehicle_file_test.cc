#include "model/vehicle/vehicle_file.h"

#include <gtest/gtest.h>
#include <toml++/toml.h>

#include <cmath>
#include <numbers>
#include <string>
#include <string_view>

#include "model/core/errors.h"
#include "model/vehicle/motor.h"
#include "tests/support/paths.h"
#include "tests/support/text_files.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

constexpr std::string_view kText = R"(name = "test"
mass_kg = 0.5
inertia_kg_m2 = [1e-3, 2e-3, 2.5e-3]
arm_m = 0.2
thrust_coefficient_N_s2 = 1e-6
torque_coefficient_N_m_s2 = 2e-8
motor_constant_N_m_per_A = 0.01
armature_resistance_Ohm = 0.1
friction_N_m_s = 0
rotor_inertia_kg_m2 = 1e-5
nominal_voltage_V = 12
)";

std::string Replaced(std::string_view from, std::string_view to) {
  std::string text(kText);
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string Refusal(const std::string& text) {
  return test::MessageOf<LoadError>([&] { (void)ParseVehicle(text, "v.toml"); });
}

// Appended, not added: GCC 12 warns of the sum of a long literal and a short one.
std::string With(std::string_view line) {
  std::string text(kText);
  text += line;
  return text;
}

TEST(VehicleFile, HoldsWhatItSays) {
  const Vehicle v = ParseVehicle(With("summary = \"one line\"\narmature_inductance_H = 3e-6\n"
                                      "pwm_range = [1000, 2000]\nlinear_drag_N_s_per_m = 0.25\n"
                                      "[source]\nmass_kg = \"weighed\"\n"),
                                 "v.toml");
  EXPECT_EQ(v.name, "test");
  EXPECT_EQ(v.summary, "one line");
  EXPECT_EQ(v.mass_kg, 0.5);
  EXPECT_EQ(v.inertia_kg_m2, (std::array{1e-3, 2e-3, 2.5e-3}));
  EXPECT_EQ(v.arm_m, 0.2);
  EXPECT_EQ(v.thrust_coefficient_N_s2, 1e-6);
  EXPECT_EQ(v.torque_coefficient_N_m_s2, 2e-8);
  EXPECT_EQ(v.motor_constant_N_m_per_A, 0.01);
  EXPECT_EQ(v.armature_resistance_Ohm, 0.1);
  EXPECT_EQ(v.armature_inductance_H, 3e-6);
  EXPECT_EQ(v.friction_N_m_s, 0.0);
  EXPECT_EQ(v.rotor_inertia_kg_m2, 1e-5);
  EXPECT_EQ(v.nominal_voltage_V, 12.0);
  EXPECT_EQ(v.pwm_range, (std::array{1000.0, 2000.0}));
  EXPECT_EQ(v.linear_drag_N_s_per_m, 0.25);
}

TEST(VehicleFile, WhatMayBeAbsentHasTheDefaultsOfAVehicle) {
  const Vehicle v = ParseVehicle(std::string(kText), "v.toml");
  EXPECT_EQ(v.summary, "");
  EXPECT_EQ(v.armature_inductance_H, 0.0);
  EXPECT_EQ(v.pwm_range, (std::array{10.0, 500.0}));
  EXPECT_EQ(v.linear_drag_N_s_per_m, 0.0);
}

TEST(VehicleFile, EveryMistakeIsNamedAtOnce) {
  EXPECT_EQ(Refusal(Replaced("arm_m = 0.2\n", "")),
            "v.toml:1:1: error: expected the key arm_m, found none");
  EXPECT_EQ(Refusal("name = \"\"\ninertia_kg_m2 = [1e-3, nan, 2.5e-3]\narm_m = \"long\"\n"),
            "v.toml:1:1: error: expected the keys mass_kg, thrust_coefficient_N_s2, "
            "torque_coefficient_N_m_s2, motor_constant_N_m_per_A, armature_resistance_Ohm, "
            "friction_N_m_s, rotor_inertia_kg_m2, nominal_voltage_V, found none\n"
            "v.toml:1:8: error: name: expected a text in quotes, found ''\n"
            "v.toml:2:24: error: inertia_kg_m2: expected the moments J_x, J_y, J_z from 1e-13 to "
            "1e+07 kg m², found nan\n"
            "v.toml:3:9: error: arm_m: expected a length from 0.0001 to 100 m, found 'long'");
  const std::string bad = Replaced("mass_kg = 0.5", "mass_kg = -0.5\ncolour = \"red\"");
  EXPECT_EQ(Refusal(bad + "pwm_range = [500, 10]\n[source]\nmas_kg = \"weighed\"\nmass_kg = 1\n"),
            "v.toml:2:11: error: mass_kg: expected a mass from 1e-05 to 100000 kg, found -0.5\n"
            "v.toml:3:1: error: expected one of the keys name, summary, mass_kg, inertia_kg_m2, "
            "arm_m, layout, front_right_turns, thrust_coefficient_N_s2, torque_coefficient_N_m_s2, "
            "lower_rotor_thrust_ratio, propeller_diameter_m, motor_constant_N_m_per_A, "
            "armature_resistance_Ohm, armature_inductance_H, friction_N_m_s, rotor_inertia_kg_m2, "
            "nominal_voltage_V, series_cells, pwm_range, esc_resistance_Ohm, esc_switching_time_s, "
            "esc_switching_frequency_Hz, esc_rectification, esc_diode_V, avionics_power_W, "
            "linear_drag_N_s_per_m, source, found 'colour'\n"
            "v.toml:13:13: error: pwm_range: expected the integers of D = 0 and D = 1, [10, 500], "
            "the first below the second, found [500, 10]\n"
            "v.toml:15:1: error: expected one of the keys mass_kg, inertia_kg_m2, arm_m, "
            "layout, front_right_turns, thrust_coefficient_N_s2, torque_coefficient_N_m_s2, "
            "lower_rotor_thrust_ratio, propeller_diameter_m, motor_constant_N_m_per_A, "
            "armature_resistance_Ohm, armature_inductance_H, friction_N_m_s, rotor_inertia_kg_m2, "
            "nominal_voltage_V, series_cells, pwm_range, esc_resistance_Ohm, esc_switching_time_s, "
            "esc_switching_frequency_Hz, esc_rectification, esc_diode_V, avionics_power_W, "
            "linear_drag_N_s_per_m, found 'mas_kg'; is it 'mass_kg'?\n"
            "v.toml:16:11: error: mass_kg: expected a text in quotes, found 1");
}

TEST(VehicleFile, RotorsControllersAndWhatElseTheBatteryFeeds) {
  const Vehicle v = ParseVehicle(
      With("layout = \"x8\"\nlower_rotor_thrust_ratio = 0.8\npropeller_diameter_m = 0.254\n"
           "series_cells = 6\nesc_resistance_Ohm = 0.004\nesc_switching_time_s = 1e-7\n"
           "esc_switching_frequency_Hz = 24000\nesc_rectification = \"diode\"\n"
           "esc_diode_V = 0.7\navionics_power_W = 6\n"),
      "v.toml");
  EXPECT_EQ(v.layout, RotorLayout::kX8);
  EXPECT_EQ(v.rotor_count(), 8u);
  EXPECT_EQ(v.lower_rotor_thrust_ratio, 0.8);
  EXPECT_DOUBLE_EQ(v.total_thrust_coefficient_N_s2(), 7.2 * v.thrust_coefficient_N_s2);
  EXPECT_EQ(v.propeller_diameter_m, 0.254);
  EXPECT_EQ(v.series_cells, 6);
  EXPECT_EQ(v.esc.resistance_Ohm, 0.004);
  EXPECT_DOUBLE_EQ(v.esc.SwitchingShare(), 0.0024);
  EXPECT_FALSE(v.esc.synchronous);
  EXPECT_EQ(v.esc.diode_V, 0.7);
  EXPECT_EQ(v.avionics_power_W, 6.0);
}

TEST(VehicleFile, WithoutFurtherKeysItIsTheQuadrotorOfTheThesis) {
  const Vehicle v = ParseVehicle(std::string(kText), "v.toml");
  EXPECT_EQ(v.layout, RotorLayout::kQuadX);
  EXPECT_EQ(v.rotor_count(), 4u);
  EXPECT_EQ(v.total_thrust_coefficient_N_s2(), 4.0 * v.thrust_coefficient_N_s2);
  EXPECT_EQ(v.lower_rotor_thrust_ratio, 1.0);
  EXPECT_EQ(v.propeller_diameter_m, 0.0);
  EXPECT_EQ(v.series_cells, 0);
  EXPECT_TRUE(v.esc.lossless());
  EXPECT_EQ(v.avionics_power_W, 0.0);
}

TEST(VehicleFile, WhatRotorsAndControllersCannotBe) {
  EXPECT_EQ(Refusal(With("layout = \"tri\"\n")),
            "v.toml:12:10: error: layout: expected one of quad-x, quad-plus, hexa-x, hexa-plus, "
            "octo-x, octo-plus, y6, x8, found 'tri'");
  EXPECT_EQ(Refusal(With("layout = \"hexa-x\"\nlower_rotor_thrust_ratio = 0.8\n")),
            "v.toml:13:28: error: lower_rotor_thrust_ratio: expected a layout of coaxial pairs, y6 "
            "or x8; this layout has no lower rotors");
  EXPECT_EQ(Refusal(With("esc_diode_V = 0.7\n")),
            "v.toml:12:15: error: esc_diode_V: expected 0 V where esc_rectification is "
            "synchronous, because the current then flows through transistors, found 0.7");
  EXPECT_EQ(Refusal(With("esc_rectification = \"no\"\nseries_cells = 0\n")),
            "v.toml:12:21: error: esc_rectification: expected one of synchronous, diode, found "
            "'no'\nv.toml:13:16: error: series_cells: expected an integer from 1 to 1000, found "
            "0");
}

TEST(VehicleFile, MotorsTurnEitherWay) {
  const std::string text(kText);
  EXPECT_EQ(ParseVehicle(text, "v.toml").front_right_turns, Turning::kClockwise);
  EXPECT_EQ(ParseVehicle("front_right_turns = \"counter-clockwise\"\n" + text, "v.toml")
                .front_right_turns,
            Turning::kCounterClockwise);
  EXPECT_EQ(Refusal("front_right_turns = \"left\"\n" + text),
            "v.toml:1:21: error: front_right_turns: expected one of clockwise, counter-clockwise, "
            "found 'left'");
}

TEST(VehicleFile, EveryNumberMustBeInItsRange) {
  for (const char* const key : {"mass_kg",
                                "arm_m",
                                "thrust_coefficient_N_s2",
                                "torque_coefficient_N_m_s2",
                                "motor_constant_N_m_per_A",
                                "armature_resistance_Ohm",
                                "rotor_inertia_kg_m2",
                                "nominal_voltage_V"}) {
    std::string text(kText);
    const auto line = text.find("\n" + std::string(key) + " = ") + 1;
    const auto end = text.find('\n', line);
    for (const char* const value : {"0", "-1.0", "nan", "inf", "\"1\"", "true"}) {
      const std::string bad =
          text.substr(0, line) + std::string(key) + " = " + value + text.substr(end);
      EXPECT_NE(Refusal(bad).find(std::string(key) + ": expected a"), std::string::npos)
          << key << " = " << value;
    }
  }
  for (const char* const key :
       {"armature_inductance_H", "friction_N_m_s", "linear_drag_N_s_per_m"}) {
    std::string text = Replaced("friction_N_m_s = 0\n", "");
    if (std::string_view(key) != "friction_N_m_s") text += "friction_N_m_s = 0\n";
    EXPECT_NO_THROW((void)ParseVehicle(text + key + " = 0\n", "v.toml")) << key;
    EXPECT_NE(Refusal(text + key + " = -1e-9\n").find("from 0 to "), std::string::npos) << key;
  }
}

TEST(VehicleFile, RefusesABodyThatCannotBe) {
  // Table 6.1 as printed.
  EXPECT_EQ(Refusal(Replaced("[1e-3, 2e-3, 2.5e-3]", "[5e-4, 7e-4, 1e-4]")),
            "v.toml:3:17: error: inertia_kg_m2: expected moments of a body that can be, each at "
            "most the sum of the other two, found J_y = 0.0007 above J_x + J_z = 0.0006");
  EXPECT_EQ(Refusal(Replaced("[1e-3, 2e-3, 2.5e-3]", "[1e-3, 2e-3, 3.1e-3]")),
            "v.toml:3:17: error: inertia_kg_m2: expected moments of a body that can be, each at "
            "most the sum of the other two, found J_z = 0.0031 above J_x + J_y = 0.003");
  EXPECT_EQ(Refusal(Replaced("[1e-3, 2e-3, 2.5e-3]", "[1e-3, 2e-3]")),
            "v.toml:3:17: error: inertia_kg_m2: expected 3 numbers, the moments J_x, J_y, J_z "
            "from 1e-13 to 1e+07 kg m², found 2");
  // A flat plate is a body: its third moment is the sum of the others, 0.1 + 0.7 < 0.8 in binary.
  EXPECT_NO_THROW(
      (void)ParseVehicle(Replaced("[1e-3, 2e-3, 2.5e-3]", "[0.1, 0.7, 0.8]"), "v.toml"));
}

TEST(VehicleFile, RefusesARangeOfThePwmThatIsNoRangeOfIntegers) {
  EXPECT_EQ(Refusal(With("pwm_range = [0.5, 500]\n")),
            "v.toml:12:13: error: pwm_range: expected the integers of D = 0 and D = 1, [10, 500], "
            "the first below the second, found [0.5, 500]");
  EXPECT_EQ(Refusal(With("pwm_range = [7, 7]\n")).find("v.toml:12:13"), 0U);
}

TEST(VehicleFile, ReadsFilesByNameAndShippedOnesByTheirs) {
  const std::string file = test::WriteText("mine.toml", kText);
  EXPECT_EQ(LoadVehicle(file).name, "test");
  EXPECT_EQ(LoadVehicle(file).mass_kg, 0.5);
  EXPECT_EQ(ShippedVehicleNames(),
            (std::vector<std::string>{"camera-10in",
                                      "f450",
                                      "hexacopter",
                                      "mambo-coupled",
                                      "mambo-physical",
                                      "mambo-thesis",
                                      "racer-5in"}));
  EXPECT_EQ(test::MessageOf<LoadError>([] { (void)LoadVehicle("mambo"); }),
            "mambo: error: expected a vehicle file or one of the shipped vehicles "
            "(camera-10in, f450, hexacopter, mambo-coupled, mambo-physical, mambo-thesis, "
            "racer-5in), found neither");
  EXPECT_EQ(test::MessageOf<LoadError>([] { (void)LoadVehicle("no/such.toml"); }),
            "no/such.toml: error: expected a readable file, found none (No such file or "
            "directory)");
}

TEST(VehicleFile, ShippedVehiclesAreTable61Corrected) {
  // The propeller's figures: R = 33 mm, area pi R², Ct = 0.0107; k_T = Ct A R² [rho].
  constexpr double kRadius = 0.033;
  constexpr double kArea = std::numbers::pi * kRadius * kRadius;
  constexpr double kDensity = 1.184;
  constexpr double kThrust = 0.0107 * kArea * kRadius * kRadius;
  constexpr double kPrintedDigits = 5e-5;  // five digits are printed
  struct Row {
    const char* name;
    double thrust, torque, friction;
  };
  for (const Row& row : {Row{"mambo-thesis", kThrust, 9.6223e-11, 1e-6},
                         Row{"mambo-coupled", kThrust, 9.6223e-11, 3.5e-7},
                         Row{"mambo-physical", kDensity * kThrust, 2.54e-10, 3e-8}}) {
    SCOPED_TRACE(row.name);
    const Vehicle v = LoadVehicle(row.name);
    EXPECT_EQ(v.name, row.name);
    EXPECT_FALSE(v.summary.empty());
    EXPECT_EQ(v.mass_kg, 0.063);
    EXPECT_EQ(v.inertia_kg_m2, (std::array{5.82857e-5, 7.16914e-5, 1e-4}));
    EXPECT_EQ(v.arm_m, 0.062);
    EXPECT_NEAR(v.thrust_coefficient_N_s2, row.thrust, kPrintedDigits * row.thrust);
    EXPECT_EQ(v.torque_coefficient_N_m_s2, row.torque);
    EXPECT_EQ(v.motor_constant_N_m_per_A, 7.4041e-4);
    EXPECT_EQ(v.armature_resistance_Ohm, 0.49);
    EXPECT_EQ(v.armature_inductance_H, 0.0);
    EXPECT_EQ(v.friction_N_m_s, row.friction);
    EXPECT_EQ(v.rotor_inertia_kg_m2, 4.5156e-8);
    EXPECT_EQ(v.nominal_voltage_V, 4.2);
    EXPECT_EQ(v.pwm_range, (std::array{10.0, 500.0}));
    EXPECT_EQ(v.linear_drag_N_s_per_m, 0.02);
  }
}

// The embedded text is the file, and no number of it lacks its origin.
TEST(VehicleFile, ShippedVehiclesSayWhereEveryNumberIsFrom) {
  for (const auto& name : ShippedVehicleNames()) {
    SCOPED_TRACE(name);
    const std::string file = test::SourcePath("fixtures/vehicles/" + name + ".toml");
    EXPECT_EQ(LoadVehicle(file).torque_coefficient_N_m_s2,
              LoadVehicle(name).torque_coefficient_N_m_s2);
    const toml::table document = toml::parse_file(file);
    const toml::table& source = *document["source"].as_table();
    for (const auto& [key, value] : document) {
      if (value.is_string() || value.is_table()) continue;
      EXPECT_TRUE(source.contains(key.str())) << key.str();
    }
    for (const auto& [key, value] : source) {
      EXPECT_TRUE(document.contains(key.str())) << key.str();
    }
  }
}

TEST(VehicleFile, TheExampleInTheDocsIsOne) {
  const Vehicle v = ParseVehicle(test::DocsExample("docs/formats.md", "name = \"mine\""), "docs");
  EXPECT_EQ(v.name, "mine");
  EXPECT_EQ(v.friction_N_m_s, 3.5e-7);
}

}  // namespace
}  // namespace lipoid
