#include "identify/logs/csv/cells.h"

#include <fast_float/fast_float.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>

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
  }
  if (year > 9999 || month > 12 || day > 31) return false;  // chrono keeps eight bits of a month
  const std::chrono::year_month_day date{std::chrono::year(FullYear(year)),
                                         std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok()) return false;
  days = std::chrono::sys_days(date).time_since_epoch().count();
  return true;
}

}  // namespace

std::string_view Trimmed(std::string_view text) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty()) {
    if (is_blank(text.front())) {
      text.remove_prefix(1);
    } else if (text.starts_with("\xC2\xA0")) {
      text.remove_prefix(2);
    } else {
      break;
    }
  }
  while (!text.empty()) {
    if (is_blank(text.back())) {
      text.remove_suffix(1);
    } else if (text.ends_with("\xC2\xA0")) {
      text.remove_suffix(2);
    } else {
      break;
    }
  }
  return text;
}

std::string LowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

bool ParseNumber(std::string_view text, char decimal, double& value) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  if (text.empty()) return false;
  const auto* const end = text.data() + text.size();
  const fast_float::parse_options options(fast_float::chars_format::general, decimal);
  const auto result = fast_float::from_chars_advanced(text.data(), end, value, options);
  return result.ec == std::errc() && result.ptr == end;
}

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
  if (!TakeDate(text, order, value.days)) return false;
  if (text.empty() || (text.front() != ' ' && text.front() != 'T' && text.front() != '\t'))
    return false;
  text = Trimmed(text.substr(1));
  enum class Half { kNone, kMorning, kAfternoon } half = Half::kNone;
  if (text.size() > 2) {
    const std::string end = LowerCase(text.substr(text.size() - 2));
    if (end == "am") half = Half::kMorning;
    if (end == "pm") half = Half::kAfternoon;
    if (half != Half::kNone) text = Trimmed(text.substr(0, text.size() - 2));
  }
  if (half == Half::kNone && text.ends_with('Z')) text.remove_suffix(1);
  Clock clock;
  if (!ParseClock(text, decimal, clock)) return false;
  if (half != Half::kNone) {
    if (clock.hours < 1 || clock.hours > 12) return false;
    clock.hours = clock.hours % 12 + (half == Half::kAfternoon ? 12 : 0);
  }
  if (clock.hours > 23) return false;
  value.second_of_day = clock.Total(0);
  return true;
}

void SplitLine(std::string_view line, char delimiter, std::vector<TextCell>& cells) {
  cells.clear();
  if (line.ends_with('\r')) line.remove_suffix(1);
  std::size_t begin = 0;
  while (true) {
    std::size_t first = begin;
    while (first < line.size() && line[first] == ' ') ++first;
    if (first < line.size() && line[first] == '"') {
      std::size_t close = first + 1;
      while (close < line.size() &&
             (line[close] != '"' || (close + 1 < line.size() && line[close + 1] == '"'))) {
        close += line[close] == '"' ? 2 : 1;
      }
      auto end = close < line.size() ? line.find(delimiter, close) : line.size();
      if (end == std::string_view::npos) end = line.size();
      const bool nothing_after =
          close < line.size() && Trimmed(line.substr(close + 1, end - close - 1)).empty();
      // A quote that never closes, or text after it, stays in the cell, which then is no number.
      cells.push_back({nothing_after ? Trimmed(line.substr(first + 1, close - first - 1))
                                     : Trimmed(line.substr(first, end - first)),
                       first + 1});
      if (end == line.size()) return;
      begin = end + 1;
      continue;
    }
    const auto end = std::min(line.find(delimiter, begin), line.size());
    const std::string_view text = Trimmed(line.substr(begin, end - begin));
    cells.push_back(
        {text, text.empty() ? begin + 1 : static_cast<std::size_t>(text.data() - line.data()) + 1});
    if (end == line.size()) return;
    begin = end + 1;
  }
}

std::string_view Unwrapped(std::string_view line, char delimiter) {
  const std::string_view text = Trimmed(line);
  if (text.size() < 3 || text.front() != '"' || text.back() != '"') return line;
  const std::string_view inside = text.substr(1, text.size() - 2);
  const bool one_text = inside.find('"') == std::string_view::npos &&
                        inside.find(delimiter) != std::string_view::npos;
  return one_text ? inside : line;
}

}  // namespace lipoid
