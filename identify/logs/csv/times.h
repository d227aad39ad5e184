#pragma once

/// @file
/// Times as text: durations, and dates with a time of day. No locale; anything that is not wholly what it
/// should be is refused. Tests: tests/identify/logs/csv/times_test.cc.

#include <array>
#include <optional>
#include <string_view>

namespace lipoid {

/// A duration as cyclers write it, in s: [days d] hours:minutes:seconds[.fraction].
[[nodiscard]] bool ParseDuration(std::string_view text, char decimal, double& seconds);

/// How 03/04/2021 is to be read. kYearFirst refuses such a date; kShortYearFirst takes 21/04/03 alone.
enum class DateOrder { kYearFirst, kMonthFirst, kDayFirst, kShortYearFirst };

/// A calendar date with a time of day, kept apart so that no digit of a fraction of a second is
/// lost.
struct DateTime {
  long days = 0;  ///< since 1970-01-01
  double second_of_day = 0.0;
};

/// 2021-03-26 17:01:33.5, 2021/03/26T17:01:33, 20210326170133, 26.03.2021 17:01:33, 23-Nov-23 3:56:11 PM, and
/// 03/26/2021 5:01:33 PM in the given order. What ends with its zone (Z, UTC, +01:00, -0500) becomes UTC:
/// `second_of_day` may then be that of the day before or after.
[[nodiscard]] bool ParseDateTime(std::string_view text,
                                 DateOrder order,
                                 char decimal,
                                 DateTime& value);

/// The dates of one column, counted from the first. Where the order of 03/04/2021 or 21/04/03 is not known, the dates
/// themselves say it: by a number above 12, or at midnight, when the next day is one day away and not a month or a year.
class DateColumn {
 public:
  /// kYearFirst: it is not known.
  explicit DateColumn(DateOrder order) : order_(order) {}

  /// Since the first date, in s. False where the text is no date.
  [[nodiscard]] bool Seconds(std::string_view text, char decimal, double& seconds);

  /// The order, where the dates said it.
  [[nodiscard]] std::optional<DateOrder> found() const {
    return found_ ? std::optional(order_) : std::nullopt;
  }

 private:
  static constexpr std::array kOrders{
      DateOrder::kMonthFirst, DateOrder::kDayFirst, DateOrder::kShortYearFirst};

  bool FindOrder(std::string_view text, char decimal, DateTime& date);

  DateOrder order_;
  bool found_ = false;
  std::optional<DateTime> first_;
  std::array<std::optional<DateTime>, kOrders.size()> first_by_;  // in each order that it may be
};

}  // namespace lipoid
