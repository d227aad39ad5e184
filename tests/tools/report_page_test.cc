// What a page of a result holds: samples thinned without losing a peak, a summary without what no
// chart shows, and nothing that a browser takes for a command.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>

#include "tools/report/log_series.h"
#include "tools/report/report.h"
#include "tools/report/shown_summary.h"
#include "tools/report/thin.h"

namespace lipoid {
namespace {

TEST(ThinnedRows, KeepAllWhereThereAreNoMore) {
  const std::vector<double> values{3.0, 1.0, 2.0};
  const std::vector<std::span<const double>> seen{values};
  EXPECT_EQ(ThinnedRows(3, seen, {}, 3), (std::vector<std::size_t>{0, 1, 2}));
}

TEST(ThinnedRows, KeepThePeakOfOneRowInAMillion) {
  constexpr std::size_t kRows = 1'000'000;
  constexpr std::size_t kMost = 2000;
  constexpr std::size_t kPeak = 654'321;
  std::vector<double> values(kRows, 1.0);
  values[kPeak] = 1.001;
  values[7] = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::span<const double>> seen{values};
  const auto rows = ThinnedRows(kRows, seen, {}, kMost);
  EXPECT_LE(rows.size(), kMost);
  EXPECT_EQ(rows.front(), 0u);
  EXPECT_EQ(rows.back(), kRows - 1);
  EXPECT_TRUE(std::is_sorted(rows.begin(), rows.end()));
  EXPECT_TRUE(std::binary_search(rows.begin(), rows.end(), kPeak));
}

TEST(ThinnedRows, KeepEveryRowRightAfterTheStepsOfACurrent) {
  constexpr std::size_t kRows = 100'000;
  constexpr std::size_t kStep = 50'000;
  std::vector<double> current_A(kRows, 0.0);
  std::fill(current_A.begin() + kStep, current_A.end(), 2.0);
  const std::vector<std::span<const double>> seen{current_A};
  const auto rows = ThinnedRows(kRows, seen, current_A, 1000);
  constexpr std::size_t kSeen = 50;
  for (std::size_t row = kStep - 5; row < kStep + kSeen; ++row)
    EXPECT_TRUE(std::binary_search(rows.begin(), rows.end(), row)) << row;
}

TEST(RowsOfPage, GiveLongLogsWhatShortOnesLeave) {
  const std::vector<std::size_t> rows{100, 4'700'000, 2'200'000};
  const auto kept = RowsOfPage(rows, 4);
  EXPECT_EQ(kept[0], 100u);
  EXPECT_LE(std::max(kept[1], kept[2]) - std::min(kept[1], kept[2]), 1u);  // of an odd sum
  EXPECT_GT(kept[1], 10'000u);
  // 8 bytes for the time and 4 for each column; base64 makes four of three: below 2 MB with the
  // scripts.
  const std::size_t all = std::accumulate(kept.begin(), kept.end(), std::size_t{0});
  EXPECT_LT(all * (8 + 4 * 4) * 4 / 3, 1'600'000u);
}

TEST(RowsOfPage, NeverGiveNothing) {
  const std::vector<std::size_t> rows(2000, 100'000);
  for (const std::size_t kept : RowsOfPage(rows, 4)) EXPECT_GE(kept, 200u);
}

TEST(ShownSummary, HasStandardErrorsForTheCovariance) {
  const Json summary = {{"command", "identify"},
                        {"cell",
                         {{"run", {{"version", "1"}, {"metrics", {{"large", 1}}}}},
                          {"uncertainty",
                           {{"parameters", {"alpha", "beta"}},
                            {"covariance", {{4.0, 0.0}, {0.0, 0.25}}},
                            {"degrees_of_freedom", 1e9}}}}}};
  const Json shown = ShownSummary(summary);
  EXPECT_FALSE(shown["cell"]["run"].contains("metrics"));
  const Json& uncertainty = shown["cell"]["uncertainty"];
  EXPECT_FALSE(uncertainty.contains("covariance"));
  EXPECT_EQ(uncertainty["standard_errors"], Json({2.0, 0.5}));
  constexpr double kNormal = 1.959963984540054;  // of the normal distribution, at 97.5 %
  EXPECT_NEAR(uncertainty["reach_95"].get<double>(), kNormal, 1e-6);
  EXPECT_EQ(ShownSummary({{"cells", {summary}}})["cells"][0], shown);
}

TEST(ShownSummary, LeavesWhatIsNoCellAsItIs) {
  for (const char* text : {R"({"cell": 3})",
                           R"({"cells": {"a": 1}})",
                           R"([1, 2])",
                           "null",
                           R"({"cell": {"uncertainty": {"covariance": "none"}}})",
                           R"({"cells": [1, {"cell": null}]})"}) {
    const Json summary = Json::parse(text);
    EXPECT_EQ(ShownSummary(summary), summary) << text;
  }
}

TEST(ShownSummary, HasNoErrorForABrokenCovariance) {
  const Json summary = {
      {"cell", {{"uncertainty", {{"parameters", {"a", "b"}}, {"covariance", {{-1.0}, {1.0}}}}}}}};
  const Json shown = ShownSummary(summary);
  EXPECT_EQ(shown["cell"]["uncertainty"]["standard_errors"], Json({nullptr, nullptr}));
  EXPECT_TRUE(shown["cell"]["uncertainty"]["reach_95"].is_null());
}

TEST(ReportPage, EscapesWhatABrowserWouldTakeForMarkup) {
  if (!CanReport()) GTEST_SKIP() << "built without reports";
  ReportResult result{{{"command", "validate"}, {"logs", Json::array()}}, {}, {}, ""};
  result.series.push_back({.kind = "log", .name = "</script><script>alert(1)</script><!--.csv"});
  const std::string page = ReportPage({&result, 1});
  EXPECT_EQ(page.find("<script>alert"), page.npos);
  EXPECT_EQ(page.find("<!--.csv"), page.npos);
  EXPECT_NE(page.find("\\u003c/script>\\u003cscript>alert(1)"), page.npos);
}

}  // namespace
}  // namespace lipoid
