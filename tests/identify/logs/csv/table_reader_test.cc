#include "identify/logs/csv/table_reader.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <random>

#include "tests/support/load_error.h"
#include "tests/support/text_files.h"

namespace lipoid {
namespace {

using test::WriteText;

// Every column of a file that is all numbers under one header line.
std::vector<std::vector<double>> ReadAll(const std::string& file,
                                         char delimiter,
                                         std::size_t fields) {
  TextSource source(file);
  source.Skip(source.head().find(source.line_end()) + 1);
  TableSpec spec;
  spec.delimiter = delimiter;
  spec.first_line = 2;
  spec.fields = fields;
  for (std::size_t k = 0; k < fields; ++k)
    spec.columns.push_back({.name = "c" + std::to_string(k), .field = k});
  TableReader reader(source, spec);
  std::vector<std::vector<double>> columns(fields);
  reader.ForEachBlock([&](TableBlock& block) {
    for (std::size_t k = 0; k < fields; ++k) {
      columns[k].insert(
          columns[k].end(), block.columns[k].get(), block.columns[k].get() + block.rows);
    }
  });
  return columns;
}

std::string Digits(double value, std::mt19937_64& random) {
  char text[64];
  const auto format = random() % 2 ? std::chars_format::scientific : std::chars_format::general;
  const char* const end = std::to_chars(text, text + sizeof text, value, format).ptr;
  std::string digits(text, static_cast<std::size_t>(end - text));
  if (random() % 5 == 0 && value >= 0.0) digits = "+" + digits;
  if (random() % 7 == 0) digits = " " + digits + "  ";
  if (random() % 11 == 0) digits = "\"" + digits + "\"";
  if (random() % 13 == 0 && digits.find('e') != std::string::npos) digits[digits.find('e')] = 'E';
  return digits;
}

// A field that comes again is not read again: so is nothing that only begins like it.
TEST(TableReader, FieldsThatComeAgainAreReadAsTheFirstTime) {
  const std::vector<std::string> fields = {
      "2.5",      "2.5",       "2.5",  "2.50", "2.5e1", "2.5", "-2.5",    "-2.5",    "2",
      "2",        "25",        "2.5",  "0",    "-0",    "0",   "1234567", "1234567", "12345678",
      "12345678", "123456789", " 2.5", "2.5",  "2.5 ",  "7",   "7"};
  std::string text = "a,b\n";
  std::vector<double> first;
  std::vector<double> last;
  for (std::size_t k = 0; k < 20000; ++k) {
    const std::string& a = fields[k % fields.size()];
    const std::string& b = fields[(k / 3) % fields.size()];
    text += a;
    text += ',';
    text += b;
    text += k % 5 == 0 ? "\r\n" : "\n";
    first.push_back(std::strtod(a.c_str(), nullptr));
    last.push_back(std::strtod(b.c_str(), nullptr));
  }
  const auto columns = ReadAll(WriteText("log.csv", text), ',', 2);
  const auto same = [](const std::vector<double>& a, const std::vector<double>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
  };
  EXPECT_TRUE(same(columns[0], first));
  EXPECT_TRUE(same(columns[1], last));
}

// Any doubles, printed in any way that says them fully, come back bit for bit.
TEST(TableReader, RandomTablesComeBackBitForBit) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    const char delimiter = ",;\t"[random() % 3];
    const std::string line_end = std::vector<std::string>{"\n", "\r\n", "\r"}[random() % 3];
    const bool decimal_comma = delimiter != ',' && random() % 2;
    const std::size_t fields = 2 + random() % 6;
    const std::size_t rows = 1 + random() % (seed % 20 == 0 ? 40000 : 50);
    std::vector<std::vector<double>> expected(fields);
    std::string text = "header" + line_end;
    for (std::size_t row = 0; row < rows; ++row) {
      for (std::size_t k = 0; k < fields; ++k) {
        double value = 0.0;
        do {
          const std::uint64_t bits = random();
          std::memcpy(&value, &bits, sizeof value);
        } while (!(std::abs(value) < 1e30));
        if (random() % 3 == 0) value = static_cast<double>(random() % 100000) / 1000.0;
        expected[k].push_back(value);
        std::string digits = Digits(value, random);
        if (decimal_comma) {
          if (row == 0 && k == 0 &&
              digits.find('.') == std::string::npos) {  // the first fraction decides
            expected[0][0] = 0.5;
            digits = "0.5";
          }
          for (char& c : digits) c = c == '.' ? ',' : c;
        }
        text += digits + (k + 1 < fields ? std::string(1, delimiter) : line_end);
      }
      if (random() % 50 == 0) text += line_end;  // a blank line
    }
    const auto found = ReadAll(WriteText("table", text), delimiter, fields);
    for (std::size_t k = 0; k < fields; ++k) {
      ASSERT_EQ(found[k].size(), expected[k].size());
      ASSERT_EQ(std::memcmp(found[k].data(), expected[k].data(), rows * sizeof(double)), 0)
          << "column " << k;
    }
  }
}

