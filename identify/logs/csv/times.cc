#include "identify/logs/csv/times.h"

#include <array>
#include <charconv>
#include <chrono>
#include <string>

#include "model/core/text_cells.h"

namespace lipoid {
namespace {

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// Takes digits off the front of the text.
bool TakeInteger(std::string_view& text, int& value) {
  if (text.empty() || !IsDigit(text.front())) return false;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc()) return false;
  text.remove_prefix(static_cast<std::size_t>(result.ptr - text.data()));
  return true;
}

bool TakeCharacter(std::string_view& text, char expected) {
  if (text.empty() || text.front() != expected) return false;
  text.remove_prefix(1);
  return true;
}

// hours:minutes:seconds[.fraction], to the end of the text. Hours may be many.
struct Clock {
  int hours = 0;
  int minutes = 0;
  double seconds = 0.0;

  // Whole seconds first: they are exact, and the fraction is rounded once.
  [[nodiscard]] double Total(int days) const {
    return (days * 86400.0 + hours * 3600.0 + minutes * 60.0) + seconds;
  }
};

bool ParseClock(std::string_view text, char decimal, Clock& clock) {
  if (!TakeInteger(text, clock.hours) || !TakeCharacter(text, ':')) return false;
  if (!TakeInteger(text, clock.minutes) || !TakeCharacter(text, ':')) return false;
  if (text.empty() || !IsDigit(text.front()) || text.find_first_of("eE") != std::string_view::npos)
    return false;
  return ParseNumber(text, decimal, clock.seconds) && clock.minutes < 60 && clock.seconds < 60.0;
}

bool TakeMonthName(std::string_view& text, int& month) {
  constexpr std::array<std::string_view, 12> kNames{
      "jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"};
  const std::string start = LowerCase(text.substr(0, 3));
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    if (start != kNames[k]) continue;
    month = static_cast<int>(k) + 1;
    text.remove_prefix(3);
    return true;
  }
  return false;
}

int FullYear(int year) { return year >= 100 ? year : year < 70 ? 2000 + year : 1900 + year; }

// Takes so many digits off the front of the text.
bool TakeDigits(std::string_view& text, std::size_t count, int& value) {
  std::string_view digits = text.substr(0, count);
  if (digits.size() != count || !TakeInteger(digits, value) || !digits.empty()) return false;
  text.remove_prefix(count);
  return true;
}

bool DaysOf(int year, int month, int day, long& days) {
  if (year > 9999 || month > 12 || day > 31) return false;  // chrono keeps eight bits of a month
  const std::chrono::year_month_day date{std::chrono::year(FullYear(year)),
                                         std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok()) return false;
  days = std::chrono::sys_days(date).time_since_epoch().count();
  return true;
}

// Takes the date off the front of the text.
bool TakeDate(std::string_view& text, DateOrder order, long& days) {
  int first = 0;
  int second = 0;
  int third = 0;
  if (!TakeInteger(text, first) || text.empty()) return false;
  const char mark = text.front();
  if (mark != '-' && mark != '/' && mark != '.') return false;
  text.remove_prefix(1);
  const bool named = TakeMonthName(text, second);
  if (!named && !TakeInteger(text, second)) return false;
  if (!TakeCharacter(text, mark) || !TakeInteger(text, third)) return false;

  int year = third;
  int month = first;
  int day = second;
  if (first > 31) {  // 2021-03-26
    year = first;
    month = second;
    day = third;
  } else if (named || mark == '.' || order == DateOrder::kDayFirst) {  // 23-Nov-23, 26.03.2021
    month = second;
    day = first;
  } else if (order == DateOrder::kYearFirst) {
    return false;  // 03/04/2021: March or April?
  } else if (order == DateOrder::kShortYearFirst) {
    year = first;
    month = second;
    day = third;
  }
  return DaysOf(year, month, day, days);
}

// Takes what says the zone off the end of a time of day: Z, UTC, GMT, +01:00, -0500, +09. None is 0.
bool TakeZone(std::string_view& text, int& zone_s) {
  zone_s = 0;
  for (const std::string_view name : {"Z", "UTC", "GMT"}) {
    if (!text.ends_with(name)) continue;
    text = Trimmed(text.substr(0, text.size() - name.size()));
    return true;
  }
  const auto sign = text.find_last_of("+-");
  if (sign == std::string_view::npos) return true;
  std::string_view digits = text.substr(sign + 1);
  int hours = 0;
  int minutes = 0;
  const bool together = digits.size() == 4 && digits.find(':') == std::string_view::npos;
  if (!TakeInteger(digits, hours)) return false;
  if (together) {
    minutes = hours % 100;
    hours /= 100;
  } else if (!digits.empty() && !(TakeCharacter(digits, ':') && TakeInteger(digits, minutes))) {
    return false;
  }
  constexpr int kFarthest_h = 14;
  if (!digits.empty() || hours > kFarthest_h || minutes > 59) return false;
  zone_s = (text[sign] == '-' ? -1 : 1) * (3600 * hours + 60 * minutes);
  text = Trimmed(text.substr(0, sign));
  return true;
}

