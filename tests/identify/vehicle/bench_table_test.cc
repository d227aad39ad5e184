#include "identify/vehicle/bench_table.h"

#include <gtest/gtest.h>

#include <numbers>

#include "model/core/errors.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

std::string Refusal(const std::string& text) {
  return test::MessageOf<LoadError>([&] { (void)ParseBenchTable(text, "b.csv"); });
}

TEST(BenchTable, IsReadAsVendorsPrintIt) {
  const auto table = ParseBenchTable(
      "Throttle (%),Thrust (g),RPM,Voltage (V),Current (A),Efficiency (g/W)\n"
      "50,401,5688,16.66,3.09,7.79\n60%,529,6508,16.61,4.80,6.64\n"
      "# a remark\n\n80,787,7788,16.48,9.05,5.28\n100,1024,9068,16.32,14.26,4.40\n",
      "b.csv");
  ASSERT_EQ(table.rows.size(), 4u);
  EXPECT_TRUE(table.has_speed);
  EXPECT_DOUBLE_EQ(table.rows[0].throttle, 0.5);
  EXPECT_DOUBLE_EQ(table.rows[1].throttle, 0.6);
  EXPECT_EQ(table.rows[0].voltage_V, 16.66);
  EXPECT_EQ(table.rows[3].current_A, 14.26);
  EXPECT_DOUBLE_EQ(table.rows[0].thrust_N, 0.401 * 9.80665);
  EXPECT_DOUBLE_EQ(table.rows[0].speed_rad_per_s, 5688.0 * 2.0 * std::numbers::pi / 60.0);
}

TEST(BenchTable, UnitsAreThoseOfTheHeader) {
  const std::string rows =
      "1500;16000;4000;0.5\n1600;16000;5000;0.6\n1700;16000;6000;0.7\n"
      "1800;16000;7000;0.8\n";
  const auto table = ParseBenchTable(
      "\xEF\xBB\xBFthrottle_us;voltage [mV];Current / mA;thrust (kg)\n" + rows, "b.csv");
  EXPECT_FALSE(table.has_speed);
  EXPECT_DOUBLE_EQ(table.rows[0].throttle, 0.5);
  EXPECT_DOUBLE_EQ(table.rows[0].voltage_V, 16.0);
  EXPECT_DOUBLE_EQ(table.rows[0].current_A, 4.0);
  EXPECT_DOUBLE_EQ(table.rows[0].thrust_N, 0.5 * 9.80665);
  // One speed in every unit; that of the air is none.
  const double rad_per_s = 100.0 * 2.0 * std::numbers::pi;
  for (const auto& [unit, value] : {std::pair{"krpm", "6"},
                                    {"Hz", "100"},
                                    {"rps", "100"},
                                    {"U/min", "6000"},
                                    {"rev/min", "6000"},
                                    {"m/s", ""}}) {
    const std::string speed = *value != '\0' ? value : "3";
    std::string text =
        std::string("duty,voltage (V),current (A),thrust (N),Speed (") + unit + ")\n";
    for (const char* row : {"0.5,16,4,1,", "0.6,16,5,2,", "0.7,16,6,3,", "0.8,16,7,4,"})
      text += row + speed + "\n";
    const auto with_speed = ParseBenchTable(text, "b.csv");
    ASSERT_EQ(with_speed.has_speed, *value != '\0') << unit;
    if (with_speed.has_speed) {
      EXPECT_DOUBLE_EQ(with_speed.rows[0].speed_rad_per_s, rad_per_s) << unit;
    }
  }
}

