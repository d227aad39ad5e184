#include "identify/logs/csv/plain_decimal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>
#include <string>

namespace lipoid {
namespace {

struct Read {
  std::ptrdiff_t length = -1;  // -1: left to others
  double value = 0.0;
};

// What follows the number in the file is there to mislead.
Read ReadFrom(const std::string& number, char mark = '.') {
  const std::string text = number + ";9.87654321\n98765432109876543210";
  Read read;
  if (const char* end = ReadPlainDecimal(text.c_str(), mark, read.value))
    read.length = end - text.c_str();
  return read;
}

#if defined(__SSE2__)
constexpr bool kIsUsed = true;
#else
constexpr bool kIsUsed = false;
#endif

TEST(PlainDecimal, IsTheNearestDouble) {
  if (!kIsUsed) GTEST_SKIP() << "no SSE2: every number is left to fast_float";
  std::mt19937_64 engine(1);
  const auto below = [&](int n) { return static_cast<int>(engine() % static_cast<unsigned>(n)); };
  for (int k = 0; k < 200000; ++k) {
    const int whole = 1 + below(8);
    const int fraction = below(std::min(8, 14 - whole) + 1);
    std::string number = below(3) == 0 ? "-" : "";
    for (int j = 0; j < whole; ++j) number += static_cast<char>('0' + below(10));
    if (fraction > 0) number += '.';
    for (int j = 0; j < fraction; ++j) number += static_cast<char>('0' + below(10));
    const Read read = ReadFrom(number);
    ASSERT_EQ(read.length, static_cast<std::ptrdiff_t>(number.size())) << number;
    const double nearest = std::strtod(number.c_str(), nullptr);
    ASSERT_EQ(read.value, nearest) << number;
    ASSERT_EQ(std::signbit(read.value), std::signbit(nearest)) << number;
  }
}

TEST(PlainDecimal, KnowsTheMarkOfTheFile) {
  if (!kIsUsed) GTEST_SKIP() << "no SSE2: every number is left to fast_float";
  EXPECT_EQ(ReadFrom("12,25", ',').value, 12.25);
  EXPECT_EQ(ReadFrom("12,25", ',').length, 5);
  EXPECT_EQ(ReadFrom("12,25", '.').length, 2);  // the mark of another file ends the number
  EXPECT_EQ(ReadFrom("12.25", ',').length, 2);
}

TEST(PlainDecimal, LeavesWhatIsNotPlainToOthers) {
  for (const char* number : {"",
                             ".5",
                             "5.",
                             "-",
                             "--5",
                             "+5",
                             " 5",
                             "nan",
                             "inf",
                             "123456789",         // more digits than fit
                             "1.123456789",       // after the mark
                             "12345678.1234567",  // or in all
                             "1234567890123456",
                             "0.1234567890123456"}) {
    EXPECT_EQ(ReadFrom(number).length, -1) << number;
  }
}

TEST(PlainDecimal, StopsBeforeAnExponent) {
  if (!kIsUsed) GTEST_SKIP() << "no SSE2: every number is left to fast_float";
  EXPECT_EQ(ReadFrom("1.5e3").length, 3);
  EXPECT_EQ(ReadFrom("7E-2").length, 1);
  EXPECT_EQ(ReadFrom("1.5.2").length, 3);
}

}  // namespace
}  // namespace lipoid
