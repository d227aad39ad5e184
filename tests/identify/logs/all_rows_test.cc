// Every row of a log that was thinned, against the same log with every row kept: bit for bit.
#include "identify/logs/all_rows.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "tests/support/load_error.h"
#include "tests/support/synthetic_record.h"
#include "tests/support/text_files.h"

namespace lipoid {
namespace {

using test::WriteText;

using test::kEveryRow;
constexpr std::size_t kMostRows = 8192;
constexpr std::size_t kRowsOfLog = 60000;

// A discharge with rests and noise, by a function that writes one row.
template <class Row>
std::string Text(const std::string& header, const Row& row) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  std::string text = header + "\n";
  double charge_C = 0.0;
  for (std::size_t k = 0; k < kRowsOfLog; ++k) {
    const double current_A = k % 10000 < 4000 ? 0.0 : 2.5 + 0.003 * normal(random);
    charge_C += 0.01 * current_A;
    row(text, k, current_A, 4.1 - 0.02 * current_A - 4e-4 * charge_C + 2e-4 * normal(random));
  }
  return text;
}

// Both readings of a file, and how they compare.
void ExpectTheSame(const std::string& text, ReadOptions options) {
  const std::string file = WriteText("log.csv", text);
  options.most_rows = kEveryRow;
  const Log every = ReadLog(file, options);
  options.most_rows = kMostRows;
  Log log = ReadLog(file, options);
  ASSERT_TRUE(log.report.thinned);
  Record all;
  std::size_t blocks = 0;
  ForEachBlockOfRows(log, options, [&](Record& rows) {
    ++blocks;
    EXPECT_EQ(rows.hold, every.record.hold);
    const auto append = [](Column& to, const Column& from) { to.append(from.begin(), from.end()); };
    append(all.time_s, rows.time_s);
    append(all.current_A, rows.current_A);
    append(all.voltage_V, rows.voltage_V);
    append(all.temperature_degC, rows.temperature_degC);
  });
  EXPECT_GT(blocks, 2U);
  EXPECT_EQ(log.report.rows, every.record.size());
  EXPECT_EQ(all.time_s, every.record.time_s);
  EXPECT_EQ(all.current_A, every.record.current_A);
  EXPECT_EQ(all.voltage_V, every.record.voltage_V);
  EXPECT_EQ(all.temperature_degC, every.record.temperature_degC);
}

TEST(AllRows, ALogThatWasKeptIsOneBlock) {
  Log log =
      ReadLogText(Text("time_s,current_A,voltage_V",
                       [](std::string& to, std::size_t k, double i, double v) {
                         fmt::format_to(std::back_inserter(to), "{},{:.5f},{:.5f}\n", k, i, v);
                       }),
                  "F");
  const double* const first = log.record.time_s.data();
  std::size_t blocks = 0;
  ForEachBlockOfRows(log, {}, [&](Record& rows) {
    ++blocks;
    EXPECT_EQ(std::as_const(rows.time_s).data(), first);  // not a copy
    EXPECT_EQ(rows.size(), kRowsOfLog);
  });
  EXPECT_EQ(blocks, 1U);
}

// Charging positive, units that are not SI, spikes, repeated times, a temperature, and leads.
TEST(AllRows, RowsAreThoseOfOneReading) {
  const std::string text = Text("time_min,current_mA,voltage_V,temperature_degC",
                                [](std::string& to, std::size_t k, double i, double v) {
                                  if (k % 13000 == 5000) v = 9.5;
                                  fmt::format_to(std::back_inserter(to),
                                                 "{:.5f},{:.5f},{:.5f},{:.2f}\n",
                                                 0.001 * static_cast<double>(k),
                                                 -1000.0 * i,
                                                 v,
                                                 20.0 + 1e-4 * static_cast<double>(k));
                                  if (k % 17000 == 9000) {
                                    fmt::format_to(std::back_inserter(to),
                                                   "{:.5f},{:.5f},{:.5f},{:.2f}\n",
                                                   0.001 * static_cast<double>(k),
                                                   -1000.0 * i,
                                                   v,
                                                   20.0);
                                  }
                                });
  ReadOptions options;
  options.lead_resistance_Ohm = 0.01;
  ExpectTheSame(text, options);
  options.hold = Hold::kForward;
  ExpectTheSame(text, options);
  options.start_s = 60.0;
  options.end_s = 3500.0;
  ExpectTheSame(text, options);
}

// States that say the sign, voltages that turn out to be mV, and a clock of 1970.
TEST(AllRows, WhatTheWholeLogSettlesHoldsForEachBlock) {
  ExpectTheSame(Text("Rec#,Cyc#,Step,Test (Sec),mAmps,Volts,State",
                     [](std::string& to, std::size_t k, double i, double v) {
                       fmt::format_to(std::back_inserter(to),
                                      "{},1,1,{:.2f},{:.5f},{:.5f},{}\n",
                                      k,
                                      0.01 * static_cast<double>(k),
                                      1000.0 * i,
                                      1000.0 * v,
                                      i > 0.0 ? "D" : "R");
                     }),
                {});
  ExpectTheSame(Text("time_s,current_A,voltage_V",
                     [](std::string& to, std::size_t k, double i, double v) {
                       fmt::format_to(std::back_inserter(to),
                                      "{:.2f},{:.5f},{:.5f}\n",
                                      1.6e9 + 0.01 * static_cast<double>(k),
                                      i,
                                      v);
                     }),
                {});
}

TEST(AllRows, AFileThatChangedIsRefused) {
  const auto row = [](std::string& to, std::size_t k, double i, double v) {
    fmt::format_to(
        std::back_inserter(to), "{:.2f},{:.5f},{:.5f}\n", 0.01 * static_cast<double>(k), i, v);
  };
  const std::string text = Text("time_s,current_A,voltage_V", row);
  const std::string file = WriteText("log.csv", text);
  ReadOptions options;
  options.most_rows = kMostRows;
  Log log = ReadLog(file, options);
  WriteText("log.csv", text.substr(0, text.rfind('\n', text.size() - 2) + 1));
  EXPECT_EQ(
      test::LoadErrorOf([&] { ForEachBlockOfRows(log, options, [](Record&) {}); }),
      file +
          ":1:1: error: expected the 60000 rows that the first reading found, found 59999: the "
          "file changed while it was read");
}

TEST(AllRows, APipeCannotBeReadTwice) {
  Log log;
  log.record.file = "/dev/null";
  log.report.thinned = {.rows_of_log = 20000, .most_rows = 10000};
  EXPECT_EQ(
      test::LoadErrorOf([&] { ForEachBlockOfRows(log, {}, [](Record&) {}); }),
      "/dev/null:1:1: error: expected a file, as a log of more than 10000 rows is read twice, found "
      "a pipe or device; write it to a file first, or keep all of its 20000 rows (--most-rows)");
}

}  // namespace
}  // namespace lipoid
