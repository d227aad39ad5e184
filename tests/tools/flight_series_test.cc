// Flights as series of a report, whole and thinned.
#include "tools/report/flight_series.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "tools/report/thinned_series.h"

namespace lipoid::test {
namespace {

constexpr std::size_t kPlenty = std::size_t{1} << 30;

// A flight that climbs on a sine, with one row in which the current peaks.
FlightSample SampleAt(std::size_t k, std::size_t peak) {
  FlightSample sample;
  sample.time_s = 0.005 * static_cast<double>(k);
  sample.position_m = {0.0, 0.0, 1.0 + std::sin(0.01 * static_cast<double>(k))};
  sample.battery_A = k == peak ? 40.0 : 3.0;
  sample.battery_V = 3.7 - 1e-6 * static_cast<double>(k);
  sample.soc = std::numeric_limits<double>::quiet_NaN();
  return sample;
}

const std::vector<double>& ColumnOf(const Series& series, const std::string& name) {
  const auto found =
      std::find_if(series.columns.begin(), series.columns.end(), [&](const Series::Column& column) {
        return column.name == name;
      });
  EXPECT_NE(found, series.columns.end()) << name;
  return found->values;
}

TEST(FlightSeries, HasEveryRowWhereThereIsRoom) {
  FlightSeries recorded(4, false);
  for (std::size_t k = 0; k < 1000; ++k) recorded.Row(SampleAt(k, 500));
  const Series series = Thinned(recorded.Take("a.csv"), kPlenty);
  EXPECT_EQ(series.kind, "flight");
  EXPECT_EQ(series.name, "a.csv");
  EXPECT_EQ(series.rows, 1000U);
  const auto& altitude_m = ColumnOf(series, "altitude_m");
  ASSERT_EQ(altitude_m.size(), 1000U);
  EXPECT_EQ(ColumnOf(series, "time_s")[999], 0.005 * 999.0);
  EXPECT_EQ(altitude_m[77], double{static_cast<float>(SampleAt(77, 0).altitude_m())});
  EXPECT_TRUE(std::isnan(ColumnOf(series, "soc")[0]));
}

TEST(FlightSeries, KeepsPeaksOfAFlightThatIsThinned) {
  // More rows than are kept in memory, and a page that holds few of them.
  constexpr std::size_t kRows = 300'000;
  constexpr std::size_t kPeak = 123'457;
  constexpr std::size_t kBytes = 40'000;
  FlightSeries recorded(4, false);
  for (std::size_t k = 0; k < kRows; ++k) recorded.Row(SampleAt(k, kPeak));
  const Series series = Thinned(recorded.Take(""), kBytes);
  EXPECT_EQ(series.rows, kRows);
  const auto& time_s = ColumnOf(series, "time_s");
  // Time, altitude, current and voltage differ from row to row, in base64.
  const double bytes = static_cast<double>(time_s.size()) * (8 + 3 * 4) * 4 / 3;
  EXPECT_LE(bytes, double{kBytes});
  EXPECT_GT(bytes, 0.5 * double{kBytes});
  EXPECT_EQ(time_s.front(), 0.0);
  EXPECT_EQ(time_s.back(), SampleAt(kRows - 1, 0).time_s);
  EXPECT_TRUE(std::is_sorted(time_s.begin(), time_s.end(), std::less_equal<>()));
  const auto& current_A = ColumnOf(series, "battery_A");
  const auto peak = std::max_element(current_A.begin(), current_A.end()) - current_A.begin();
  EXPECT_EQ(current_A[static_cast<std::size_t>(peak)], 40.0);
  EXPECT_EQ(time_s[static_cast<std::size_t>(peak)], SampleAt(kPeak, 0).time_s);
  // All parts of the flight are there alike.
  const auto half = std::lower_bound(time_s.begin(), time_s.end(), time_s.back() / 2);
  const double share = double(half - time_s.begin()) / double(time_s.size());
  EXPECT_NEAR(share, 0.5, 0.05);
}

}  // namespace
}  // namespace lipoid::test
