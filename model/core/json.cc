#include "model/core/json.h"

#include <fmt/ranges.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

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

// "/key", escaped as JSON pointers are.
std::string PointerOfKey(const std::string& key) {
  return (Json::json_pointer() / key).to_string();
}

// Calls visit(pointer, byte, is_key) where each key and each value starts, until it returns true:
// nlohmann does not keep positions. The text is known to be JSON.
template <class Visit>
void WalkTokens(std::string_view text, Visit&& visit) {
  struct Level {
    bool array = false;
    std::size_t index = 0;
    std::string key;  // with its slash
  };
  std::vector<Level> levels;
  const auto pointer = [&] {
    std::string p;
    for (const auto& level : levels) p += level.array ? fmt::format("/{}", level.index) : level.key;
    return p;
  };
  bool expect_key = false;
  for (std::size_t k = text.substr(0, 3) == "\xEF\xBB\xBF" ? 3 : 0; k < text.size(); ++k) {
    const char c = text[k];
    if (c == ' ' || c == '\n' || c == '\t' || c == '\r' || c == ':') continue;
    if (c == ',') {
      if (levels.back().array) ++levels.back().index;
      expect_key = !levels.back().array;
      continue;
    }
    if (c == '}' || c == ']') {
      levels.pop_back();
      expect_key = false;
      continue;
    }
    const std::size_t start = k;
    if (c == '"') {
      for (++k; text[k] != '"'; ++k) k += text[k] == '\\' ? 1 : 0;
    } else if (c != '{' && c != '[') {
      while (k + 1 < text.size() && std::strchr(",]} \n\t\r", text[k + 1]) == nullptr) ++k;
    }
    const bool is_key = std::exchange(expect_key, false);
    if (is_key) {
      levels.back().key =
          PointerOfKey(Json::parse(text.substr(start, k + 1 - start)).get<std::string>());
    }
    if (visit(pointer(), start, is_key)) return;
    if (c == '{' || c == '[') {
      levels.push_back({c == '[', 0, ""});
      expect_key = c == '{';
    }
  }
}

// Where the value with this pointer starts, or its key.
std::size_t ByteOfPointer(std::string_view text, const std::string& wanted, bool key) {
  std::size_t found = 0;
  WalkTokens(text, [&](const std::string& pointer, std::size_t byte, bool is_key) {
    if (is_key != key || pointer != wanted) return false;
    found = byte;
    return true;
  });
  return found;
}

void RefuseRepeatedKeys(std::string_view text, const std::string& file) {
  std::set<std::string> seen;
  WalkTokens(text, [&](const std::string& pointer, std::size_t byte, bool is_key) {
    if (is_key && !seen.insert(pointer).second) {
      throw LoadError(PositionOfByte(file, text, byte),
                      fmt::format("expected every key once, found '{}' again",
                                  Json::json_pointer(pointer).back()));
    }
    return false;
  });
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
    throw LoadError({file},
                    fmt::format("expected a readable file, found none ({})", std::strerror(errno)));
  }
  if (S_ISDIR(status.st_mode)) throw LoadError({file}, "expected a file, found a folder");
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "rb"),
                                                               &std::fclose);
  if (!stream) {
    throw LoadError({file},
                    fmt::format("expected a readable file, found one that cannot be opened ({})",
                                std::strerror(errno)));
  }
  std::string text;
  char buffer[1 << 16];
  for (std::size_t got = 0; (got = std::fread(buffer, 1, sizeof buffer, stream.get())) > 0;) {
    text.append(buffer, got);
  }
  if (std::ferror(stream.get()) != 0) {
    throw LoadError({file},
                    fmt::format("expected a readable file, found one that cannot be read ({})",
                                std::strerror(errno)));
  }
  return text;
}

std::string ReadTextFileOr(const std::string& name_or_file, const std::string& expected) {
  struct stat status {};
  const bool looks_like_file = name_or_file.find_first_of("./") != std::string::npos;
  if (!looks_like_file && ::stat(name_or_file.c_str(), &status) != 0) {
    throw LoadError({name_or_file}, fmt::format("expected {}, found neither", expected));
  }
  return ReadTextFile(name_or_file);
}

Json NumberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json ParseJson(std::string_view text, const std::string& file) {
  Json document;
  try {
    document = Json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    std::string what = error.what();
    if (const auto colon = what.find("syntax error"); colon != std::string::npos)
      what = what.substr(colon);
    throw LoadError(PositionOfByte(file, text, error.byte == 0 ? 0 : error.byte - 1),
                    fmt::format("expected JSON, found a {}", what));
  } catch (const nlohmann::json::out_of_range& error) {
    // "... number overflow parsing '1e999'": the only one that parsing throws; it has no position.
    const std::string what = error.what();
    const auto quote = std::min(what.find('\''), what.size());
    const std::string number = what.substr(quote + 1, what.rfind('\'') - quote - 1);
    throw LoadError(PositionOfByte(file, text, std::min(text.find(number), text.size())),
                    fmt::format("expected a number that a double can hold, found {}", number));
  }
  RefuseRepeatedKeys(text, file);
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
  return JsonReader(*found, *this, pointer_ + PointerOfKey(std::string(key)));
}

JsonReader JsonReader::Item(std::size_t index) const {
  return JsonReader(value_->at(index), *this, fmt::format("{}/{}", pointer_, index));
}

std::size_t JsonReader::Size() const {
  if (!value_->is_array()) Fail("a list");
  return value_->size();
}

bool JsonReader::IsNull() const { return value_->is_null(); }
bool JsonReader::IsObject() const { return value_->is_object(); }
bool JsonReader::IsNumber() const { return value_->is_number(); }

double JsonReader::Number(double lo, double hi) const {
  if (!value_->is_number()) Fail("a number");
  const auto number = value_->get<double>();
  if (!std::isfinite(number) || number < lo || number > hi) {
    // The least positive double as a bound means: above 0.
    const bool above_zero = lo == std::numeric_limits<double>::min();
    const std::string lower = above_zero ? "above 0" : fmt::format("of at least {}", lo);
    Fail(std::isinf(hi) ? fmt::format("a number {}", lower)
         : above_zero   ? fmt::format("a number {} and at most {}", lower, hi)
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
    const std::string pointer = pointer_ + PointerOfKey(key);
    throw LoadError(
        PositionOfByte(*file_, text_, ByteOfPointer(text_, pointer, true)),
        fmt::format(
            "{}: expected one of the keys {}, found '{}'", pointer, fmt::join(known, ", "), key));
  }
}

void JsonReader::Fail(std::string_view expected) const {
  FailWith(fmt::format("expected {}, found {}", expected, Describe(*value_)));
}

void JsonReader::FailWith(std::string_view message) const {
  throw LoadError(PositionOfByte(*file_, text_, ByteOfPointer(text_, pointer_, false)),
                  fmt::format("{}: {}", pointer_.empty() ? "/" : pointer_, message));
}

}  // namespace lipoid
