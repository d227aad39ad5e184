#include "identify/logs/plausibility.h"

#include <gtest/gtest.h>

#include "tests/support/load_error.h"

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

}  // namespace
}  // namespace lipoid
