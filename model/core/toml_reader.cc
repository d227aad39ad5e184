#include "model/core/toml_reader.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include "model/core/foreign_text.h"
#include "model/core/nearest_name.h"
#include "model/core/structured_text.h"

namespace lipoid {

toml::table ParseToml(const std::string& text, const std::string& file, std::string_view what) {
  structured_text::CheckText(text, file);
  structured_text::CheckToml(text, file);
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    std::string_view description = error.description();
    constexpr std::string_view kPrefix = "Error while parsing ";
    if (description.substr(0, kPrefix.size()) == kPrefix) description.remove_prefix(kPrefix.size());
    const auto& at = error.source().begin;
    throw LoadError({file, at.line, at.column},
                    fmt::format("not {} in TOML: {}", what, ForeignText(description)));
  }
}

void ThrowProblems(std::vector<Diagnostic> problems) {
  if (problems.empty()) return;
  std::stable_sort(problems.begin(), problems.end(), [](const Diagnostic& a, const Diagnostic& b) {
    return std::pair(a.position.line, a.position.column) <
           std::pair(b.position.line, b.position.column);
  });
  throw LoadError(std::move(problems));
}

std::string TomlFloat(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".einf") == std::string::npos) text += ".0";
  return text;
}

std::string TomlText(const std::string& text) {
  const toml::value<std::string> value(text);
  std::ostringstream out;
  out << toml::toml_formatter(value, toml::format_flags::none);
  return out.str();
}

std::string TomlFound(const toml::node& node) {
  if (node.is_table()) return "a table";
  if (node.is_array()) return "an array";
  if (const auto* number = node.as_floating_point()) return TomlFloat(number->get());
  std::ostringstream text;
  node.visit([&](const auto& value) { text << value; });
  return ForeignText(text.str());
}

SourcePosition TomlReader::At(const toml::source_region& source) const {
  return {file_,
          std::max<std::size_t>(source.begin.line, 1),
          std::max<std::size_t>(source.begin.column, 1)};
}

void TomlReader::Problem(SourcePosition position, std::string message) const {
  problems_.push_back({std::move(position), std::move(message)});
}

void TomlReader::Expected(const toml::node& node,
                          std::string_view key,
                          std::string_view expected) const {
  Problem(At(node.source()),
          fmt::format("{}: expected {}, found {}", key, expected, TomlFound(node)));
}

void TomlReader::OnlyKeys(std::span<const std::string_view> known) const {
  for (const auto& [key, value] : table_) {
    if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
    Problem(At(key.source()),
            fmt::format("expected one of the keys {}, found '{}'{}",
                        fmt::join(known, ", "),
                        ForeignText(key.str()),
                        NearKey(key.str(), {known.begin(), known.end()})));
  }
}

bool TomlReader::Text(std::string_view key, std::string& value) const {
  const toml::node* node = Find(key);
  if (node == nullptr) return false;
  const auto* text = node->as_string();
  if (text == nullptr || text->get().empty()) {
    Expected(*node, key, "a text in quotes");
    return false;
  }
  value = text->get();
  return true;
}

bool TomlReader::Number(
    std::string_view key, double lo, double hi, std::string_view expected, double& value) const {
  const toml::node* node = Find(key);
  if (node == nullptr) return false;
  const auto number = node->is_number() ? node->value<double>() : std::nullopt;
  if (!number || !(*number >= lo && *number <= hi)) {  // NaN is outside every range
    Expected(*node, key, expected);
    return false;
  }
  value = *number;
  return true;
}

bool TomlReader::Numbers(std::string_view key,
                         double lo,
                         double hi,
                         std::string_view expected,
                         std::span<double> values) const {
  const toml::node* node = Find(key);
  if (node == nullptr) return false;
  const auto* list = node->as_array();
  if (list == nullptr || list->size() != values.size()) {
    Problem(At(node->source()),
            fmt::format("{}: expected {} numbers, {}, found {}",
                        key,
                        values.size(),
                        expected,
                        list == nullptr ? TomlFound(*node) : fmt::format("{}", list->size())));
    return false;
  }
  bool right = true;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const toml::node& item = (*list)[k];
    const auto number = item.is_number() ? item.value<double>() : std::nullopt;
    if (number && *number >= lo && *number <= hi) {
      values[k] = *number;
    } else {
      Expected(item, key, expected);
      right = false;
    }
  }
  return right;
}

bool TomlReader::Integer(std::string_view key, int lo, int hi, int& value) const {
  const toml::node* node = Find(key);
  if (node == nullptr) return false;
  const auto* number = node->as_integer();
  if (number == nullptr || number->get() < lo || number->get() > hi) {
    Expected(*node, key, fmt::format("an integer from {} to {}", lo, hi));
    return false;
  }
  value = static_cast<int>(number->get());
  return true;
}

bool TomlReader::Integers(std::string_view key, std::vector<int>& values) const {
  const toml::node* node = Find(key);
  if (node == nullptr) return false;
  const auto* list = node->as_array();
  if (list == nullptr || list->empty()) {
    Expected(*node, key, "a list of integers, [1, 2]");
    return false;
  }
  for (const toml::node& item : *list) {
    const auto* number = item.as_integer();
    if (number == nullptr || number->get() < 0 || number->get() > std::numeric_limits<int>::max()) {
      Expected(item, key, "an integer, at least 0");
      return false;
    }
    values.push_back(static_cast<int>(number->get()));
  }
  return true;
}

}  // namespace lipoid
