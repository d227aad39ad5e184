#pragma once

/// @file
/// One declaration of an option serves its default, its range, its help text, `--set name=value`,
/// the JSON of the run record and the table in the docs. A struct of options declares itself by a
/// static Visit:
///
///   struct PulseOptions {
///     int branches = 1;
///     OcvMethod method = OcvMethod::kLinear;
///
///     template <class Self, class Visitor>
///     static void Visit(Self& self, Visitor&& v) {
///       v("branches", self.branches, Range{0, 5}, "number of resistor-capacitor branches");
///       v("method", self.method, Names(), "how v_oc(A) is written");   // an enum lists its names
///     }
///   };
///
/// Members may be bool, int, double, std::string, or an enum E with `OptionNames(E)` returning an
/// array of {value, name} found by argument-dependent lookup. NaN is outside every range. Tests:
/// tests/model/core/options_test.cc.

#include <fmt/format.h>

#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace lipoid {

/// Closed interval of valid values.
struct Range {
  double lo = -std::numeric_limits<double>::infinity();
  double hi = std::numeric_limits<double>::infinity();

  [[nodiscard]] bool Contains(double x) const { return x >= lo && x <= hi; }
};

/// Stands where a Range would, for options whose names say all: enums, booleans and texts.
struct Names {};

/// The same for texts that are numbers with commas between them.
struct Numbers {};

/// What `--help`, `list --options` and the docs say of one option.
/// What an option takes, which not every text of what is valid tells: "1 .. 5" are integers or numbers.
enum class OptionKind { kNumber, kInteger, kTruth, kChoice, kNumbers, kText };

struct OptionDescription {
  std::string name;
  std::string default_text;
  std::string valid;  ///< "0 .. 5", "linear | polynomial", "true | false"
  std::string help;
  OptionKind kind = OptionKind::kText;
};

namespace options_internal {

std::string FormatRange(const Range& range, bool integral);
double ParseDouble(std::string_view name, std::string_view text, const Range& range);
/// A share as a person writes it, 0.2 or 20%.
double ParseShare(std::string_view name, std::string_view text, const Range& range);
int ParseInt(std::string_view name, std::string_view text, const Range& range);
bool ParseBool(std::string_view name, std::string_view text);
[[noreturn]] void ThrowUnknownChoice(std::string_view name,
                                     std::string_view text,
                                     const std::vector<std::string>& choices);
[[noreturn]] void ThrowUnknownOption(std::string_view name, const std::vector<std::string>& known);

template <class E>
std::vector<std::string> ChoiceNames() {
  std::vector<std::string> names;
  for (const auto& [value, name] : OptionNames(E{})) names.emplace_back(name);
  return names;
}

template <class T>
std::string ToText(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    for (const auto& [candidate, name] : OptionNames(T{})) {
      if (candidate == value) return std::string(name);
    }
    return "?";
  } else if constexpr (std::is_same_v<T, bool>) {
    return value ? "true" : "false";
  } else {
    return fmt::format("{}", value);
  }
}

template <class T, class Valid>
void FromText(std::string_view name, std::string_view text, const Valid& valid, T& value) {
  if constexpr (std::is_enum_v<T>) {
    for (const auto& [candidate, choice] : OptionNames(T{})) {
      if (text == choice) {
        value = candidate;
        return;
      }
    }
    ThrowUnknownChoice(name, text, ChoiceNames<T>());
  } else if constexpr (std::is_same_v<T, bool>) {
    value = ParseBool(name, text);
  } else if constexpr (std::is_same_v<T, double>) {
    value = ParseDouble(name, text, valid);
  } else if constexpr (std::is_same_v<T, int>) {
    value = ParseInt(name, text, valid);
  } else {
    value = std::string(text);
  }
}

template <class T, class Valid>
std::string DescribeValid(const Valid& valid) {
  if constexpr (std::is_enum_v<T>) {
    std::string text;
    for (const auto& name : ChoiceNames<T>()) text += (text.empty() ? "" : " | ") + name;
    return text;
  } else if constexpr (std::is_same_v<T, bool>) {
    return "true | false";
  } else if constexpr (std::is_same_v<Valid, Range>) {
    return FormatRange(valid, std::is_same_v<T, int>);
  } else if constexpr (std::is_same_v<Valid, Numbers>) {
    return "numbers";
  } else {
    return "text";
  }
}

template <class T, class Valid>
constexpr OptionKind KindOf() {
  if constexpr (std::is_same_v<Valid, Numbers>) return OptionKind::kNumbers;
  if constexpr (std::is_enum_v<T>) return OptionKind::kChoice;
  if constexpr (std::is_same_v<T, bool>) return OptionKind::kTruth;
  if constexpr (std::is_same_v<T, int>) return OptionKind::kInteger;
  if constexpr (std::is_same_v<T, double>) return OptionKind::kNumber;
  return OptionKind::kText;
}

/// What is told of an option of this value.
template <class T, class Valid>
OptionDescription Describe(std::string_view name,
                           std::string default_text,
                           const Valid& valid,
                           std::string_view help) {
  return {std::string(name),
          std::move(default_text),
          DescribeValid<T>(valid),
          std::string(help),
          KindOf<T, Valid>()};
}

}  // namespace options_internal

/// Every option with its value as text, in the order of declaration.
template <class Options>
[[nodiscard]] std::vector<std::pair<std::string, std::string>> OptionValues(
    const Options& options) {
  std::vector<std::pair<std::string, std::string>> values;
  Options::Visit(options, [&](std::string_view name, const auto& member, const auto&, const char*) {
    values.emplace_back(std::string(name), options_internal::ToText(member));
  });
  return values;
}

/// Name, default, valid values and help of every option of the type.
template <class Options>
[[nodiscard]] std::vector<OptionDescription> DescribeOptions() {
  std::vector<OptionDescription> all;
  const Options defaults{};
  Options::Visit(
      defaults,
      [&](std::string_view name, const auto& member, const auto& valid, const char* help) {
        using T = std::remove_cvref_t<decltype(member)>;
        all.push_back(
            options_internal::Describe<T>(name, options_internal::ToText(member), valid, help));
      });
  return all;
}

/// Sets one option from text. Throws OptionError naming the option, the text and what is valid.
template <class Options>
void SetOption(Options& options, std::string_view name, std::string_view text) {
  bool found = false;
  std::vector<std::string> known;
  Options::Visit(options,
                 [&](std::string_view candidate, auto& member, const auto& valid, const char*) {
                   known.emplace_back(candidate);
                   if (candidate != name) return;
                   found = true;
                   options_internal::FromText(name, text, valid, member);
                 });
  if (!found) options_internal::ThrowUnknownOption(name, known);
}

/// The options as a JSON object: numbers as numbers, enums by name. Include nlohmann/json.hpp to
/// use it.
template <class Json, class Options>
[[nodiscard]] Json OptionsToJson(const Options& options) {
  Json json = Json::object();
  Options::Visit(options, [&](std::string_view name, const auto& member, const auto&, const char*) {
    using T = std::remove_cvref_t<decltype(member)>;
    if constexpr (std::is_enum_v<T>) {
      json[std::string(name)] = options_internal::ToText(member);
    } else {
      json[std::string(name)] = member;
    }
  });
  return json;
}

}  // namespace lipoid