TEST(BenchTable, IdleRowsSayNothingAndCopiesCountOnce) {
  const std::string rows =
      "50,482,5568,16.82,3.41\n60,669,6522,16.74,5.47\n80,1055,8345,16.55,11.37\n"
      "100,1546,9836,16.26,19.88\n";
  const std::string header = "Throttle (%),Thrust (g),RPM,Voltage (V),Current (A)\n";
  const auto plain = ParseBenchTable(header + rows, "b.csv");
  EXPECT_TRUE(plain.remarks.empty());
  const auto table =
      ParseBenchTable(header + "0,0,0,16.8,0.02\n" + rows + rows + "3,0,0,16.8,0\n", "b.csv");
  EXPECT_EQ(table.rows, plain.rows);
  EXPECT_EQ(
      table.remarks,
      (std::vector<std::string>{
          "2 rows of b.csv left out: no thrust, the propeller stands",
          "4 rows of b.csv left out: the same numbers in every column as a row before, a copy "
          "of which says nothing new"}));
  // A throttle of 0 that lifts is a mistake.
  EXPECT_TRUE(Refusal(header + "0,482,5568,16.8,3.4\n" + rows)
                  .starts_with("b.csv:2:1: error: expected a throttle above 0"));
  // Copies are no rows of their own.
  EXPECT_EQ(Refusal(header + "50,482,5568,16.82,3.41\n50,482,5568,16.82,3.41\n"
                             "60,669,6522,16.74,5.47\n80,1055,8345,16.55,11.37\n"),
            "b.csv: error: expected at least 4 rows of a bench table, found 3");
}

TEST(BenchTable, NumbersMayHaveADecimalComma) {
  const auto table = ParseBenchTable(
      "Throttle (%);Thrust (g);RPM;Voltage (V);Current (A)\n50;482;5568;16,82;3,41\n"
      "60;669;6522;16,74;5,47\n80;1055;8345;16,55;11,37\n100;1546;9836;16,26;19,88\n",
      "b.csv");
  ASSERT_EQ(table.rows.size(), 4u);
  EXPECT_EQ(table.rows[0].voltage_V, 16.82);
  EXPECT_EQ(table.rows[3].current_A, 19.88);
}

TEST(BenchTable, ASpeedIsFoundBehindOtherWords) {
  const auto with = [](const std::string& header, const std::string& value) {
    std::string text = "duty,voltage (V),current (A),thrust (N)," + header + "\n";
    for (const char* row : {"0.5,16,4,1,", "0.6,16,5,2,", "0.7,16,6,3,", "0.8,16,7,4,"})
      text += row + value + "\n";
    return ParseBenchTable(text, "b.csv");
  };
  const double rad_per_s = 100.0 * 2.0 * std::numbers::pi;
  for (const auto& [header, value] :
       {std::pair{"Motor Optical Speed (RPM)", "6000"},
        {"Prop RPM", "6000"},
        {"KRPM", "6"},
        {"eRPM,Prop RPM", "1,6000"},
        {"Motor Electrical Speed (RPM),Motor Optical Speed (RPM)", "1,6000"}}) {
    const auto table = with(header, value);
    ASSERT_TRUE(table.has_speed) << header;
    EXPECT_DOUBLE_EQ(table.rows[0].speed_rad_per_s, rad_per_s) << header;
  }
  for (const char* of_air : {"Airspeed", "Wind speed (km/h)", "Air speed (m/s)"})
    EXPECT_FALSE(with(of_air, "3").has_speed) << of_air;
  EXPECT_THROW(with("Motor Electrical Speed (RPM)", "42000"), LoadError);
  try {
    with("eRPM", "42000");
    FAIL();
  } catch (const LoadError& error) {
    EXPECT_EQ(
        std::string(error.what()),
        "b.csv:1:41: error: speed: expected that of the propeller, found 'eRPM', electrical revolutions: "
        "divide them by the pairs of poles of the motor, and call the column rpm");
  }
}

TEST(BenchTable, AColumnIsTheOneThatIsCalledSo) {
  const auto table = ParseBenchTable(
      "Throttle,Thrust efficiency (g/W),Voltage nominal (V),Voltage(V),Current limit (A),Current(A),Thrust(g)\n"
      "50%,7.8,14.8,16.66,40,3.09,401\n60%,6.6,14.8,16.61,40,4.80,529\n80%,5.3,14.8,16.48,40,9.05,787\n"
      "100%,4.4,14.8,16.32,40,14.26,1024\n",
      "b.csv");
  ASSERT_EQ(table.rows.size(), 4u);
  EXPECT_EQ(table.rows[0].throttle, 0.5);  // the cells have the unit
  EXPECT_EQ(table.rows[0].voltage_V, 16.66);
  EXPECT_EQ(table.rows[3].current_A, 14.26);
  EXPECT_DOUBLE_EQ(table.rows[0].thrust_N, 0.401 * 9.80665);
  // Where there is none, one that begins so.
  EXPECT_EQ(ParseBenchTable("throttle (%),Voltage loaded (V),Current mean (A),Thrust static (g)\n"
                            "50,16,3,400\n60,16,4,500\n70,16,5,600\n80,16,6,700\n",
                            "b.csv")
                .rows[1]
                .current_A,
            4.0);
}

