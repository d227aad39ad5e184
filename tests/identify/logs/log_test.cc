// Plain CSV in all its spellings, what the options do, and the exact text of every refusal.
#include "identify/logs/log.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>
#include <utility>

#include "identify/logs/formats/header.h"
#include "model/core/errors.h"
#include "tests/support/constants.h"
#include "tests/support/load_error.h"
#include "tests/support/paths.h"
#include "tests/support/text_files.h"

namespace lipoid {
namespace {

using test::kLogHeader;
using test::WriteText;

// Rest, then 2 A: the voltage falls by 0.1 V at the edge and goes on falling.
constexpr const char* kFiveRows = "0,0,4.1\n1,0,4.1\n2,2,4\n3,2,3.99\n4,2,3.97\n";

std::string RefusalOfLog(const std::string& text, const ReadOptions& options = {}) {
  const std::string file = WriteText("log.csv", text);
  std::string message = test::LoadErrorOf([&] { (void)ReadLog(file, options); });
  if (message.starts_with(file)) message = "F" + message.substr(file.size());
  return message;
}

Log ReadOf(const std::string& text, const ReadOptions& options = {}) {
  return ReadLog(WriteText("log.csv", text), options);
}

TEST(PlainCsv, HeaderNamesAreUnderstood) {
  for (const char* header : {"time_s,current_A,voltage_V",
                             "TIME_S,CURRENT_A,VOLTAGE_V",
                             "t/s,I/A,U/V",
                             "t [s],i [a],u [v]",
                             "Time (s),Current (A),Voltage (V)",
                             "Test Time (Sec), Amps, Volts",
                             "elapsed_seconds,current_ampere,voltage_volt",
                             "seconds,amps,volts",
                             "Elapsed Time / s,I_cell / A,Ecell/V",
                             "total_time_s,I_A,V_V",
                             "Time#s,Current#A,Voltage#V",
                             "Zeit [s],Strom [A],Spannung [V]",
                             "Laufzeit/s,Stromst\xC3\xA4rke/A,Klemmenspannung/V",
                             "Temps (s),Courant (A),Tension (V)",
                             "Dur\xC3\xA9"
                             "e (secondes),Intensit\xE9 (A),Tension cellule (V)",
                             "Tiempo (segundos),Corriente (A),Voltaje (V)",
                             "TIEMPO_S,INTENSIDAD_A,TENSI\xC3\x93N_V",
                             "Tempo [s],Corrente [A],Tensione [V]",
                             "测试时间(s),电流(A),电压(V)",
                             "总时间/s,电流/A,电压/V",
                             "时间（s）,电池电流（A）,电池电压（V）",
                             "\"time_s\",\"current_A\",\"voltage_V\""}) {
    SCOPED_TRACE(header);
    const Log log = ReadOf(std::string(header) + "\n" + kFiveRows);
    EXPECT_EQ(log.record.time_s, (std::vector<double>{0, 1, 2, 3, 4}));
    EXPECT_EQ(log.record.current_A, (std::vector<double>{0, 0, 2, 2, 2}));
    EXPECT_EQ(log.record.voltage_V, (std::vector<double>{4.1, 4.1, 4, 3.99, 3.97}));
  }
}

// Freezing and boiling water, and where the two scales meet.
TEST(PlainCsv, FahrenheitIsConvertedWhereTheHeaderSaysIt) {
  for (const char* header : {"Temperature (F)",
                             "Temperature (\u00B0F)",
                             "Temp [\xB0 F]",
                             "Temperature(\u2109)",
                             "temperature_degF",
                             "Temperature/Fahrenheit"}) {
    SCOPED_TRACE(header);
    const Log log = ReadOf(std::string("time_s,current_A,voltage_V,") + header +
                           "\n0,0,4.1,32\n1,0,4.1,212\n2,2,4,-40\n3,2,3.99,77\n4,2,3.97,77\n");
    const std::vector<double> degC{0, 100, -40, 25, 25};
    ASSERT_EQ(log.record.temperature_degC.size(), degC.size());
    for (std::size_t k = 0; k < degC.size(); ++k)
      EXPECT_NEAR(std::as_const(log.record.temperature_degC)[k], degC[k], 100 * test::kEpsilon);
    EXPECT_TRUE(log.report.warnings.empty());
  }
}

TEST(PlainCsv, SaysThatATemperatureIsLeftOut) {
  const auto warnings = [](const std::string& header, const std::string& more) {
    const std::string end = ",77" + more + "\n";
    const Log log = ReadOf("time_s,current_A,voltage_V," + header + "\n0,0,4.1" + end + "1,0,4.1" +
                           end + "2,2,4" + end + "3,2,3.99" + end);
    EXPECT_TRUE(log.record.temperature_degC.empty());
    return log.report.warnings;
  };
  EXPECT_EQ(
      warnings("Temperature (R)", ""),
      (std::vector<std::string>{"temperature left out: the header 'Temperature (R)' states no "
                                "unit of temperature (degC, degF, K)"}));
  EXPECT_EQ(warnings("temp_degC,temperature_degC", ",77"),
            (std::vector<std::string>{"temperature left out: there are more columns beside "
                                      "'temperature_degC'; name one with `columns = "
                                      "{temperature_degC = \"...\"}` (--columns)"}));
  EXPECT_EQ(warnings("T1 [\u00B0C],T_case_degC", ",77"),
            (std::vector<std::string>{
                "temperature left out: no header says which is that of the cell; if it is one of "
                "T1 [\u00B0C], T_case_degC, name it with `columns = {temperature_degC = \"...\"}` "
                "(--columns)"}));
  for (const std::string header : {"T_K", "Kelvin"}) {
    EXPECT_EQ(warnings(header, ""),
              (std::vector<std::string>{
                  "temperature left out: no header says which is that of the cell; if it is "
                  "one of " +
                  header + ", name it with `columns = {temperature_degC = \"...\"}` (--columns)"}));
  }
  EXPECT_TRUE(warnings("Q [C]", "").empty()) << "a charge";
}

TEST(PlainCsv, TheTemperatureOfTheCellIsToldFromThatOfTheChamber) {
  for (const char* header : {"Temperatur Zelle [\u00B0C],Temperatur Kammer [\u00B0C]",
                             "cell temp (degC),chamber temp (degC)",
                             "Cell T [degC],Ambient T [degC]"}) {
    SCOPED_TRACE(header);
    const Log log = ReadOf(std::string("time_s,current_A,voltage_V,") + header +
                           "\n0,0,4.1,31,25\n1,0,4.1,31,25\n2,2,4,31,25\n3,2,3.99,31,25\n");
    ASSERT_EQ(log.record.temperature_degC.size(), 4U);
    EXPECT_EQ(std::as_const(log.record.temperature_degC)[0], 31.0);
    EXPECT_TRUE(log.report.warnings.empty());
  }
}

TEST(PlainCsv, UnitsAreConverted) {
  // Dividing by 1000 and multiplying by 60 or 3600 are exact for these numbers.
  const Log log = ReadOf(
      "time_h,current_mA,voltage_mV,temperature_K\n0,0,4100,300\n0.5,0,4100,300\n1,2000,4000,300\n"
      "1.5,2000,3990,300\n2,2000,3970,300\n");
  EXPECT_EQ(log.record.time_s, (std::vector<double>{0, 1800, 3600, 5400, 7200}));
  EXPECT_EQ(log.record.current_A, (std::vector<double>{0, 0, 2, 2, 2}));
  EXPECT_EQ(log.record.voltage_V, (std::vector<double>{4.1, 4.1, 4, 3.99, 3.97}));
  EXPECT_EQ(log.record.temperature_degC, (std::vector<double>(5, 300 - 273.15)));
  EXPECT_EQ(ReadOf("time_min,current_A,voltage_V\n" + std::string(kFiveRows)).record.time_s.back(),
            240.0);
  EXPECT_EQ(ReadOf("time_ms,current_A,voltage_V\n" + std::string(kFiveRows)).record.time_s.back(),
            0.004);
}

// A micro sign that is left out makes a coin cell one of 100 Ah.
TEST(PlainCsv, AMicroSignIsReadInEverySpelling) {
  const std::string rows =
      "0,0,4100000\n1,0,4100000\n2,2000,4000000\n3,2000,3990000\n4,2000,3970000\n";
  for (const std::string micro : {"u", "\u00B5", "\u03BC", "\xB5"}) {
    SCOPED_TRACE(micro);
    for (const std::string& header :
         {"Time (s),Current (" + micro + "A),Voltage (" + micro + "V)\n",
          "time_s,current_" + micro + "A,voltage_" + micro + "V\n"}) {
      const Log log = ReadOf(header + rows);
      EXPECT_EQ(log.record.current_A, (std::vector<double>{0, 0, 2e-3, 2e-3, 2e-3}));
      EXPECT_EQ(log.record.voltage_V, (std::vector<double>{4.1, 4.1, 4, 3.99, 3.97}));
    }
  }
  // In an encoding of Chinese the byte of that sign begins other words.
  EXPECT_EQ(Narrow("\xB5\xE7\xC1\xF7"), "\xB5\xE7\xC1\xF7");
}

TEST(PlainCsv, UnitsMayStandInALineBelowTheNames) {
  for (const char* header : {"Time,Current,Voltage\ns,mA,mV\n",
                             "Time;Current;Voltage\n[s];[mA];[mV]\n",
                             "Time\tCurrent\tVoltage\tNote\n(s)\t(mA)\t(mV)\t-\n",
                             "\"t\",\"I\",\"U\"\r\n\"sec\",\"mA\",\"mV\"\r\n"}) {
    SCOPED_TRACE(header);
    std::string text = header;
    const bool semicolons = text.find(';') != std::string::npos;
    const bool tabs = text.find('\t') != std::string::npos;
    std::string rows = "0,0,4100\n1,0,4100\n2,2000,4000\n3,2000,3990\n4,2000,3970\n";
    if (tabs) rows = "0,0,4100,\n1,0,4100,\n2,2000,4000,\n3,2000,3990,\n4,2000,3970,\n";
    if (semicolons) std::replace(rows.begin(), rows.end(), ',', ';');
    if (tabs) std::replace(rows.begin(), rows.end(), ',', '\t');
    text += rows;
    const Log log = ReadOf(text);
    EXPECT_EQ(log.record.time_s, (std::vector<double>{0, 1, 2, 3, 4}));
    EXPECT_EQ(log.record.current_A, (std::vector<double>{0, 0, 2, 2, 2}));
    EXPECT_EQ(log.record.voltage_V, (std::vector<double>{4.1, 4.1, 4, 3.99, 3.97}));
  }
  // A line of words among which is no unit is neither such a line nor a row.
  EXPECT_EQ(
      RefusalOfLog("Time,Current,Voltage\none,two,three\n" + std::string(kFiveRows)),
      "F:1:1: error: expected times in column 'Time' as numbers, as durations such as 00:01:02.5 or "
      "as dates such as 2021-03-26 17:01:33, found 'one' in the first row");
  // Units of the user's that contradict the line are refused, as those of a header are.
  EXPECT_EQ(RefusalOfLog("Time,Current,Voltage\ns,mA,mV\n" + std::string(kFiveRows),
                         {.units = {"s", "A", "V"}}),
            "F:1:6: error: expected a column in A as the option units says, found 'Current'");
}

// Neware's software in Chinese: the clock of the step beside that of the test, a state that says the direction.
TEST(PlainCsv, ChineseNamesAreOfTheWholeTest) {
  const Log log = ReadOf(
      "循环号,工步类型,时间,总时间,电流(A),电压(V),温度（℃）,绝对时间\n"
      "1,搁置,0:00:00,0:00:00,0,4.18,25,2023-05-01 10:00:00\n"
      "1,恒流放电,0:00:00,0:00:10,-1,4.08,25.5,2023-05-01 10:00:10\n"
      "1,恒流放电,0:00:10,0:00:20,-1,4.07,26,2023-05-01 10:00:20\n");
  EXPECT_EQ(log.record.time_s, (std::vector<double>{0, 10, 20}));
  EXPECT_EQ(log.record.current_A, (std::vector<double>{0, 1, 1}));
  EXPECT_EQ(log.record.temperature_degC, (std::vector<double>{25, 25.5, 26}));
  // The same names in GBK, as Excel writes them there.
  EXPECT_EQ(
      RefusalOfLog("\xCA\xB1\xBC\xE4(s),\xB5\xE7\xC1\xF7(A),\xB5\xE7\xD1\xB9(V)\n" +
                   std::string(kFiveRows)),
      "F:1:1: error: expected a header that names time, current and voltage, such as "
      "time_s,current_A,voltage_V, found "
      "'\u02b1\\xbc\\xe4(s),\\xb5\\xe7\\xc1\\xf7(A),\\xb5\\xe7\u0479(V)'; the file is not UTF-8: "
      "save it so; `lipoid list formats` shows what is read");
  EXPECT_EQ(
      RefusalOfLog("time_s  current_A  voltage_V\n     0     0.0       4.1\n"),
      "F:1:1: error: expected a header that names time, current and voltage, such as "
      "time_s,current_A,voltage_V, found 'time_s  current_A  voltage_V'; what stands apart by "
      "blanks is one column: put TAB, ; or , between them; `lipoid list formats` shows what is read");
}

TEST(PlainCsv, ACurrentThatTheVoltageDoesNotFollowIsDroppedAndSaid) {
  std::string text = "time_s,current_A,voltage_V\n0,0,4.2\n1,0,4.2\n";
  for (int k = 2; k < 30; ++k)
    text += fmt::format("{},{},{:.3f}\n", k, k == 9 ? 100 : k == 20 ? -20 : 2, 4.1 - 0.002 * k);
  const Log log = ReadOf(text);
  EXPECT_EQ(log.report.rows, 28U);
  EXPECT_EQ(log.report.dropped_spikes, 2U);
  EXPECT_EQ(log.report.warnings,
            (std::vector<std::string>{
                "1 row dropped: a current of 100 A at 9 s, far outside the range of all "
                "other rows, which the voltage does not follow",
                "1 row dropped: a current of -20 A at 20 s, far outside the range of all "
                "other rows, which the voltage does not follow"}));
}

TEST(PlainCsv, ARowThatCannotBeIsDroppedAndSaid) {
  const Log log = ReadOf(
      "time_s,current_A,voltage_V\n0,0,4.1\n1,0,4.1\n2,2,4\n3,2,10\n4,2,3.98\n5,2,3.97\n6,2,3.96\n");
  EXPECT_EQ(log.record.time_s, (std::vector<double>{0, 1, 2, 4, 5, 6}));
  EXPECT_EQ(log.record.voltage_V, (std::vector<double>{4.1, 4.1, 4, 3.98, 3.97, 3.96}));
  EXPECT_EQ(log.report.rows, 6U);
  EXPECT_EQ(log.report.dropped_spikes, 1U);
  EXPECT_EQ(log.report.dropped_rows(), 1U);
  EXPECT_EQ(log.report.warnings,
            (std::vector<std::string>{"1 row dropped: a voltage of 10 V at 3 s, far outside the "
                                      "range of all other rows"}));
}

TEST(PlainCsv, AShortHoleInTheTemperatureIsBridged) {
  const auto read = [](int step_s, std::vector<std::string> degC) {
    std::string text = "time_s,current_A,voltage_V,temperature_degC\n";
    for (std::size_t k = 0; k < 12; ++k) {
      text += fmt::format("{},{},{},{}\n",
                          static_cast<int>(k) * step_s,
                          k == 0 ? 0 : 2,
                          4.1 - 0.01 * static_cast<double>(k),
                          degC[k]);
    }
    return ReadOf(text);
  };
  const auto warned = [](const Log& log, const std::string& words) {
    return std::any_of(log.report.warnings.begin(), log.report.warnings.end(), [&](const auto& w) {
      return w.find(words) != std::string::npos;
    });
  };
  // Three rows of ten minutes, and one at each end.
  const Log few = read(600, {"", "20", "20", "21", "", "", "", "23", "23", "23", "23", ""});
  EXPECT_EQ(few.record.temperature_degC,
            (std::vector<double>{20, 20, 20, 21, 21.5, 22, 22.5, 23, 23, 23, 23, 23}));
  EXPECT_TRUE(warned(few, "5 rows without a temperature, which is taken from a straight line"));
  // More rows of a second each, as a slow thermometer has.
  const Log slow = read(1, {"20", "", "", "", "", "25", "", "", "", "", "30", ""});
  EXPECT_EQ(slow.record.temperature_degC,
            (std::vector<double>{20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 30}));
  // Too much is missing.
  const Log hole = read(600, {"20", "20", "", "", "", "", "23", "23", "23", "23", "23", "23"});
  EXPECT_TRUE(hole.record.temperature_degC.empty());
  EXPECT_TRUE(warned(hole, "temperature left out, for some rows hold no number"));
  // Readings that failed are holes, too; where they go on the sensor is off.
  const Log failed =
      read(1, {"20", "20", "85", "20", "20", "20", "0", "0", "20", "20", "20", "20"});
  EXPECT_EQ(failed.record.temperature_degC, std::vector<double>(12, 20.0));
  EXPECT_TRUE(warned(failed, "3 rows of temperatures that no cell has, the first 85 degC at 2 s"));
  const Log off = read(1, {"20", "20", "20", "20", "20", "20", "0", "0", "0", "0", "0", "0"});
  EXPECT_TRUE(off.record.temperature_degC.empty());
  EXPECT_TRUE(warned(off, "temperature left out: it jumps from 20 to 0 degC at 6 s"));
}

TEST(PlainCsv, StepsAndCyclesAreReportedWhereAskedFor) {
  const std::string text =
      "time_s,current_A,voltage_V,step,cycle\n0,0,4.1,1,1\n1,0,4.1,1,1\n2,2,4,2,1\n3,2,3.99,2,1\n"
      "4,2,3.97,2,2\n";
  EXPECT_TRUE(ReadOf(text).report.labels.empty());
  const auto labels = ReadOf(text, {.labels = true}).report.labels;
  ASSERT_EQ(labels.size(), 3U);
  EXPECT_EQ(labels[1].row, 2U);
  EXPECT_EQ(labels[1].step, 2.0);
  EXPECT_EQ(labels[2].row, 4U);
  EXPECT_EQ(labels[2].cycle, 2.0);
  EXPECT_TRUE(ReadOf("time_s,current_A,voltage_V\n" + std::string(kFiveRows), {.labels = true})
                  .report.labels.empty());
}

TEST(PlainCsv, NegativeDischargeIsTurnedRound) {
  const Log log =
      ReadOf("time_s,current_A,voltage_V\n0,0,4.1\n1,0,4.1\n2,-2,4\n3,-2,3.99\n4,-2,3.97\n");
  EXPECT_EQ(log.record.current_A, (std::vector<double>{0, 0, 2, 2, 2}));
  EXPECT_FALSE(std::signbit(log.record.current_A[0]));
  EXPECT_EQ(log.report.current_sign, "discharge-negative");
}

TEST(PlainCsv, WhatIsSkippedIsCounted) {
  const Log log = ReadOf(
      "\xEF\xBB\xBF# lab 3\ntime_s,current_A,voltage_V,\n0,0,4.1,\n1,0,4.1,\n1,0,4.2,\n\n2,2,4,\n# "
      "pause\n"
      "3,2,3.99,\n4,2,3.97,\n5,2");
  EXPECT_EQ(log.record.time_s, (std::vector<double>{0, 1, 2, 3, 4}));
  EXPECT_EQ(log.record.voltage_V[1], 4.1) << "of repeated time stamps the first is kept";
  EXPECT_EQ(log.report.dropped_repeated_times, 1U);
  EXPECT_EQ(log.report.dropped_cut_last_line, 1U);
  EXPECT_EQ(log.report.dropped_rows(), 2U);
  EXPECT_EQ(log.report.notes,
            (std::vector<std::string>{"byte order mark skipped",
                                      "a delimiter at the end of lines skipped",
                                      "1 blank line skipped",
                                      "1 comment line skipped",
                                      "1 line before the header skipped"}));
}

// Ten rows for each second of a clock in whole seconds.
TEST(PlainCsv, AClockThatIsCoarserThanItsRowsIsSaid) {
  std::string text = "time_s,current_A,voltage_V\n";
  for (int k = 0; k < 100; ++k) text += fmt::format("{},{},{}\n", k / 10, k < 30 ? 0 : 2, 4.1);
  const Log log = ReadOf(text, {.current_sign = "discharge-positive"});
  EXPECT_EQ(log.report.rows, 10U);
  EXPECT_EQ(log.report.warnings,
            (std::vector<std::string>{
                "90 of 100 rows have the time of the row before and were left out: the clock is "
                "coarser than the rows; export the times with more digits"}));
}

TEST(TakeLog, MissingTemperaturesAreThoseOfAFile) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const auto take = [](std::vector<double> temperature_degC) {
    Record record;
    record.time_s = std::vector<double>{0, 1, 2, 3, 4};
    record.current_A = std::vector<double>{0, 0, 2, 2, 2};
    record.voltage_V = std::vector<double>{4.1, 4.1, 4.0, 3.99, 3.97};
    record.temperature_degC = std::move(temperature_degC);
    return TakeLog(std::move(record), {.current_sign = "discharge-positive"});
  };
  const Log bridged = take({20, kNone, 22, 22, 22});
  EXPECT_EQ(bridged.record.temperature_degC, (std::vector<double>{20, 21, 22, 22, 22}));
  EXPECT_EQ(bridged.report.warnings,
            (std::vector<std::string>{"1 row without a temperature, which is taken from a straight "
                                      "line between the rows around"}));
  const Log left_out = take({kNone, kNone, kNone, kNone, kNone});
  EXPECT_TRUE(left_out.record.temperature_degC.empty());
  EXPECT_EQ(left_out.report.warnings,
            (std::vector<std::string>{"temperature left out, for some rows hold no number: what "
                                      "needs it goes on without"}));
}

// Also of a log whose voltages get the drop of the leads added, which moves with the current.
TEST(Log, AVoltageThatWasNotMeasuredIsSaid) {
  std::string text = kLogHeader;
  for (int k = 0; k < 400; ++k) {
    const double current_A = k < 50 ? 0.0 : 2.0;
    text += fmt::format("{},{},{:.4f}\n",
                        k,
                        current_A,
                        std::min(4.05, 4.2 - 0.03 * current_A - 0.001 * std::max(0, k - 50)));
  }
  text += "400,0,3.9\n401,0,3.9\n";
  for (const double lead_resistance_Ohm : {0.0, 0.01}) {
    const Log log = ReadOf(text, {.lead_resistance_Ohm = lead_resistance_Ohm});
    EXPECT_TRUE(log.report.stuck_voltage.starts_with(
        "the voltage shows 4.05 V from 0 to 140 s, while the current"))
        << log.report.stuck_voltage;
    EXPECT_EQ(log.report.warnings, std::vector<std::string>{log.report.stuck_voltage});
  }
}

TEST(PlainCsv, ALastNumberThatLacksDigitsOfAFixedFormatIsCut) {
  const std::string text =
      "time_s,current_A,voltage_V\n0,0,4.100\n1,0,4.100\n2,2,4.000\n3,2,3.990\n4,2,3.970";
  EXPECT_EQ(ReadOf(text).record.size(), 5U);
  for (const std::size_t missing : {1U, 2U, 3U, 4U}) {
    const Log log = ReadOf(text.substr(0, text.size() - missing));
    EXPECT_EQ(log.record.size(), 4U);
    EXPECT_EQ(log.report.dropped_cut_last_line, 1U);
  }
  // So it is in quotes, as far as they are closed.
  const std::string quoted =
      "\"time_s\",\"current_A\",\"voltage_V\"\n\"0\",\"0\",\"4.10\"\n\"1\",\"0\",\"4.10\"\n"
      "\"2\",\"2\",\"4.00\"\n\"3\",\"2\",\"3.99\"\n\"4\",\"2\",\"3.97\"";
  EXPECT_EQ(ReadOf(quoted).record.size(), 5U);
  EXPECT_EQ(ReadOf(quoted.substr(0, quoted.size() - 1)).record.size(), 4U);
  // With a line end it is what the logger wrote.
  EXPECT_EQ(ReadOf(text.substr(0, text.size() - 1) + "\n").record.size(), 5U);
}

TEST(PlainCsv, ALeadResistanceRaisesTheVoltageUnderDischarge) {
  const Log log = ReadOf("time_s,current_A,voltage_V\n" + std::string(kFiveRows),
                         {.lead_resistance_Ohm = 0.25});
  EXPECT_EQ(log.record.voltage_V, (std::vector<double>{4.1, 4.1, 4.5, 4.49, 4.470000000000001}));
}

TEST(PlainCsv, OnlyATimeSpanIsReadAndTimeRestarts) {
  const Log log =
      ReadOf("time_s,current_A,voltage_V\n" + std::string(kFiveRows), {.start_s = 1, .end_s = 3});
  EXPECT_EQ(log.record.time_s, (std::vector<double>{0, 1, 2}));
  EXPECT_EQ(log.record.voltage_V, (std::vector<double>{4.1, 4, 3.99}));
  EXPECT_EQ(log.report.dropped_unselected, 2U);
}

// The rows at rest tell nothing of the sign; with the edge that the part leaves out they do.
TEST(PlainCsv, APartThatDoesNotSettleItsSignHasThatOfTheWholeLog) {
  const std::string header = "time_s,current_A,voltage_V\n";
  for (const char* rows : {kFiveRows, "0,0,4.1\n1,0,4.1\n2,-2,4\n3,-2,3.99\n4,-2,3.97\n"}) {
    const ReadOptions rest{.end_s = 1};
    const Log log = ReadOf(header + rows, rest);
    const Log whole = ReadOf(header + rows);
    EXPECT_EQ(log.record.size(), 2U);
    EXPECT_EQ(log.report.current_sign, whole.report.current_sign);
    EXPECT_EQ(
        log.report.current_sign_reason,
        fmt::format("discharge is {} as in the whole log; by itself this part does not settle "
                    "it: no current flows",
                    rows == kFiveRows ? "positive" : "negative"));
    EXPECT_FALSE(log.report.current_sign_is_of_others);
    EXPECT_EQ(ReadLogText(header + rows, "F", rest).report.current_sign, log.report.current_sign);
    EXPECT_EQ(
        RefusalOfLog(header + "0,0,4.1\n1,0,4.1\n2,0,4.1\n", rest),
        "F:1:8: error: expected a current whose sign the data settle, found that no current "
        "flows; say `current_sign` (--current-sign discharge-positive or discharge-negative), "
        "or read another part of the log");
  }
  Record columns;
  columns.time_s = {0, 1, 2, 3, 4};
  columns.current_A = {-1, -1, -3, -3, -3};
  columns.voltage_V = {4.1, 4.1, 4, 3.99, 3.97};
  const Log log = TakeLog(std::move(columns), {.end_s = 1});
  EXPECT_EQ(log.record.current_A, (std::vector<double>{1, 1}));
  EXPECT_EQ(log.report.current_sign, "discharge-negative");
}

TEST(PlainCsv, HoldIsPassedOn) {
  EXPECT_EQ(
      ReadOf("time_s,current_A,voltage_V\n" + std::string(kFiveRows), {.hold = Hold::kForward})
          .record.hold,
      Hold::kForward);
}

TEST(PlainCsv, ColumnsCanBeNamed) {
  const std::string text =
      "Zeit [s],I1 [A],I2 [A],Spannung [mV]\n0,0,9,4100\n1,0,9,4100\n2,2,9,4000\n3,2,9,3990\n";
  const Log log = ReadOf(
      text,
      {.columns = {
           {"time_s", "zeit [s]"}, {"current_A", "I1 [A]"}, {"voltage_V", "Spannung [mV]"}}});
  EXPECT_EQ(log.record.current_A, (std::vector<double>{0, 0, 2, 2}));
  EXPECT_EQ(log.record.voltage_V, (std::vector<double>{4.1, 4.1, 4, 3.99}));
}

// Numbers say the same as names where rows of numbers follow the header; its units count.
TEST(PlainCsv, ColumnsOfAHeaderCanBeNumbered) {
  const ReadOptions numbers{.columns = {{"time_s", "1"}, {"current_A", "2"}, {"voltage_V", "4"}}};
  const std::string rows = "0,0,9,4100\n1,0,9,4100\n2,2,9,4000\n3,2,9,3990\n";
  for (const std::string header : {"Zeit [s],I1 [A],I2 [A],Spannung [mV]\n",
                                   "Prüfer,Maier\n\nZeit,I1,I2,Spannung\ns,A,A,mV\n"}) {
    SCOPED_TRACE(header);
    const Log log = ReadOf(header + rows, numbers);
    EXPECT_EQ(log.record.current_A, (std::vector<double>{0, 0, 2, 2}));
    EXPECT_EQ(log.record.voltage_V, (std::vector<double>{4.1, 4.1, 4, 3.99}));
  }
}

TEST(PlainCsv, TheSignCanBeGiven) {
  const std::string text = "time_s,current_A,voltage_V\n0,0,4.1\n1,0,4.1\n2,0,4.1\n";
  EXPECT_EQ(ReadOf(text, {.current_sign = "discharge-negative"}).report.current_sign,
            "discharge-negative");
  EXPECT_EQ(ReadOf(text, {.current_sign = "discharge-positive"}).report.current_sign_reason,
            "given by the option current_sign");
}

struct Wrong {
  const char* what;
  std::string text;
  std::string message;
  ReadOptions options = {};
};

void PrintTo(const Wrong& wrong, std::ostream* os) { *os << wrong.what; }

const std::string kStartsAnew =
    "if the clock starts anew with each step or cycle, pick some with `steps` or `cycles`, or name a "
    "column that runs on with `columns = {time_s = \"...\"}`; logs that were joined are read one by one";

const std::string kExportSo =
    "; numbers of this file are read with a decimal point and without marks for thousands: export "
    "them so";

const Wrong kWrong[] = {
    {"empty", "", "F:1:1: error: expected a log, found an empty file"},
    {"blank", "\n\n", "F:1:1: error: expected a log, found only blank lines and comments"},
    {"header only", kLogHeader, "F:1:1: error: expected rows below the header, found none"},
    {"cut row only",
     kLogHeader + "1,2",
     "F:1:1: error: expected rows below the header, found only one that is cut off"},
    {"unknown header",
     "foo,bar,baz\n1,2,3\n",
     "F:1:1: error: expected a header that names time, current and voltage, such as "
     "time_s,current_A,voltage_V, found "
     "'foo,bar,baz'; `lipoid list formats` shows what is read"},
    {"no current",
     "time_s,voltage_V,foo\n1,2,3\n",
     "F:1:1: error: expected columns for time, current and voltage, found none for current among "
     "time_s, voltage_V, "
     "foo; name them as the header does (--columns current_A=\"...\", or `columns` in a campaign)"},
    {"names of another program, those in amperes and volts first",
     "time_s,n1,n2,n3,n4,n5,n6,n7,n8,n9,n10,n11,n12,pack_A,pack_V\n1,2,3,4,5,6,7,8,9,10,11,12,13,14,15\n",
     "F:1:1: error: expected columns for time, current and voltage, found none for current and voltage "
     "among pack_V, pack_A, time_s, n1, n2, n3, n4, n5, n6, n7, n8, n9, ...; name them as the header does "
     "(--columns current_A=\"...\" voltage_V=\"...\", or `columns` in a campaign)"},
    {"no current where the voltage is not needed",
     "time_s,foo\n1,2\n",
     "F:1:1: error: expected columns for time and current, found none for current among time_s, foo; "
     "name them as the header does (--columns current_A=\"...\", or `columns` in a campaign)",
     {.voltage_optional = true}},
    {"no header",
     kFiveRows,
     "F:1:1: error: expected a header that names the columns, found numbers; add one line on top, "
     "such as "
     "time_s,current_A,voltage_V, or number the columns from 1 (--columns time_s=1 current_A=2 "
     "voltage_V=3 --units s,A,V)"},
    {"no header, overflow",
     "\xEF\xBB\xBF"
     "0,3.40E+38,4.1506,0.25433\n1.001332,-2.9975,4.043,-12.118\n",
     "F:1:1: error: expected a header that names the columns, found numbers; add one line on top, "
     "such as "
     "time_s,current_A,voltage_V, or number the columns from 1 (--columns time_s=1 current_A=2 "
     "voltage_V=3 --units s,A,V)"},
    {"no units",
     "Time,Current,Voltage\n1,2,3\n",
     "F:1:1: error: expected a header that states the unit of the time (s, ms, min, h), found "
     "'Time'; add it there or "
     "say `units` (--units s,A,V)"},
    {"no unit of the current",
     "time_s,Current,voltage_V\n1,2,3\n",
     "F:1:8: error: expected a header that states the unit of the current (A, mA), found "
     "'Current'; add it there or say "
     "`units` (--units s,A,V)"},
    {"a unit that cannot be",
     "time_kg,current_A,voltage_V\n1,2,3\n",
     "F:1:1: error: expected a unit of time (s, ms, min, h) in 'time_kg', found 'kg'"},
    {"another quantity's unit",
     "time_s,current_V,voltage_V\n1,2,3\n",
     "F:1:8: error: expected a unit of current (A, mA) in 'current_V', found 'v'"},
    {"a column of another quantity, whatever the option units says",
     kLogHeader + kFiveRows,
     "F:1:18: error: expected a unit of current (A, mA) in 'voltage_V', found 'v'",
     {.columns = {{"current_A", "voltage_V"}}, .units = {"s", "A", "V"}}},
    {"units contradict",
     kLogHeader + kFiveRows,
     "F:1:8: error: expected a column in mA as the option units says, found 'current_A'",
     {.units = {"s", "mA", "V"}}},
    {"one column for two quantities",
     "time_s,pack\n0,4.1\n1,4\n",
     "F:1:8: error: expected a column of its own for each quantity, found 'pack' for both the current "
     "and the voltage; name another with `columns = {current_A = \"...\"}` (--columns)",
     {.columns = {{"current_A", "pack"}, {"voltage_V", "pack"}}, .units = {"s", "A", "V"}}},
    {"one number for two quantities",
     "0,4.1,5\n1,4,5\n",
     "F:1:3: error: expected a column of its own for each quantity, found '2' for both the current "
     "and the voltage; name another with `columns = {current_A = \"...\"}` (--columns)",
     {.columns = {{"time_s", "1"}, {"current_A", "2"}, {"voltage_V", "2"}},
      .units = {"s", "A", "V"}}},
    {"two currents",
     "time_s,current_A,I (mA),voltage_V\n1,2,3,4\n",
     "F:1:18: error: expected one column for the current, found 'current_A' and 'I (mA)'; say "
     "which with `columns = "
     "{current_A = \"current_A\"}`"},
    {"a name twice",
     "time_s,current_A,voltage_V,time_s\n1,2,3,4\n",
     "F:1:28: error: expected one column for the time, found 'time_s' and 'time_s'; say which with `columns = "
     "{time_s = \"1\"}`, its place in the row"},
    {"named column missing",
     kLogHeader + kFiveRows,
     "F:1:1: error: expected columns for time, current and voltage, found none for 'Zeit' among "
     "time_s, current_A, "
     "voltage_V; name them as the header does (--columns time_s=\"...\", or `columns` in a campaign)",
     {.columns = {{"time_s", "Zeit"}}}},
    {"more columns numbered than there are",
     kLogHeader + kFiveRows,
     "F:1:1: error: expected rows with the columns that --columns numbers, below at most a line of "
     "names and one of units, found 'time_s,current_A,voltage_V'; this file has a header: name the "
     "columns as it does (--columns time_s=\"...\")",
     {.columns = {{"time_s", "1"}, {"current_A", "2"}, {"voltage_V", "7"}}}},
    {"numbers among names that are numbers",
     "zeit,2,3\n0,1,4\n",
     "F:1:1: error: expected rows with the columns that --columns numbers, below at most a line of "
     "names and one of units, found 'zeit,2,3'; this file has a header: name the columns as it "
     "does (--columns time_s=\"...\")",
     {.columns = {{"time_s", "1"}, {"current_A", "2"}, {"voltage_V", "3"}}}},
    {"text",
     kLogHeader + "0,0,4.1\n1,abc,4\n",
     "F:3:3: error: expected a number in column 'current_A', found 'abc'"},
    {"an empty cell",
     kLogHeader + "0,0,4.1\n1,,4\n",
     "F:3:3: error: expected a number in column 'current_A', found an empty cell"},
    {"nan",
     kLogHeader + "0,0,4.1\n1, nan,4\n",
     "F:3:4: error: expected a finite number in column 'current_A', found 'nan'"},
    {"inf",
     kLogHeader + "0,0,4.1\n1,2,-inf\n",
     "F:3:5: error: expected a finite number in column 'voltage_V', found '-inf'"},
    {"overflow",
     kLogHeader + "0,3.40E+38,4.1\n1,2,3\n",
     "F:2:3: error: expected a finite number in column 'current_A', found '3.40E+38', which "
     "loggers write for an "
     "overflow"},
    {"beyond doubles",
     kLogHeader + "0,1e999,4.1\n1,2,3\n",
     "F:2:3: error: expected a finite number in column 'current_A', found '1e999'"},
    {"too few fields",
     kLogHeader + "0,0,4.1\n1,2\n2,2,4\n",
     "F:3:1: error: expected 3 fields as in the header, found 2"},
    {"decimal comma in a comma file",
     kLogHeader + "0,0,0,0,4,1\n",
     "F:2:1: error: expected 3 fields as in the header, found 6"},
    {"two decimal marks",
     "time_s;current_A;voltage_V\n0;0,5;4.1\n",
     "F:2:3: error: expected a number in column 'current_A', found '0,5'" + kExportSo},
    {"a thousands mark",
     "time_s;current_A;voltage_V\n0;1.000,5;4,1\n",
     "F:2:3: error: expected a number in column 'current_A', found '1.000,5'" + kExportSo},
    {"an apostrophe for thousands",
     "time_s;current_mA;voltage_mV\n0;0;4'180\n",
     "F:2:5: error: expected a number in column 'voltage_mV', found '4'180'" + kExportSo},
    {"volts under a header that says mV",
     "time_s;current_mA;voltage_mV\n0;0;4.18\n1;-4997;4.026\n",
     "F:1:19: error: expected a voltage of at least 0.02 V, found 0.00418 V at most; are these V "
     "under a header that says mV? Say so in the header or with `units`"},
    {"points for thousands throughout",
     "time_s;current_mA;voltage_mV\n0;0;4.180\n1;-4.997;4.026\n",
     "F:1:19: error: expected a voltage of at least 0.02 V, found 0.00418 V at most; if the mark "
     "before the last three digits is one for thousands, export all numbers without such marks; or "
     "are these V under a header that says mV? Say so in the header or with `units`"},
    {"a point for thousands beside a decimal comma",
     "time_s;current_mA;voltage_V\n0;0;4,180\n1;-4.997;4,026\n",
     "F:3:3: error: expected a number in column 'current_mA', found '-4.997'; numbers of this file "
     "are read with a decimal comma and without marks for thousands: export them so"},
    {"marks for thousands within quotes",
     "time_s,current_mA,voltage_mV\n\"999\",\"1,300\",\"4,134\"\n\"1,000\",\"1,300\",\"4,130\"\n",
     "F:3:1: error: expected time to increase, found '1,000' after 999 s; if the mark in it is one for thousands, "
     "export numbers without; " +
         kStartsAnew},
    {"joined with its header",
     kLogHeader + "0,0,4.1\n1,2,4\n" + kLogHeader + "0,0,4.1\n",
     "F:4:1: error: expected a number in column 'time_s', found 'time_s'; the header is repeated here: logs that were "
     "joined are read one by one, each from a file of its own"},
    {"backwards",
     kLogHeader + "0,0,4.1\n2,0,4.1\n1,2,4\n",
     "F:4:1: error: expected time to increase, found '1' after 2 s; " + kStartsAnew},
    {"over midnight",
     "time,current_A,voltage_V\n23:59:58,0,4.1\n23:59:59,0,4.1\n0:00:00,2,4\n",
     "F:4:1: error: expected time to increase, found '0:00:00' after 86399 s; if a clock without a "
     "date passed midnight, export the date with the time; " +
         kStartsAnew},
    {"of twelve hours",
     "time,current_A,voltage_V\n12:59:00,0,4.1\n12:59:30,0,4.1\n1:00:00,2,4\n",
     "F:4:1: error: expected time to increase, found '1:00:00' after 46770 s; if a clock of twelve "
     "hours began anew, export times of 24 hours; " +
         kStartsAnew},
    {"at the end of summer time",
     "time,current_A,voltage_V\n2024-10-27 02:59:58,0,4.1\n2024-10-27 02:59:59,0,4.1\n"
     "2024-10-27 02:00:00,2,4\n",
     "F:4:1: error: expected time to increase, found '2024-10-27 02:00:00' after 1 s; if the clock "
     "was put back at the end of summer time, export the time since the start; " +
         kStartsAnew},
    {"mV labelled as V",
     kLogHeader + "0,0,4100\n1,0,4100\n2,2,4000\n",
     "F:1:18: error: expected a voltage in V, found 4100 V; are these mV? Say so in the header or "
     "with `units`"},
    {"absurd currents",
     kLogHeader + "0,0,4.1\n1,1000000,4\n2,1000000,3.9\n",
     "F:1:8: error: expected a current in A, found 1e+06 A; are these mA? Say so in the header or "
     "with `units`"},
    {"absurd times",
     kLogHeader + "0,0,4.1\n1e12,2,4\n2e12,2,3.9\n",
     "F:1:1: error: expected times in s, found a log of 6.34e+04 years; are these ms? Say so in "
     "the header or with "
     "`units`"},
    {"all rest",
     kLogHeader + "0,0,4.1\n1,0,4.1\n2,0,4.1\n",
     "F:1:8: error: expected a current whose sign the data settle, found that no current flows; "
     "say `current_sign` "
     "(--current-sign discharge-positive or discharge-negative), or read a part of the log"},
    {"no such step",
     "time_s,step,current_A,voltage_V\n0,1,0,4.1\n1,2,2,4\n",
     "F:1:1: error: expected rows within steps, cycles, start_s and end_s as given, found none "
     "(steps of the file: 1, 2)",
     {.steps = {3}}},
    {"no such time",
     kLogHeader + kFiveRows,
     "F:1:1: error: expected rows within steps, cycles, start_s and end_s as given, found none "
     "(times of the log: 0 to 4 s)",
     {.start_s = 5.0}},
    {"steps without a step column",
     kLogHeader + kFiveRows,
     "F:1:1: error: expected a column for the step because of the option steps, found none among "
     "time_s, current_A, "
     "voltage_V",
     {.steps = {3}}},
    {"LabVIEW",
     "LabVIEW Measurement\nWriter_Version\t2\n***End_of_Header***\nDescription\tColumns are time, "
     "Current\n",
     "F:1:1: error: expected a header that names time, current and voltage, found a LabVIEW text "
     "(.lvm), which describes "
     "its columns in prose; save the rows under a header such as time_s,current_A,voltage_V"},
    {"gzip",
     "\x1f\x8b\x08",
     "F:1:1: error: expected gzip to its end, found the end of the file before that (3 bytes into "
     "the file); what comes before stands for 0 bytes: unpack what can be unpacked, and read that"},
    {"Excel",
     "PK\x03\x04 [Content_Types].xml",
     "F:1:1: error: expected a log as text, found an Excel workbook (.xlsx); save the sheet as "
     "CSV"},
    {"Neware packed",
     "PK\x03\x04 data.ndc",
     "F:1:1: error: expected a log as text, found a Neware packed file (.ndax); export it as CSV "
     "in BTSDA"},
    {"BioLogic",
     "BIO-LOGIC MODULAR FILE\x1a",
     "F:1:1: error: expected a log as text, found a BioLogic binary file (.mpr); export it as text "
     "(.mpt) in EC-Lab or "
     "BT-Lab"},
    {"Access",
     std::string("\0\1\0\0Standard Jet DB\0", 20),
     "F:1:1: error: expected a log as text, found an Access database (Arbin .res or .mdb); export "
     "the channel as CSV in "
     "Arbin MITS Pro"},
    {"UTF-16",
     "\xFF\xFEt",
     "F:1:1: error: expected a log as text, found UTF-16 text; save it as UTF-8"},
    {"bytes",
     std::string("\1\2\3\4\5abc"),
     "F:1:1: error: expected a log as text, found binary data; export it as text (CSV) from the "
     "program that wrote it"},
    {"EndOfDataFlash",
     std::string("\1\2\xA3\x95\5\1\xA3\x95\5\2\xA3\x95\5\3\xA3\x95\5\4\xA3\x95\5"),
     "F:1:1: error: expected a log as text, found an ArduPilot DataFlash log without its beginning, "
     "which says what its messages hold; copy the whole log from the autopilot"},
};

class RefusedLog : public testing::TestWithParam<Wrong> {};
TEST_P(RefusedLog, SaysWhatIsWrong) {
  EXPECT_EQ(RefusalOfLog(GetParam().text, GetParam().options), GetParam().message);
}
INSTANTIATE_TEST_SUITE_P(All, RefusedLog, testing::ValuesIn(kWrong));

TEST(RefusedLog, MissingFilesAndFolders) {
  const std::string folder = test::FreshFolder("log_test_folder");
  EXPECT_EQ(
      test::LoadErrorOf([&] { (void)ReadLog(folder + "/none.csv"); }),
      folder + "/none.csv: error: expected a log file, found no file of this name; check the path");
  EXPECT_EQ(test::LoadErrorOf([&] { (void)ReadLog(folder); }),
            folder + ":1:1: error: expected a log file, found a folder; name the files in it");
}

TEST(RefusedLog, AVeryLongLine) {
  const std::string message = RefusalOfLog(kLogHeader + kFiveRows + std::string(3000000, '7'));
  EXPECT_EQ(message,
            "F:7:1: error: expected a row of a log, found a line of more than 131072 bytes");
}

TEST(RefusedLog, AMillionColumns) {
  std::string text = "a";
  for (int k = 0; k < 1000000; ++k) text += ",";
  EXPECT_NE(RefusalOfLog(text + "\n1\n").find(": error: expected "), std::string::npos);
}

TEST(ReadOptions, AreChecked) {
  const std::string file = WriteText("log.csv", kLogHeader + kFiveRows);
  const auto complaint = [&](const ReadOptions& options) {
    try {
      (void)ReadLog(file, options);
    } catch (const OptionError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  EXPECT_EQ(complaint({.columns = {{"time", "t"}}}),
            "columns: expected time_s, current_A, voltage_V or temperature_degC, found 'time'");
  EXPECT_EQ(complaint({.units = {"s", "A"}}),
            "units: expected three, of time, current and voltage (s,A,V), found 2");
  EXPECT_EQ(complaint({.units = {"s", "A", "kg"}}),
            "units: expected a unit of voltage (V, mV), found 'kg'; the order is time, current, "
            "voltage, as in s,A,V");
  EXPECT_EQ(complaint({.current_sign = "+"}),
            "current_sign: expected auto, discharge-positive or discharge-negative, found '+'");
  EXPECT_EQ(complaint({.start_s = 2, .end_s = 1}),
            "start_s: expected no later than end_s, found 2 and 1");
  EXPECT_EQ(complaint({.lead_resistance_Ohm = std::nan("")}),
            "lead_resistance_Ohm: expected a finite number, found nan");
}

}  // namespace
}  // namespace lipoid
