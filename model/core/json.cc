#include "model/core/json.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <set>

#include "model/core/errors.h"

namespace lipoid {
namespace {

SourcePosition PositionOfByte(const std::string& file, std::string_view text, std::size_t byte) {
  SourcePosition position{file, 1, 1};
  byte = std::min(byte, text.size());
  for (std::size_t k = 0; k < byte; ++k) {
    if (text[k] == '\n') {
      ++position.line;
      position.column = 1;
    } else {
      ++position.column;
    }
  }
  return position;
}

// Finds where each value starts, by a second pass over the same text: nlohmann does not keep positions.
// Returns the byte at which the value with this pointer starts, or 0.
std::size_t ByteOfPointer(std::string_view text, const std::string& wanted) {
  struct Level {
    bool array = false;
    std::size_t index = 0;
    std::string key;
  };
  std::vector<Level> levels;
  const auto pointer = [&] {
    std::string p;
    for (const auto& level : levels) p += '/' + (level.array ? std::to_string(level.index) : level.key);
    return p;
  };
  bool expect_key = false;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const char c = text[k];
    if (c == ' ' || c == '\n' || c == '\t' || c == '\r' || c == ':') continue;
    if (c == ',') {
      if (!levels.empty() && levels.back().array) ++levels.back().index;
      expect_key = !levels.empty() && !levels.back().array;
      continue;
    }
    if (c == '}' || c == ']') {
      if (!levels.empty()) levels.pop_back();
      expect_key = false;
      continue;
    }
    if (c == '"') {
      std::size_t end = k + 1;
      while (end < text.size() && text[end] != '"') end += text[end] == '\\' ? 2 : 1;
      if (expect_key) {
        levels.back().key = std::string(text.substr(k + 1, end - k - 1));
        expect_key = false;
      } else if (pointer() == wanted) {
        return k;
      }
      k = end;
      continue;
    }
    if (pointer() == wanted) return k;
    if (c == '{' || c == '[') {
      levels.push_back({c == '[', 0, ""});
      expect_key = c == '{';
      continue;
    }
    while (k + 1 < text.size() && std::strchr(",]} \n\t\r", text[k + 1]) == nullptr) ++k;
  }
  return 0;
}

std::string Describe(const Json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return fmt::format("a list of {}", value.size());
  return value.dump();
}

}  // namespace

std::string ReadTextFile(const std::string& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) {
    throw LoadError({file}, fmt::format("expected a readable file, found none ({})", std::strerror(errno)));
  }
  if (S_ISDIR(status.st_mode)) throw LoadError({file}, "expected a file, found a folder");
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "rb"), &std::fclose);
  if (!stream) {
    throw LoadError({file}, fmt::format("expected a readable file, found one that cannot be opened ({})",
                                        std::strerror(errno)));
  }
  std::string text;
  char buffer[1 << 16];
  for (std::size_t got = 0; (got = std::fread(buffer, 1, sizeof buffer, stream.get())) > 0;) {
    text.append(buffer, got);
  }
  return text;
}

Json ParseJson(std::string_view text, const std::string& file) {
  std::vector<std::set<std::string>> keys;  // of the objects that are open
  std::string repeated;
  const auto watch = [&](int, nlohmann::detail::parse_event_t event, Json& parsed) {
    using Event = nlohmann::detail::parse_event_t;
    if (event == Event::object_start) keys.emplace_back();
    if (event == Event::object_end) keys.pop_back();
    if (event == Event::key && repeated.empty() && !keys.back().insert(parsed.get<std::string>()).second) {
      repeated = parsed.get<std::string>();
    }
    return true;
  };
  Json document;
  try {
    document = Json::parse(text.begin(), text.end(), watch);
  } catch (const nlohmann::json::parse_error& error) {
    std::string what = error.what();
    if (const auto colon = what.find("syntax error"); colon != std::string::npos) what = what.substr(colon);
    throw LoadError(PositionOfByte(file, text, error.byte == 0 ? 0 : error.byte - 1),
                    fmt::format("expected JSON, found a {}", what));
  }
  if (!repeated.empty()) {
    const auto quoted = '"' + repeated + '"';
    const auto first = text.find(quoted);
    throw LoadError(PositionOfByte(file, text, text.find(quoted, first + 1)),
                    fmt::format("expected every key once, found '{}' again", repeated));
  }
  return document;
}

JsonReader::JsonReader(const Json& document, const std::string& file, std::string_view text)
    : value_(&document), file_(&file), text_(text) {}

JsonReader::JsonReader(const Json& value, const JsonReader& parent, std::string pointer)
    : value_(&value), file_(parent.file_), text_(parent.text_), pointer_(std::move(pointer)) {}

JsonReader JsonReader::At(std::string_view key) const {
  auto member = Find(key);
  if (!member) Fail(fmt::format("an object with the key '{}'", key));
  return *member;
}

std::optional<JsonReader> JsonReader::Find(std::string_view key) const {
  if (!value_->is_object()) Fail("an object");
  const auto found = value_->find(std::string(key));
  if (found == value_->end()) return std::nullopt;
  return JsonReader(*found, *this, fmt::format("{}/{}", pointer_, key));
}

JsonReader JsonReader::Item(std::size_t index) const {
  return JsonReader(value_->at(index), *this, fmt::format("{}/{}", pointer_, index));
}

std::size_t JsonReader::Size() const {
  if (!value_->is_array()) Fail("a list");
  return value_->size();
}

double JsonReader::Number(double lo, double hi) const {
  if (!value_->is_number()) Fail("a number");
  const auto number = value_->get<double>();
  if (!std::isfinite(number) || number < lo || number > hi) {
    Fail(std::isinf(hi) ? fmt::format("a number of at least {}", lo)
                        : fmt::format("a number from {} to {}", lo, hi));
  }
  return number;
}

int JsonReader::Integer(int lo, int hi) const {
  if (!value_->is_number_integer()) Fail("a whole number");
  const auto number = value_->get<double>();
  if (number < lo || number > hi) Fail(fmt::format("a whole number from {} to {}", lo, hi));
  return value_->get<int>();
}

bool JsonReader::Boolean() const {
  if (!value_->is_boolean()) Fail("true or false");
  return value_->get<bool>();
}

std::string JsonReader::Text() const {
  if (!value_->is_string()) Fail("a text");
  return value_->get<std::string>();
}

std::vector<double> JsonReader::Numbers(double lo, double hi) const {
  std::vector<double> numbers(Size());
  for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k] = Item(k).Number(lo, hi);
  return numbers;
}

void JsonReader::OnlyKeys(std::initializer_list<std::string_view> known) const {
  if (!value_->is_object()) Fail("an object");
  for (const auto& [key, unused] : value_->items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    std::string list;
    for (const auto name : known) list += fmt::format("{}{}", list.empty() ? "" : ", ", name);
    JsonReader(unused, *this, fmt::format("{}/{}", pointer_, key))
        .FailWith(fmt::format("expected one of the keys {}, found '{}'", list, key));
  }
}

void JsonReader::Fail(std::string_view expected) const {
  FailWith(fmt::format("expected {}, found {}", expected, Describe(*value_)));
}

void JsonReader::FailWith(std::string_view message) const {
  throw LoadError(PositionOfByte(*file_, text_, ByteOfPointer(text_, pointer_)),
                  fmt::format("{}: {}", pointer_.empty() ? "/" : pointer_, message));
}

}  // namespace lipoid