TEST(TableReader, PicksColumnsOutOfOrderAndKeepsPositions) {
  const std::string file = WriteText("table", "h\n# c\n1,x,\"2\",3\n\n4,\"y, z\",5,6\n7,w,bad,9\n");
  TextSource source(file);
  source.Skip(2);
  TableSpec spec;
  spec.first_line = 2;
  spec.fields = 4;
  spec.comments = true;
  spec.columns = {{.name = "third", .field = 2}, {.name = "first", .field = 0}};
  TableReader reader(source, spec);
  TableBlock block;
  EXPECT_EQ(test::LoadErrorOf([&] { (void)reader.NextBlock(block); }),
            file + ":6:5: error: expected a number in column 'third', found 'bad'");
  ASSERT_EQ(block.rows, 2U);
  EXPECT_EQ(block.columns[0][1], 5.0);
  EXPECT_EQ(block.columns[1][1], 4.0);
  EXPECT_EQ(reader.PositionOf(0, 0), (SourcePosition{file, 3, 5}));
  EXPECT_EQ(reader.PositionOf(1, 0), (SourcePosition{file, 5, 10}));
  EXPECT_EQ(reader.TextOf(1, 0), "5");
  EXPECT_EQ(reader.comment_lines(), 1U);
  EXPECT_EQ(reader.blank_lines(), 1U);
}

// Rows that end on either side of every block boundary.
TEST(TableReader, BlocksJoinWithoutASeam) {
  std::string text = "h\n";
  std::vector<double> expected;
  for (int k = 0; k < 400000; ++k) {
    text += std::to_string(k) + "," + std::string(static_cast<std::size_t>(k % 7), '0') +
            std::to_string(k % 10) + "\n";
    expected.push_back(k);
  }
  ASSERT_GT(text.size(), 2 * TextSource::kBufferBytes);
  EXPECT_EQ(ReadAll(WriteText("table", text), ',', 2)[0], expected);
}

// Pieces are read side by side. What care finds in one of them must reach the later ones: a
// decimal mark that shows late, lines that are skipped, and where an error stands.
TEST(TableReader, PiecesReadSideBySideAreAsIfReadInTurn) {
  constexpr int kRows = 400000;
  constexpr int kFirstFraction = 200000;
  std::string text = "h\n";
  std::vector<double> expected;
  int line = 1;
  int bad_line = 0;
  for (int k = 0; k < kRows; ++k) {
    if (k % 30011 == 30010) {
      text += "\n";  // skipped
      ++line;
    }
    text += std::to_string(k) + ";" + std::to_string(k) + (k >= kFirstFraction ? ",25\n" : "\n");
    expected.push_back(k >= kFirstFraction ? k + 0.25 : k);
    ++line;
    if (k == kRows - 1000) bad_line = line;
  }
  ASSERT_GT(text.size(), 2 * TextSource::kBufferBytes);
  const std::string file = WriteText("table", text);
  auto bad = text;
  const std::string good_row = "\n" + std::to_string(kRows - 1000) + ";";
  bad.replace(bad.find(good_row) + good_row.size(), 1, "x");
  const std::string bad_file = WriteText("bad", bad);
  const std::string long_file = WriteText("long", text + std::string(1 << 20, '7'));
  for (const std::size_t threads : {1U, 2U, 4U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    EXPECT_EQ(ReadAll(file, ';', 2)[1], expected) << threads;
    EXPECT_EQ(test::LoadErrorOf([&] { (void)ReadAll(bad_file, ';', 2); }),
              fmt::format("{}:{}:8: error: expected a number in column 'c1', found 'x{},25'",
                          bad_file,
                          bad_line,
                          std::to_string(kRows - 1000).substr(1)));
    EXPECT_EQ(test::LoadErrorOf([&] { (void)ReadAll(long_file, ';', 2); }),
              fmt::format("{}:{}:1: error: expected a row of a log, found a line of more than {} "
                          "bytes",
                          long_file,
                          line + 1,
                          TextSource::kMaxLineBytes));
  }
}

// Each row is one text in quotes: its closing quote shows that the last row is whole.
TEST(TableReader, ALastRowInQuotesNeedsNoLineEnd) {
  const std::string rows = "header\n\"0,4.125\"\n\"1,4.125\"\n\"2,4.125\"\n";
  for (const char* const last : {"\"3,4.125\"", "\"3,4.1\""}) {
    const auto columns = ReadAll(WriteText("quoted.csv", rows + last), ',', 2);
    ASSERT_EQ(columns[0].size(), 4U) << last;
    EXPECT_EQ(columns[0][3], 3.0);
  }
  // Without the closing quote it is cut off.
  EXPECT_EQ(ReadAll(WriteText("quoted.csv", rows + "\"3,4.1"), ',', 2)[0].size(), 3U);
}

TEST(Cells, QuotesAndColumns) {
  std::vector<TextCell> cells;
  SplitLine(R"(a, "b;c" ,"d ""e""",, "open)", ',', cells);
  ASSERT_EQ(cells.size(), 5U);
  EXPECT_EQ(cells[0].text, "a");
  EXPECT_EQ(cells[1].text, "b;c");
  EXPECT_EQ(cells[1].column, 4U);
  EXPECT_EQ(cells[2].text, R"(d ""e"")");
  EXPECT_EQ(cells[3].text, "");
  EXPECT_EQ(cells[4].text, "\"open");
  EXPECT_EQ(Unwrapped("\"a,b\"", ','), "a,b");
  EXPECT_EQ(Unwrapped("\"a\",\"b\"", ','), "\"a\",\"b\"");
}

}  // namespace
}  // namespace lipoid
