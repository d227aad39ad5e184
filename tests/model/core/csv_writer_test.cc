#include "model/core/csv_writer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <random>
#include <sstream>
#include <vector>

#include "model/core/json.h"
#include "tests/support/paths.h"

namespace lipoid {
namespace {

TEST(CsvWriter, WritesTheShortestDigitsWithoutExponents) {
  const auto file = test::FreshFolder("CsvWriter.Shortest") + "/a.csv";
  CsvWriter csv(file, "a,b,c");
  csv.Row(0.07, 100000.0, std::nan(""));
  csv.Row(-1e-7, 0.1 + 0.2, 3);
  EXPECT_FALSE(std::filesystem::exists(file));
  csv.Commit();
  EXPECT_EQ(ReadTextFile(file), "a,b,c\n0.07,100000,\n-0.0000001,0.30000000000000004,3\n");
  EXPECT_EQ(csv.rows(), 2U);
  EXPECT_EQ(csv.bytes(), std::filesystem::file_size(file));
}

TEST(CsvWriter, EveryDoubleReadsBack) {
  const auto file = test::FreshFolder("CsvWriter.Every") + "/a.csv";
  std::vector<double> values{0.0,
                             std::numeric_limits<double>::max(),
                             std::numeric_limits<double>::denorm_min(),
                             -std::numeric_limits<double>::min()};
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> exponent(-12.0, 12.0);
  for (int k = 0; k < 100'000; ++k) values.push_back(std::pow(10.0, exponent(engine)));
  CsvWriter csv(file, "x");
  for (const double value : values) csv.Row(value);
  csv.Commit();
  std::istringstream in(ReadTextFile(file));
  std::string line;
  std::getline(in, line);
  for (const double value : values) {
    ASSERT_TRUE(std::getline(in, line));
    ASSERT_EQ(std::strtod(line.c_str(), nullptr), value) << line;
  }
  EXPECT_FALSE(std::getline(in, line));
}

}  // namespace
}  // namespace lipoid
