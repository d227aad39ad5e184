#include "model/core/options.h"

#include <fmt/ranges.h>

#include <charconv>
#include <cmath>

#include "model/core/errors.h"
#include "model/core/nearest_name.h"

namespace lipoid::options_internal {

std::string FormatRange(const Range& range, bool integral) {
  const bool lower = std::isfinite(range.lo);
  const bool upper = std::isfinite(range.hi);
  if (lower && upper) return fmt::format("{} .. {}", range.lo, range.hi);
  if (lower) return fmt::format("at least {}", range.lo);
  if (upper) return fmt::format("at most {}", range.hi);
  return integral ? "a whole number" : "a number";
}

namespace {

// What to write instead of a number with something behind it, which is a unit, or percent of a share.
std::string Remedy(std::string_view text, const Range& range) {
  double value = std::numeric_limits<double>::quiet_NaN();
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view behind = text.substr(static_cast<std::size_t>(end - text.data()));
  if (error != std::errc{} || behind.empty()) return "";
  constexpr double kPercent = 0.01;
  constexpr double kMostOfAShare = 2.0;
  if (behind == "%" && range.hi <= kMostOfAShare && range.Contains(kPercent * value))
    return fmt::format(": write {:g}", kPercent * value);
  const char first = behind.front();
  const bool letter = (first >= 'a' && first <= 'z') || (first >= 'A' && first <= 'Z');
  const bool in_utf8 = (static_cast<unsigned char>(first) & 0x80U) != 0;  // a degree or micro sign
  return letter || in_utf8 ? ": write the number alone, in the option's own unit" : "";
}

}  // namespace

double ParseDouble(std::string_view name, std::string_view text, const Range& range) {
  double value = std::numeric_limits<double>::quiet_NaN();
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc{} && end == text.data() + text.size();
  // A range without an end means any number, and infinity is none.
  if (!whole || !std::isfinite(value) || !range.Contains(value)) {
    const std::string valid = FormatRange(range, false);
    throw OptionError(fmt::format("option {}: expected {}{}, found '{}'{}",
                                  name,
                                  whole || valid == "a number" ? "" : "a number, ",
                                  valid,
                                  text,
                                  Remedy(text, range)));
  }
  return value;
}

double ParseShare(std::string_view name, std::string_view text, const Range& range) {
  constexpr double kPercent = 0.01;
  if (!text.ends_with('%')) return ParseDouble(name, text, range);
  const double percent = ParseDouble(name, text.substr(0, text.size() - 1), Range{});
  const double share = kPercent * percent;
  if (!range.Contains(share)) {
    throw OptionError(fmt::format("option {}: expected {:g}% .. {:g}%, found '{}'",
                                  name,
                                  range.lo / kPercent,
                                  range.hi / kPercent,
                                  text));
  }
  return share;
}

int ParseInt(std::string_view name, std::string_view text, const Range& range) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !range.Contains(value)) {
    const std::string valid = FormatRange(range, true);
    throw OptionError(fmt::format("option {}: expected {}{}, found '{}'{}",
                                  name,
                                  valid == "a whole number" ? "" : "a whole number, ",
                                  valid,
                                  text,
                                  Remedy(text, range)));
  }
  return value;
}

bool ParseBool(std::string_view name, std::string_view text) {
  if (text == "true" || text == "on" || text == "yes" || text == "1") return true;
  if (text == "false" || text == "off" || text == "no" || text == "0") return false;
  throw OptionError(fmt::format("option {}: expected true or false, found '{}'", name, text));
}

void ThrowUnknownChoice(std::string_view name,
                        std::string_view text,
                        const std::vector<std::string>& choices) {
  throw OptionError(fmt::format("option {}: expected one of {}, found '{}'{}{}",
                                name,
                                fmt::join(choices, ", "),
                                text,
                                Nearest(text, choices).empty() ? "" : ".",
                                DidYouMean(text, choices)));
}

void ThrowUnknownOption(std::string_view name, const std::vector<std::string>& known) {
  throw OptionError(UnknownName("option", name, known));
}

}  // namespace lipoid::options_internal