// 20210326170133, 20210326T170133.5
bool ParseWithoutMarks(std::string_view text, char decimal, DateTime& value) {
  constexpr int kFirstYear = 1900;
  int year = 0;
  int month = 0;
  int day = 0;
  int seconds = 0;
  int zone_s = 0;
  Clock clock;
  if (!TakeDigits(text, 4, year) || !TakeDigits(text, 2, month) || !TakeDigits(text, 2, day) ||
      year < kFirstYear || !DaysOf(year, month, day, value.days))
    return false;
  if (!text.empty() && (text.front() == ' ' || text.front() == 'T')) text.remove_prefix(1);
  if (!TakeZone(text, zone_s) || !TakeDigits(text, 2, clock.hours) ||
      !TakeDigits(text, 2, clock.minutes))
    return false;
  if (std::string_view whole = text; !TakeDigits(whole, 2, seconds) ||
                                     (!whole.empty() && whole.front() != decimal) ||
                                     text.find_first_of("eE") != std::string_view::npos)
    return false;
  if (!ParseNumber(text, decimal, clock.seconds) || clock.hours > 23 || clock.minutes > 59 ||
      clock.seconds >= 60.0)
    return false;
  value.second_of_day = clock.Total(0) - zone_s;
  return true;
}

}  // namespace

bool ParseDuration(std::string_view text, char decimal, double& seconds) {
  int days = 0;
  if (const auto mark = text.find_first_of("dD"); mark != std::string_view::npos) {
    std::string_view count = Trimmed(text.substr(0, mark));
    if (!TakeInteger(count, days) || !count.empty()) return false;
    text = Trimmed(text.substr(mark + 1));
  }
  Clock clock;
  if (!ParseClock(text, decimal, clock)) return false;
  seconds = clock.Total(days);
  return true;
}

bool ParseDateTime(std::string_view text, DateOrder order, char decimal, DateTime& value) {
  if (ParseWithoutMarks(text, decimal, value)) return true;
  if (!TakeDate(text, order, value.days)) return false;
  if (text.empty() || (text.front() != ' ' && text.front() != 'T' && text.front() != '\t'))
    return false;
  text = Trimmed(text.substr(1));
  int zone_s = 0;
  if (!TakeZone(text, zone_s)) return false;
  enum class Half { kNone, kMorning, kAfternoon } half = Half::kNone;
  if (text.size() > 2) {
    const std::string end = LowerCase(text.substr(text.size() - 2));
    if (end == "am") half = Half::kMorning;
    if (end == "pm") half = Half::kAfternoon;
    if (half != Half::kNone) text = Trimmed(text.substr(0, text.size() - 2));
  }
  Clock clock;
  if (!ParseClock(text, decimal, clock)) return false;
  if (half != Half::kNone) {
    if (clock.hours < 1 || clock.hours > 12) return false;
    clock.hours = clock.hours % 12 + (half == Half::kAfternoon ? 12 : 0);
  }
  if (clock.hours > 23) return false;
  value.second_of_day = clock.Total(0) - zone_s;
  return true;
}

bool DateColumn::Seconds(std::string_view text, char decimal, double& seconds) {
  DateTime date;
  if (order_ != DateOrder::kYearFirst) {
    if (!ParseDateTime(text, order_, decimal, date)) return false;
  } else if (!ParseDateTime(text, DateOrder::kYearFirst, decimal, date)) {
    if (!FindOrder(text, decimal, date)) return false;
  }
  if (!first_) first_ = date;
  seconds = static_cast<double>(date.days - first_->days) * 86400.0 +
            (date.second_of_day - first_->second_of_day);
  return true;
}

// 03/04/2024. As long as the day is the first row's, it does not matter which is the month.
bool DateColumn::FindOrder(std::string_view text, char decimal, DateTime& date) {
  const bool is_first = !first_;
  std::array<DateTime, kOrders.size()> read;
  std::optional<long> least;
  std::size_t possible = 0;
  std::size_t taken = 0;
  for (std::size_t k = kOrders.size(); k-- > 0;) {
    std::optional<DateTime>& first = first_by_[k];
    const bool is_date = (is_first || first) && ParseDateTime(text, kOrders[k], decimal, read[k]);
    if (!is_date) {
      first.reset();
      continue;
    }
    if (is_first) first = read[k];
    const long days = read[k].days - first->days;
    // Backwards only where no order leads forwards.
    if (!least || (*least < 0 ? days > *least : days >= 0 && days < *least)) least = days;
  }
  for (std::size_t k = kOrders.size(); k-- > 0;) {
    // The next day is one day away in one order, a month or a year in the others.
    if (first_by_[k] && read[k].days - first_by_[k]->days != *least) first_by_[k].reset();
    if (!first_by_[k]) continue;
    ++possible;
    taken = k;
  }
  if (possible == 0) return false;
  date = read[taken];
  first_ = first_by_[taken];
  found_ = possible == 1;
  if (found_) order_ = kOrders[taken];
  return true;
}

}  // namespace lipoid
