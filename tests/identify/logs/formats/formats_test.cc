// Every format against the same made-up test (fixtures/logs), as it is and after changes that a
// file meets on its way: it reads to the same record or it is refused, and never to other numbers.
#include "identify/logs/formats/formats.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <ostream>
#include <random>

#include "identify/logs/formats/header.h"
#include "model/core/errors.h"
#include "tests/support/load_error.h"
#include "tests/support/paths.h"
#include "tests/support/text_files.h"

namespace lipoid {
namespace {

using test::ReadText;
using test::SourcePath;
using test::WriteText;

// The test as fixtures/logs/generate.py defines it.
const std::vector<double> kTime_s{0, 36, 72, 108, 144, 180, 216, 252, 288, 324, 360, 396};
const std::vector<double> kCurrent_A{0, 0, 2, 2, 2, 2, 0, 0, -1, -1, -1, 0};
const std::vector<double> kVoltage_V{
    4.0, 4.0, 3.9, 3.89, 3.88, 3.87, 3.96, 3.97, 4.02, 4.025, 4.03, 3.985};

// Hours and minutes with two decimals, dates and milli-units round once or twice.
constexpr double kRounding = 1e-12;

struct Fixture {
  const char* file;
  const char* format;
  const char* sign;
  char delimiter = ',';
  ReadOptions options = {};
};

void PrintTo(const Fixture& fixture, std::ostream* os) { *os << fixture.file; }

const Fixture kFixtures[] = {
    {"arbin/mits.csv", "arbin", "discharge-negative"},
    {"arbin/mits10.csv", "arbin", "discharge-negative"},
    {"arbin/no_units.csv", "arbin", "discharge-negative"},
    {"basytec/time_h.txt", "basytec", "discharge-negative", '\t'},
    {"basytec/time_s.txt", "basytec", "discharge-negative", '\t'},
    {"bdf/hours.bdf.csv", "bdf", "discharge-negative"},
    {"bdf/labels.bdf.csv", "bdf", "discharge-negative"},
    {"bdf/machine.bdf.csv", "bdf", "discharge-negative"},
    {"bdf/old_names.bdf.csv", "bdf", "discharge-negative"},
    {"betaflight/decoded.csv", "betaflight", "discharge-positive"},
    {"biologic/dates.txt", "biologic", "discharge-negative", '\t'},
    {"biologic/derived.csv", "biologic", "discharge-negative", ';'},
    {"biologic/header.mpt", "biologic", "discharge-negative", '\t'},
    {"biologic/no_header.mpt", "biologic", "discharge-negative", '\t'},
    {"bitrode/header.csv", "bitrode", "discharge-negative"},
    {"bitrode/no_header.csv", "bitrode", "discharge-negative"},
    {"digatron/hash_units.csv", "digatron", "discharge-negative"},
    {"digatron/units_line.csv", "digatron", "discharge-negative"},
    {"simulated-flight/flight.csv", "simulated-flight", "discharge-positive"},
    {"maccor/days.041", "maccor", "unsigned", '\t'},
    {"maccor/manifest_names.csv", "maccor", "unsigned"},
    {"maccor/milliamps_millivolts.txt", "maccor", "unsigned", '\t'},
    {"maccor/mims_minutes_decimal_comma.txt", "maccor", "unsigned", '\t'},
    {"maccor/no_units.csv", "maccor", "discharge-negative"},
    {"maccor/seconds.052", "maccor", "discharge-negative", '\t'},
    {"neware/clock_restarts.csv", "neware", "discharge-negative"},
    {"neware/flat.csv", "neware", "discharge-negative"},
    {"neware/three_levels.csv", "neware", "discharge-negative"},
    {"neware/total_time_s.csv", "neware", "discharge-negative"},
    {"novonix/quoted_rows.csv", "novonix", "discharge-negative"},
    {"novonix/uhpc.csv", "novonix", "discharge-negative"},
    {"plain-csv/dates.csv", "plain-csv", "discharge-positive"},
    {"plain-csv/hours_decimal_comma.txt", "plain-csv", "discharge-positive", '\t'},
    {"plain-csv/landt.csv", "plain-csv", "discharge-negative"},
    {"plain-csv/milli.csv", "plain-csv", "discharge-negative", ';'},
    {"plain-csv/minutes_old_mac.csv", "plain-csv", "discharge-positive"},
    {"plain-csv/no_units.csv", "plain-csv", "discharge-positive", ',', {.units = {"s", "A", "V"}}},
    {"plain-csv/pec.csv", "plain-csv", "discharge-negative"},
    {"plain-csv/quoted.csv", "plain-csv", "discharge-positive"},
    {"plain-csv/si.csv", "plain-csv", "discharge-positive"},
    {"plain-csv/unix_clock.csv", "plain-csv", "discharge-positive"},
};

// Without its byte order mark.
std::string TextOf(const Fixture& fixture) {
  const std::string text = ReadText(SourcePath(std::string("fixtures/logs/") + fixture.file));
  return text.starts_with("\xEF\xBB\xBF") ? text.substr(3) : text;
}

void ExpectTheTest(const Record& record, std::size_t rows) {
  ASSERT_EQ(record.size(), rows);
  for (std::size_t k = 0; k < rows; ++k) {
    SCOPED_TRACE(k);
    EXPECT_NEAR(record.time_s[k], kTime_s[k], kRounding * 1e3);
    EXPECT_NEAR(record.current_A[k], kCurrent_A[k], kRounding);
    EXPECT_NEAR(record.voltage_V[k], kVoltage_V[k], kRounding);
  }
}

class FormatConformance : public testing::TestWithParam<Fixture> {
 protected:
  // The changed file reads to the whole test; or is refused, where that is allowed, with a message.
  void ExpectTheSame(const std::string& changed, const std::string& what, bool may_refuse = false) {
    SCOPED_TRACE(what);
    const std::string file = WriteText("changed", changed);
    try {
      const Log log = ReadLog(file, GetParam().options);
      ExpectTheTest(log.record, kTime_s.size());
    } catch (const LoadError& error) {
      EXPECT_TRUE(may_refuse) << error.what();
    }
  }
};

TEST_P(FormatConformance, ReadsTheTest) {
  const Fixture& fixture = GetParam();
  const Log log =
      ReadLog(SourcePath(std::string("fixtures/logs/") + fixture.file), fixture.options);
  ExpectTheTest(log.record, kTime_s.size());
  EXPECT_EQ(log.report.format, fixture.format);
  EXPECT_EQ(log.report.current_sign, fixture.sign) << log.report.current_sign_reason;
  EXPECT_EQ(log.report.dropped_rows(), 0U);
  for (const double t : log.record.temperature_degC) EXPECT_NEAR(t, 24.0, 3.0);
}

TEST_P(FormatConformance, TheNameOfTheFileSaysNothing) {
  ExpectTheSame(TextOf(GetParam()), "renamed");
}

TEST_P(FormatConformance, LineEndsDoNotMatter) {
  std::string lines = TextOf(GetParam());
  if (lines.find('\n') == std::string::npos) std::replace(lines.begin(), lines.end(), '\r', '\n');
  std::erase(lines, '\r');
  ExpectTheSame(lines, "LF");
  std::string other;
  for (const char c : lines) other += c == '\n' ? std::string("\r\n") : std::string(1, c);
  ExpectTheSame(other, "CRLF");
  std::replace(lines.begin(), lines.end(), '\n', '\r');
  ExpectTheSame(lines, "CR");
}

TEST_P(FormatConformance, AByteOrderMarkIsSkipped) {
  ExpectTheSame("\xEF\xBB\xBF" + TextOf(GetParam()), "BOM");
}

TEST_P(FormatConformance, BlankLinesAtTheEndAreSkipped) {
  std::string text = TextOf(GetParam());
  const char end = text.find('\n') == std::string::npos ? '\r' : '\n';
  if (text.back() != end) text += end;
  ExpectTheSame(text + end + end, "blank lines");
}

TEST_P(FormatConformance, UpperCaseChangesNothing) {
  std::string text = TextOf(GetParam());
  for (char& c : text) c = static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
  ExpectTheSame(text, "upper case");
  for (char& c : text) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  // The header-less Bitrode rows are known by their words in capitals.
  ExpectTheSame(text, "lower case", std::string(GetParam().file) == "bitrode/no_header.csv");
}

// The table with its columns turned round, its preamble as it was.
TEST_P(FormatConformance, TheOrderOfTheColumnsDoesNotMatter) {
  const Fixture& fixture = GetParam();
  const std::string name = fixture.file;
  if (name == "bitrode/no_header.csv" || name == "neware/three_levels.csv" ||
      name.ends_with("quoted.csv") || name.ends_with("quoted_rows.csv")) {
    return;  // no columns that could move
  }
  const std::string text = TextOf(fixture);
  const char end = text.find('\n') == std::string::npos ? '\r' : '\n';
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const auto stop = std::min(text.find(end, at), text.size());
    lines.push_back(text.substr(at, stop - at));
    if (lines.back().ends_with('\r')) lines.back().pop_back();
    at = stop + 1;
  }
  const auto count = [&](const std::string& line) {
    return std::count(line.begin(), line.end(), fixture.delimiter);
  };
  const auto widest = count(lines.back());
  std::string turned;
  for (const auto& line : lines) {
    if (count(line) == widest && !line.starts_with("Test Name") &&
        line.find_first_not_of(',') != std::string::npos) {
      std::vector<TextCell> cells;
      SplitLine(line, fixture.delimiter, cells);
      std::reverse(cells.begin(), cells.end());
      for (std::size_t k = 0; k < cells.size(); ++k)
        turned += (k ? std::string(1, fixture.delimiter) : "") + std::string(cells[k].text);
    } else {
      turned += line;
    }
    turned += end;
  }
  // Landt's rows end in a delimiter that its header has not: turned round, they have a field too
  // many.
  ExpectTheSame(turned, "turned round", name == "plain-csv/landt.csv");
}

// At every byte of the last line: the rows above are as they were, the last one is as it was or
// dropped and counted, or the file is refused. The one thing that no reader can see: digits missing
// from a wanted last field.
TEST_P(FormatConformance, ACutLastLineNeverGivesOtherNumbers) {
  std::string text = TextOf(GetParam());
  while (text.ends_with('\n') || text.ends_with('\r')) text.pop_back();
  const auto last_line = text.find_last_of("\r\n") + 1;
  const auto last_delimiter = text.find_last_of(GetParam().delimiter);
  const std::string format = GetParam().format;
  for (std::size_t size = last_line + 1; size < text.size(); ++size) {
    SCOPED_TRACE(text.substr(last_line, size - last_line));
    const std::string file = WriteText("cut", text.substr(0, size));
    try {
      const Log log = ReadLog(file, GetParam().options);
      const std::size_t rows = log.record.size();
      ASSERT_TRUE(rows == kTime_s.size() || rows + 1 == kTime_s.size());
      EXPECT_EQ(log.report.dropped_cut_last_line, kTime_s.size() - rows);
      if (rows == kTime_s.size() && size > last_delimiter &&
          (format == "plain-csv" || format == "bdf"))
        continue;
      ExpectTheTest(log.record, rows);
    } catch (const LoadError& error) {
      EXPECT_NE(std::string(error.what()).find(": error: "), std::string::npos);
    }
  }
}

// A bad file per error, for every format.
TEST_P(FormatConformance, WhatIsWrongIsRefused) {
  const std::string text = TextOf(GetParam());
  const char end = text.find('\n') == std::string::npos ? '\r' : '\n';
  const auto last_line = text.find_last_of(end, text.size() - 2) + 1;
  const auto voltage =
      text.rfind("3.985") != std::string::npos ? text.rfind("3.985") : text.rfind("3,985");
  const auto refuses = [&](const std::string& changed, const std::string& what) {
    const std::string file = WriteText("wrong", changed);
    const std::string message = test::LoadErrorOf([&] { (void)ReadLog(file, GetParam().options); });
    EXPECT_TRUE(message.starts_with(file + ":") &&
                message.find(": error: expected ") != std::string::npos)
        << what << ": " << message;
  };
  if (std::string(GetParam().file).find("three_levels") == std::string::npos) {
    std::string earlier = text.substr(0, last_line);
    const auto before = earlier.find_last_of(end, earlier.size() - 2) + 1;
    const std::string swapped = text.substr(0, before) + text.substr(last_line) +
                                (text.back() == end ? "" : std::string(1, end)) +
                                earlier.substr(before);
    if (std::string(GetParam().file).find("clock_restarts") == std::string::npos)
      refuses(swapped, "time runs backwards");
  }
  if (voltage != std::string::npos && voltage > last_line) {
    const bool decimal_comma = text[voltage + 1] == ',';
    for (const char* word : {"abcde", "nan  ", "-inf ", "1e999", "3.4E38", "     ", "3.9.8"}) {
      std::string changed = text;
      const auto length =
          std::min(text.find_first_of(decimal_comma ? "\t" : "\t;,\"\r\n", voltage), text.size()) -
          voltage;
      refuses(changed.replace(voltage, length, word) +
                  std::string(text.back() == end ? "" : std::string(1, end)),
              word);
    }
  }
}

// Bytes changed at random: a record or a LoadError, never a crash, a hang or another exception.
TEST_P(FormatConformance, DamagedFilesAreReadOrRefused) {
  const std::string text = TextOf(GetParam());
  std::mt19937 random(7);
  for (int round = 0; round < 60; ++round) {
    std::string damaged = text;
    const auto changes = 1 + random() % 8;
    for (unsigned k = 0; k < changes; ++k) {
      const auto at = random() % damaged.size();
      switch (random() % 4) {
        case 0:
          damaged[at] = static_cast<char>(random());
          break;
        case 1:
          damaged.erase(at, 1 + random() % 20);
          break;
        case 2:
          damaged.insert(at, damaged.substr(random() % damaged.size(), random() % 30));
          break;
        default:
          damaged[at] = ",;\t\n\r\"#.-+eE0 \0"[random() % 16];
          break;
      }
      if (damaged.empty()) damaged = "x";
    }
    const std::string file = WriteText("damaged", damaged);
    try {
      const Log log = ReadLog(file, GetParam().options);
      for (std::size_t k = 1; k < log.record.size(); ++k)
        ASSERT_GT(log.record.time_s[k], log.record.time_s[k - 1]);
      for (std::size_t k = 0; k < log.record.size(); ++k) {
        ASSERT_TRUE(std::isfinite(log.record.current_A[k]) &&
                    std::isfinite(log.record.voltage_V[k]));
      }
    } catch (const LoadError&) {  // as it should be
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, FormatConformance, testing::ValuesIn(kFixtures));

TEST(LogFormats, AreSortedAndEachHasAFixture) {
  std::vector<std::string> names;
  for (const Layout* layout : LogFormats()) names.emplace_back(layout->name);
  EXPECT_TRUE(std::is_sorted(names.begin(), names.end()));
  for (const auto& name : names) {
    EXPECT_TRUE(std::any_of(std::begin(kFixtures), std::end(kFixtures), [&](const auto& f) {
      return f.format == name;
    })) << name;
  }
}

TEST(LogFormats, EachVendorHeaderIsKnownByOneFormat) {
  for (const Fixture& fixture : kFixtures) {
    const std::string text = TextOf(fixture);
    std::vector<std::string> known;
    const char end = text.find('\n') == std::string::npos ? '\r' : '\n';
    for (std::size_t at = 0; at < text.size();
         at = std::min(text.find(end, at), text.size() - 1) + 1) {
      std::vector<TextCell> cells;
      std::vector<HeaderName> names;
      const std::string line = text.substr(at, std::min(text.find(end, at), text.size()) - at);
      SplitLine(Unwrapped(line, fixture.delimiter), fixture.delimiter, cells);
      for (const TextCell& cell : cells) names.push_back(ParseHeaderName(cell));
      for (const Layout* layout : LogFormats()) {
        if (!layout->signature[0].empty() && Matches(names, layout->signature))
          known.emplace_back(layout->name);
      }
    }
    const bool vendor = std::string(fixture.format) != "plain-csv" &&
                        std::string(fixture.file) != "bitrode/no_header.csv";
    EXPECT_EQ(known, vendor ? std::vector<std::string>{fixture.format} : std::vector<std::string>{})
        << fixture.file;
  }
}

TEST(LogFormats, AClockThatRestartsInBdfIsRefusedAndReadWithAnotherColumn) {
  const std::string file = SourcePath("fixtures/logs/bdf/clock_restarts.bdf.csv");
  EXPECT_EQ(test::LoadErrorOf([&] { (void)ReadLog(file); }),
            file +
                ":8:1: error: expected time to increase, found '36' after 144 s; if the clock "
                "starts anew with each "
                "step or cycle, pick some with `steps` or `cycles`, or name a column that runs on "
                "with `columns = "
                "{time_s = \"...\"}`; logs that were joined are read one by one");
  ExpectTheTest(ReadLog(file, {.columns = {{"time_s", "unix_time_second"}}}).record,
                kTime_s.size());
  const Log step = ReadLog(file, {.current_sign = "discharge-negative", .steps = {2}});
  EXPECT_EQ(step.record.current_A, (std::vector<double>{2, 2, 2, 2}));
  EXPECT_EQ(step.record.time_s, (std::vector<double>{0, 36, 72, 108}));
  EXPECT_EQ(step.report.dropped_unselected, 8U);
}

}  // namespace
}  // namespace lipoid