// Both were told as a vehicle that wants larger propellers.
TEST(BenchTable, ThrustGrowsWithThePower) {
  const std::string header = "throttle (%),voltage (V),current (A),thrust (g)\n";
  EXPECT_EQ(
      Refusal(header + "50,16,3,460\n60,16,5,690\n70,16,8,860\n80,16,10,1.040\n"),
      "b.csv:5:1: error: expected a thrust that grows with the power, found 0.0102 N at 160 W, and 4.511 N "
      "at 48 W in line 2: is that a dot for thousands (1.040 for 1040)?");
  EXPECT_EQ(
      Refusal(header + "50,16,3,460\n60,16,5,690\n70,16,8,86\n80,16,10,1040\n"),
      "b.csv:4:1: error: expected a thrust that grows with the power, found 0.8434 N at 128 W, and 4.511 N "
      "at 48 W in line 2: one of the two is not what was measured");
}

TEST(BenchTable, EveryMistakeHasItsPlace) {
  const std::string header = "throttle (%),voltage (V),current (A),thrust (g)\n";
  EXPECT_EQ(Refusal("throttle (%),voltage (V),thrust (g)\n"),
            "b.csv:1:1: error: expected a column of the current in A or mA, found the columns "
            "throttle (%),voltage (V),thrust (g)");
  EXPECT_EQ(Refusal("throttle (%),voltage (V),current (A),thrust (oz)\n"),
            "b.csv:1:38: error: thrust: expected the unit g, kg or N, found 'thrust (oz)'");
  EXPECT_EQ(
      Refusal("throttle (%),voltage (V),current (A),thrust (g),speed (turns)\n"),
      "b.csv:1:49: error: speed: expected the unit rpm, krpm, Hz or rad/s, found 'speed (turns)'");
  EXPECT_EQ(Refusal(header + "50,16,3,400\n50,16,three,400\n"),
            "b.csv:3:7: error: current: expected a number, found 'three'");
  EXPECT_EQ(Refusal(header + "50,16,3\n"),
            "b.csv:2:1: error: expected 4 fields as in the header, found 3");
  EXPECT_EQ(Refusal(header + "150,16,3,400\n"),
            "b.csv:2:1: error: expected a throttle above 0 and at most 100 %, as a fraction, found "
            "1.5");
  EXPECT_EQ(Refusal(header + "50,16,-3,400\n"),
            "b.csv:2:1: error: expected a current above 0 A, found -3");
  EXPECT_EQ(Refusal(header + "50,16,3,400\n"),
            "b.csv: error: expected at least 4 rows of a bench table, found 1");
}

// Exchanged, a bench table gave a throttle exponent of 5e-47.
TEST(BenchTable, VoltageAndCurrentAreNotExchanged) {
  const std::string rows =
      "50,16.66,3.09,401\n60,16.61,4.8,529\n70,16.54,6.72,656\n80,16.48,9.05,787\n";
  EXPECT_EQ(
      Refusal("throttle (%),current (A),voltage (V),thrust (g)\n" + rows),
      "b.csv: error: expected a current that grows with the thrust, found 16.66 A at 3.932 N and 16.48 A at "
      "7.718 N while the voltage rises from 3.09 to 9.05 V: voltage and current look exchanged; correct the "
      "header");
  EXPECT_EQ(ParseBenchTable("throttle (%),voltage (V),current (A),thrust (g)\n" + rows, "b.csv")
                .rows.size(),
            4U);
  // Full throttle at rising voltages.
  EXPECT_EQ(ParseBenchTable("throttle (%),voltage (V),current (A),thrust (g)\n"
                            "100,10,5,400\n100,12,7,550\n100,14,9,720\n100,16,11,900\n",
                            "b.csv")
                .rows.size(),
            4U);
}

}  // namespace
}  // namespace lipoid
