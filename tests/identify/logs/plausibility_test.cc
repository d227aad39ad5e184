#include "identify/logs/plausibility.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "tests/support/load_error.h"
#include "tests/support/synthetic_record.h"

namespace lipoid {
namespace {

// One hour at 2 A and 3.7 V.
Record OneHour(double scale_time, double scale_current, double scale_voltage) {
  Record record;
  record.file = "F";
  for (int k = 0; k <= 60; ++k) {
    record.time_s.push_back(60.0 * k * scale_time);
    record.current_A.push_back(2.0 * scale_current);
    record.voltage_V.push_back(3.7 * scale_voltage);
  }
  return record;
}

std::string Complaint(const Record& record, double capacity_Ah) {
  return test::LoadErrorOf([&] { CheckPlausible(record, capacity_Ah); });
}

TEST(Plausibility, OfACellThatIsFine) {
  EXPECT_EQ(Complaint(OneHour(1, 1, 1), 2.0), "no error");
  EXPECT_EQ(Complaint(OneHour(1, 1, 1), 0.0), "no error");
}

TEST(Plausibility, MislabelledUnitsAndPacksAreNamed) {
  EXPECT_EQ(Complaint(OneHour(1, 1, 1000), 2.0),
            "F:1:1: error: expected the voltage of one cell, found 3700 V on average; are these "
            "mV, or is it a pack (say "
            "`series`)?");
  EXPECT_EQ(Complaint(OneHour(1, 1, 0.001), 2.0),
            "F:1:1: error: expected the voltage of one cell, found 0.0037 V at most; are these V "
            "under a header that says "
            "mV, or is `series` too large?");
  EXPECT_EQ(Complaint(OneHour(1, 1000, 1), 2.0),
            "F:1:1: error: expected the current of one cell of 2 Ah, found 2000 A; are these mA, "
            "is it a pack (say "
            "`parallel`), or is the capacity wrong?");
  EXPECT_EQ(Complaint(OneHour(60, 1, 1), 2.0),
            "F:1:1: error: expected charges of one cell of 2 Ah, found 120 Ah going one way; are "
            "the units of time and "
            "current right, is it a pack (say `parallel`), or has the current no sign?");
}

// What was said is not asked for again.
TEST(Plausibility, APackThatIsSaidToBeSmallerThanItIs) {
  const auto complaint = [](const Record& record) {
    return test::LoadErrorOf([&] { CheckPlausible(record, 2.0, 2, 3); });
  };
  EXPECT_EQ(
      complaint(OneHour(1, 1, 3)),
      "F:1:1: error: expected the voltage of one cell, found 11.1 V on average; are these mV, or "
      "is `series` more than 2?");
  EXPECT_EQ(
      complaint(OneHour(1, 1000, 1)),
      "F:1:1: error: expected the current of one cell of 2 Ah, found 2000 A; are these mA, is "
      "`parallel` more than 3, or is the capacity wrong?");
}

TEST(Plausibility, ACellThatIsSaidToBeAPackIsNamed) {
  EXPECT_EQ(
      test::LoadErrorOf([&] { CheckPlausible(OneHour(1, 1, 0.25), 2.0, 4, 1); }),
      "F:1:1: error: expected the voltage of one lithium cell of 4 in series, found 0.925 V on "
      "average; is `series` less than 4, or is this log one of a single cell?");
}

// 3 to 4.2 V, and logs of one cell and of two that are divided by more.
TEST(Plausibility, ALogOfFewerCellsThanThePackOfTheCellIsNamed) {
  const auto curve = OpenCircuitVoltage::Linear({0.0, 1.0}, {3.0, 4.2});
  const auto complaint = [&](double cells, int series) {
    return test::LoadErrorOf([&] { CheckSeries(OneHour(1, 1, cells / series), curve, series); });
  };
  EXPECT_EQ(complaint(1, 2),
            "F:1:1: error: expected the voltage of 2 cells in series, whose v_oc(A) is 3 V when "
            "empty, found 1.85 V per cell at most; is this log one of a single cell? Then say "
            "`series` = 1 (--series 1)");
  EXPECT_NE(complaint(2, 6).find("one of 2 cells? Then say `series` = 2 (--series 2)"),
            std::string::npos);
  for (const int series : {1, 2, 3, 6}) EXPECT_EQ(complaint(series, series), "no error");
}

TEST(Plausibility, AVoltageThatNoCellHasIsNamedWithItsTime) {
  Record record = OneHour(1, 1, 1);
  record.voltage_V[30] = record.voltage_V[31] = 10.0;
  EXPECT_EQ(Complaint(record, 2.0),
            "F:1:1: error: expected the voltage of one cell, found 10 V at 1800 s; remove the rows "
            "that were read wrongly, or read a part without them (start_s, end_s)");
}

TEST(Plausibility, ExchangedColumnsAreNamed) {
  Record record = OneHour(1, 1, 1);
  const ColumnPositions at{{"F", 1, 1}, {"F", 1, 8}, {"F", 1, 18}};
  const auto complaint = [&] {
    return test::LoadErrorOf([&] { (void)CheckReadable(record, at); });
  };
  for (std::size_t k = 0; k < record.size(); ++k)
    record.voltage_V[k] = 4.2 - 0.02 * static_cast<double>(k);
  EXPECT_EQ(complaint(), "no error");
  std::swap(record.current_A, record.voltage_V);
  const std::string exchanged =
      "F:1:18: error: expected a voltage, found what looks like a current, and a voltage in the "
      "column of the current; if the two are exchanged, say which is which: columns = {current_A = "
      "\"...\", voltage_V = \"...\"} (--columns)";
  EXPECT_EQ(complaint(), exchanged);  // a "voltage" of 2 V throughout
  record.voltage_V[0] = 0.0;          // and one that is zero at rest
  for (std::size_t k = 40; k < 60; ++k) record.voltage_V[k] = 1.0;
  EXPECT_EQ(complaint(), exchanged);
  // A cell that is discharged to 0 V at a constant current is none.
  for (std::size_t k = 0; k < record.size(); ++k) {
    record.current_A[k] = 2.0;
    record.voltage_V[k] = 4.2 - 0.07 * static_cast<double>(k);
  }
  EXPECT_EQ(complaint(), "no error");
}

// The current of a calm hover moves little, and the voltage of a stiff pack less.
TEST(Plausibility, AHoverIsNoExchangeOfColumns) {
  Record record = OneHour(1, 1, 1);
  for (std::size_t k = 0; k < record.size(); ++k) {
    record.current_A[k] = 12.5 + 0.4 * std::sin(static_cast<double>(k));
    record.voltage_V[k] = 16.6 - 0.002 * record.current_A[k] - 1e-5 * static_cast<double>(k);
  }
  const auto complaint = [&](const ColumnPositions& at) {
    return test::LoadErrorOf([&] { (void)CheckReadable(record, at); });
  };
  EXPECT_EQ(complaint({}), "no error");
  // Where the two do not follow each other, who named the columns knows.
  for (double& voltage_V : record.voltage_V) voltage_V = 16.6;
  EXPECT_NE(complaint({}), "no error");
  ColumnPositions named;
  named.known = true;
  EXPECT_EQ(complaint(named), "no error");
}

// A log of a current alone may have a column of zeros.
TEST(Plausibility, AVoltageThatIsNoneIsNoMislabelledOne) {
  EXPECT_EQ(CheckReadable(OneHour(1, 1, 0), {}), "");
}

TEST(Plausibility, ACurrentThatFewPacksCarryIsDoubted) {
  Record record;
  for (int k = 0; k < 30; ++k) {
    record.time_s.push_back(k);
    record.current_A.push_back(-900.0);
    record.voltage_V.push_back(4.0 - 0.01 * k);
  }
  EXPECT_EQ(CheckReadable(record, {}), "");
  record.current_A.back() = -1300.0;
  EXPECT_EQ(
      CheckReadable(record, {}),
      "the current goes up to 1300 A, more than nearly any cell or pack carries; is it in mA? "
      "Say so in the header or with `units`");
  EXPECT_EQ(
      CheckReadable(record, {.time = {}, .current = {}, .voltage = {}, .remedy = "Divide it"}),
      "the current goes up to 1300 A, more than nearly any cell or pack carries; is it in mA? "
      "Divide it");
}

// A charge of a cell with reversed leads would be a discharge whose voltage rises.
TEST(Plausibility, AVoltageBelowZeroHasExchangedLeads) {
  Record record;
  for (int k = 0; k < 30; ++k) {
    record.time_s.push_back(k);
    record.current_A.push_back(1.0);
    record.voltage_V.push_back(-4.0 + 0.01 * k);
  }
  try {
    (void)CheckReadable(record, {});
    ADD_FAILURE() << "it was believed";
  } catch (const LoadError& error) {
    EXPECT_STREQ(
        error.diagnostics().front().message.c_str(),
        "expected a voltage above 0 V, found -4 to -3.71 V: are its leads exchanged? Turn the sign of the "
        "column round");
  }
  for (double& volt : record.voltage_V) volt = -volt;
  record.voltage_V.back() = -0.5;  // one cell of a pack that is driven below empty
  EXPECT_EQ(CheckReadable(record, {}), "");
}

TEST(Plausibility, NoCellIsEmptyAtAVoltageOfHalfItsCharge) {
  EXPECT_EQ(DoubtAboutCutoff(3.5), "");
  EXPECT_EQ(DoubtAboutCutoff(1.5), "");
  EXPECT_EQ(
      DoubtAboutCutoff(3.688),
      "no lithium cell is empty at 3.688 V: the charge below this cut-off is missing in alpha; "
      "give the cut-off of the cell as cutoff_V (--cutoff-V)");
}

TEST(Plausibility, SecondsOfAClockInMinutesAreSeen) {
  Record record;
  for (int k = 0; k < 30; ++k) record.time_s.push_back(k / 60.0);
  EXPECT_EQ(
      DoubtAboutTime(record),
      "rows are 1/60 s apart, as whole seconds are on a clock in min; if the times are in min, "
      "say `units` (--units min,A,V)");
  for (double& t : record.time_s) t = std::round(t * 60.0) / 10.0;
  EXPECT_EQ(DoubtAboutTime(record), "");
  for (int k = 0; k < 30; ++k) record.time_s[static_cast<std::size_t>(k)] = k / 64.0;  // 64 Hz
  EXPECT_EQ(DoubtAboutTime(record), "");
}

Record SixPulses() {
  std::vector<test::CurrentStep> steps;
  for (int k = 0; k < 6; ++k) {
    steps.push_back({20.0, 0.0});
    steps.push_back({20.0, 2.0});
  }
  Record record = test::RecordOfSteps(steps);
  test::AddWhiteNoise(record, 1e-3, 1);
  return record;
}

TEST(Plausibility, ACurrentThatIsReadARowLateIsSaid) {
  Record record = SixPulses();
  for (std::size_t k = record.size() - 1; k > 0; --k) record.current_A[k] = record.current_A[k - 1];
  EXPECT_EQ(
      DoubtAboutLag(record),
      "at 11 of 11 steps of the current the voltage has moved one row before: if the logger reads the current "
      "a row late, shift one of the two columns by a row; as it stands, rows without a current show the "
      "voltage under load");
  EXPECT_TRUE(ReadsCurrentLate(record));
}

TEST(Plausibility, ACellThatIsHotBeforeATestMayBeInFahrenheit) {
  Record record = test::RecordOfSteps({{20.0, 0.0}, {20.0, 2.0}});
  EXPECT_EQ(DoubtAboutHotStart(record), "");
  record.temperature_degC = Column(record.size(), 59.0);
  EXPECT_EQ(DoubtAboutHotStart(record), "");
  record.temperature_degC = Column(record.size(), 77.0);
  EXPECT_EQ(
      DoubtAboutHotStart(record),
      "the cell is at 77 degC in the first row: if these are degrees Fahrenheit (25 degC), say degF in the "
      "header");
}

TEST(Plausibility, AVoltageThatIsReadARowLateIsSaid) {
  Record record = SixPulses();
  EXPECT_EQ(DoubtAboutLag(record), "");
  for (std::size_t k = record.size() - 1; k > 0; --k) record.voltage_V[k] = record.voltage_V[k - 1];
  EXPECT_EQ(
      DoubtAboutLag(record),
      "at 11 of 11 steps of the current the voltage moves one row later: if the logger reads it a row late, "
      "shift one of the two columns by a row; as it stands, resistances within one row come out too small");
  EXPECT_FALSE(ReadsCurrentLate(record));
  // A ramp, and a record of few steps, say nothing.
  EXPECT_EQ(DoubtAboutLag(test::RecordOfSteps({{20.0, 0.0}, {20.0, 2.0}})), "");
}

}  // namespace
}  // namespace lipoid
