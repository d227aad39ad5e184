#include "identify/logs/csv/times.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "identify/logs/log.h"
#include "model/core/text_cells.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

TEST(Times, DurationsAndDates) {
  double seconds = 0.0;
  EXPECT_TRUE(ParseDuration("  0d 00:00:01.5", '.', seconds) ||
              ParseDuration(Trimmed("  0d 00:00:01.5"), '.', seconds));
  EXPECT_EQ(seconds, 1.5);
  EXPECT_TRUE(ParseDuration("2d 03:04:05", '.', seconds));
  EXPECT_EQ(seconds, 2 * 86400 + 3 * 3600 + 4 * 60 + 5);
  EXPECT_TRUE(ParseDuration("75:24:59.326", '.', seconds));
  EXPECT_EQ(seconds, 271499.326);
  EXPECT_TRUE(ParseDuration("00:01:0,25", ',', seconds));
  EXPECT_EQ(seconds, 60.25);
  for (const char* wrong : {"",
                            "1:2",
                            "00:60:00",
                            "00:00:60",
                            "1:2:3:4",
                            "x",
                            "00:00:-1",
                            "d 1:2:3",
                            "00:00:1e1",
                            "-1:00:00"}) {
    EXPECT_FALSE(ParseDuration(wrong, '.', seconds)) << wrong;
  }
  // Days since 1970 by `date -u -d ... +%s` divided by 86400.
  DateTime date;
  for (const char* text : {"2021-03-26 17:01:33",
                           "2021/03/26T17:01:33",
                           "26.03.2021 17:01:33",
                           "03/26/2021 5:01:33 PM",
                           "26-Mar-21 5:01:33 pm",
                           "26-MAR-2021 17:01:33Z",
                           "20210326170133",
                           "20210326 170133.0",
                           "20210326T180133+0100"}) {
    EXPECT_TRUE(ParseDateTime(text, DateOrder::kMonthFirst, '.', date)) << text;
    EXPECT_EQ(date.days, 18712) << text;
    EXPECT_EQ(date.second_of_day, 61293.0) << text;
  }
  EXPECT_TRUE(ParseDateTime("04/03/2021 12:00:00 AM", DateOrder::kDayFirst, '.', date));
  EXPECT_EQ(date.days, 18690);
  EXPECT_EQ(date.second_of_day, 0.0);
  for (const char* wrong : {"03/04/2021 12:00:00",
                            "2021-13-01 00:00:00",
                            "2021-02-29 00:00:00",
                            "2021-01-01",
                            "2021-01-01 24:00:00",
                            "2021-01-01 13:00:00 PM",
                            "2021-257-01 00:00:00",
                            "20211326170133",
                            "20210326170160",
                            "2021032617013",
                            "202103261701334",
                            "20210326",
                            "20210326250133",
                            "20210326170133e1",
                            "18990326170133"}) {
    EXPECT_FALSE(ParseDateTime(wrong, DateOrder::kYearFirst, '.', date)) << wrong;
  }
}

TEST(Times, AreThoseOfTheirZone) {
  DateTime date;
  const auto seconds = [&](const char* text) {
    EXPECT_TRUE(ParseDateTime(text, DateOrder::kYearFirst, '.', date)) << text;
    return static_cast<double>(date.days) * 86400.0 + date.second_of_day;
  };
  // `date -u -d "2021-03-26 17:01:33" +%s`
  for (const char* text : {"2021-03-26 17:01:33",
                           "2021-03-26T17:01:33Z",
                           "2021-03-26 17:01:33 UTC",
                           "2021-03-26 17:01:33 GMT",
                           "2021-03-26T18:01:33+01:00",
                           "2021-03-26 18:01:33 +0100",
                           "2021-03-26 18:01:33+01",
                           "2021-03-27T00:31:33+07:30",
                           "2021-03-26T12:01:33-0500",
                           "2021-03-26 12:01:33.000-05:00"}) {
    EXPECT_EQ(seconds(text), 1616778093.0) << text;
  }
  for (const char* wrong : {"2021-03-26 17:01:33+",
                            "2021-03-26 17:01:33+15:00",
                            "2021-03-26 17:01:33+01:60",
                            "2021-03-26 17:01:33+01:",
                            "2021-03-26 17:01:33+01:00:00",
                            "2021-03-26 17:01:33 CET",
                            "2021-03-26 17:01:-33",
                            "2021-03-26 17:01:33e-5",
                            "2021-03-26 +01:00"}) {
    EXPECT_FALSE(ParseDateTime(wrong, DateOrder::kYearFirst, '.', date)) << wrong;
  }
}

struct DatesThatSay {
  std::vector<const char*> text;
  std::vector<double> seconds;
  std::optional<DateOrder> order;
};

