#include "model/core/errors.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/throws.h"

namespace lipoid {
namespace {

TEST(LoadError, SaysFileLineColumnAndSentence) {
  const LoadError error({"cell.csv", 12, 7}, "expected a number, found 'abc'");
  EXPECT_STREQ(error.what(), "cell.csv:12:7: error: expected a number, found 'abc'");
  ASSERT_EQ(error.diagnostics().size(), 1U);
  EXPECT_EQ(error.diagnostics()[0].position.line, 12U);
  EXPECT_EQ(error.diagnostics()[0].position.column, 7U);
}

TEST(LoadError, MeansTheWholeFileByItsFirstCharacter) {
  EXPECT_STREQ(LoadError({"gone.csv"}, "expected a readable file").what(),
               "gone.csv:1:1: error: expected a readable file");
}

TEST(LoadError, SaysARepeatedThingOnce) {
  const Diagnostic bad{{"a.csv", 2, 1}, "expected a number"};
  const Diagnostic other{{"a.csv", 3, 1}, "expected a number"};
  const LoadError error(std::vector<Diagnostic>{bad, bad, other, bad});
  EXPECT_STREQ(error.what(),
               "a.csv:2:1: error: expected a number\na.csv:3:1: error: expected a number");
  EXPECT_EQ(error.diagnostics().size(), 2U);
}

TEST(LoadError, ShowsAHandfulOfLinesAndCountsTheRest) {
  std::vector<Diagnostic> many;
  for (std::size_t line = 1; line <= 40; ++line) many.push_back({{"a.csv", line, 1}, "no"});
  const LoadError error(many);
  EXPECT_STREQ(
      error.what(),
      "a.csv:1:1: error: no\na.csv:2:1: error: no\na.csv:3:1: error: no\na.csv:4:1: error: no\n"
      "a.csv:5:1: error: no\n... and 35 more");
  EXPECT_EQ(error.diagnostics().size(), 40U);
}

TEST(Require, ThrowsRuleValuesAndTheCallersPlace) {
  const int line = __LINE__ + 2;
  const auto message = test::MessageOf<PreconditionError>([] {
    Require(2.0 > 3.0, "dt_s > 3", {{"dt_s", 2.0}, {"k", 7.0}});
  });
  EXPECT_EQ(message.substr(message.find("errors_test.cc")),
            "errors_test.cc:" + std::to_string(line) +
                ": precondition broken: dt_s > 3 where dt_s = 2, k = 7");
}

TEST(Require, IsQuietWhereTheRuleHolds) { EXPECT_NO_THROW(Require(true, "true")); }

}  // namespace
}  // namespace lipoid