// Midnight, a month's end, a number above 12 at last; a day that is the same in both orders.
TEST(Times, DatesSayTheirOrderThemselves) {
  constexpr double kDay_s = 86400.0;
  const DatesThatSay cases[] = {
      {{"03/04/2024 10:00:00", "03/04/2024 10:00:01.5"}, {0.0, 1.5}, std::nullopt},
      {{"03/04/2024 23:59:59", "03/05/2024 00:00:00"}, {0.0, 1.0}, DateOrder::kMonthFirst},
      {{"03/04/2024 23:59:59", "04/04/2024 00:00:00"}, {0.0, 1.0}, DateOrder::kDayFirst},
      {{"30/04/2024 23:59:59", "01/05/2024 00:00:00"}, {0.0, 1.0}, DateOrder::kDayFirst},
      {{"04/30/2024 11:59:59 PM", "05/01/2024 12:00:00 AM"}, {0.0, 1.0}, DateOrder::kMonthFirst},
      {{"12/12/2024 00:00:00", "13/12/2024 00:00:00"}, {0.0, kDay_s}, DateOrder::kDayFirst},
      {{"12/12/2024 00:00:00", "12/13/2024 00:00:00"}, {0.0, kDay_s}, DateOrder::kMonthFirst},
      {{"12/31/2024 23:00:00", "01/01/2025 00:00:00"}, {0.0, 3600.0}, DateOrder::kMonthFirst},
      {{"05-06-2024 00:00:00", "05-06-2024 00:00:01", "05-08-2024 00:00:00"},
       {0.0, 1.0, 2.0 * kDay_s},
       DateOrder::kMonthFirst},
      {{"24/03/04 23:59:59", "24/03/05 00:00:00"}, {0.0, 1.0}, DateOrder::kShortYearFirst},
      {{"04/03/24 23:59:59", "05/03/24 00:00:00"}, {0.0, 1.0}, DateOrder::kDayFirst},
      {{"03/04/24 23:59:59", "03/05/24 00:00:00"}, {0.0, 1.0}, DateOrder::kMonthFirst},
      {{"24/03/04 10:00:00", "24/03/04 10:00:01"}, {0.0, 1.0}, std::nullopt},
      {{"2024-04-03 10:00:00", "2024-04-04 10:00:00"}, {0.0, kDay_s}, std::nullopt}};
  for (const DatesThatSay& c : cases) {
    DateColumn dates(DateOrder::kYearFirst);
    for (std::size_t k = 0; k < c.text.size(); ++k) {
      double seconds = -1.0;
      EXPECT_TRUE(dates.Seconds(c.text[k], '.', seconds)) << c.text[k];
      EXPECT_EQ(seconds, c.seconds[k]) << c.text[k];
    }
    EXPECT_EQ(dates.found(), c.order) << c.text.front();
  }
  double seconds = 0.0;
  EXPECT_FALSE(DateColumn(DateOrder::kYearFirst).Seconds("13/13/2024 00:00:00", '.', seconds));
  // Where the format says it, the dates are not asked.
  DateColumn known(DateOrder::kMonthFirst);
  EXPECT_TRUE(known.Seconds("03/04/2024 00:00:00", '.', seconds));
  EXPECT_TRUE(known.Seconds("04/04/2024 00:00:00", '.', seconds));
  EXPECT_EQ(seconds, 31.0 * kDay_s);
  EXPECT_EQ(known.found(), std::nullopt);
}

// A log over midnight as Excel of the United States writes it, and as pandas does over the end of summer time.
TEST(Times, LogsOfDatesAreReadAndSayTheOrder) {
  const auto log_of = [](const std::vector<const char*>& times) {
    std::string text = "Date Time,Current (A),Voltage (V)\n";
    const double current_A[] = {0.0, 1.0, 1.0, 0.0};
    const double voltage_V[] = {4.1, 3.9, 3.8, 4.0};
    for (std::size_t k = 0; k < times.size(); ++k)
      text += std::string(times[k]) + "," + std::to_string(current_A[k]) + "," +
              std::to_string(voltage_V[k]) + "\n";
    return ReadLogText(text, "log.csv");
  };
  const Log excel = log_of({"04/03/2024 11:59:58 PM",
                            "04/03/2024 11:59:59 PM",
                            "04/04/2024 12:00:00 AM",
                            "04/04/2024 12:00:01 AM"});
  EXPECT_EQ(std::vector<double>(excel.record.time_s.begin(), excel.record.time_s.end()),
            (std::vector<double>{0.0, 1.0, 2.0, 3.0}));
  EXPECT_EQ(excel.report.notes,
            (std::vector<std::string>{
                "dates such as 03/04/2021 are read with the month first, as they say themselves"}));
  const Log pandas = log_of({"2024-10-27 02:59:59+02:00",
                             "2024-10-27 02:00:00+01:00",
                             "2024-10-27 02:00:01+01:00",
                             "2024-10-27 02:00:02+01:00"});
  EXPECT_EQ(std::vector<double>(pandas.record.time_s.begin(), pandas.record.time_s.end()),
            (std::vector<double>{0.0, 1.0, 2.0, 3.0}));
  EXPECT_EQ(
      test::MessageOf<LoadError>([&] {
        static_cast<void>(log_of({"13/13/2024 00:00:00", "13/14/2024 00:00:00"}));
      }),
      "log.csv:1:1: error: expected times in column 'Date Time' as numbers, as durations such as "
      "00:01:02.5 or as dates such as 2021-03-26 17:01:33, found '13/13/2024 00:00:00' in the first row");
}

}  // namespace
}  // namespace lipoid
