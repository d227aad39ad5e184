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
#include "model/core/foreign_text.h"
#include "model/core/nearest_name.h"
#include "model/core/structured_text.h"

namespace lipoid {
namespace {

using structured_text::PositionOfByte;

// "/key", escaped as JSON pointers are.
std::string PointerOfKey(const std::string& key) {
  return (Json::json_pointer() / key).to_string();
}

// What nlohmann's parser meets, with the byte where each key and each value starts: the parser
// tells its events in the order of the text but not where, and all that lies between them is white
// space, commas and colons.
class Tokens : public nlohmann::json_sax<Json> {
 public:
  Tokens(std::string_view text, const std::string& file) : text_(text), file_(file) {
    if (text.substr(0, 3) == "\xEF\xBB\xBF") next_ = 3;
  }

  /// False where the text is not read to its end.
  bool Read() { return Json::sax_parse(text_.begin(), text_.end(), this); }

  bool null() override { return Value(Next(), Json()); }
  bool boolean(bool value) override { return Value(Next(), value); }
  bool number_integer(number_integer_t value) override { return Value(Next(), value); }
  bool number_unsigned(number_unsigned_t value) override { return Value(Next(), value); }
  bool number_float(number_float_t value, const string_t&) override { return Value(Next(), value); }
  bool string(string_t& value) override { return Value(Next(), std::move(value)); }
  bool binary(binary_t&) override { return false; }  // JSON has none
  bool start_object(std::size_t) override { return Enter(Next(), false); }
  bool start_array(std::size_t) override { return Enter(Next(), true); }
  bool end_object() override {
    Next();
    return Leave();
  }
  bool end_array() override {
    Next();
    return Leave();
  }
  bool key(string_t& name) override { return Key(Next(), name); }

 protected:
  // Each returns whether to go on.
  virtual bool Value(std::size_t byte, Json value) = 0;
  virtual bool Enter(std::size_t byte, bool list) = 0;
  virtual bool Leave() = 0;
  virtual bool Key(std::size_t byte, const std::string& name) = 0;

  // Where the next token starts.
  std::size_t Next() {
    const std::size_t start = std::min(text_.find_first_not_of(" \t\r\n,:", next_), text_.size());
    next_ = start;
    const char first = start < text_.size() ? text_[start] : ' ';
    if (first == '"') {
      for (++next_; next_ < text_.size() && text_[next_] != '"'; ++next_)
        next_ += text_[next_] == '\\' ? 1 : 0;
      ++next_;
    } else if (std::strchr("[]{}", first) != nullptr) {
      ++next_;
    } else {
      next_ = std::min(text_.find_first_of(" \t\r\n,]}", next_), text_.size());
    }
    return start;
  }

  std::string_view text_;
  const std::string& file_;

 private:
  std::size_t next_ = 0;
};

// Builds the document. LoadError for what is no JSON, for a repeated key and for too much of
// anything.
class Builder : public Tokens {
 public:
  Builder(std::string_view text, const std::string& file)
      : Tokens(text, file), budget_(text, file) {}

  Json Build() {
    Read();
    return std::move(whole_);
  }

  bool parse_error(std::size_t position,
                   const std::string&,
                   const nlohmann::detail::exception& error) override {
    std::string what = error.what();
    constexpr int kNumberOverflow = 406;
    if (error.id == kNumberOverflow) {  // its text ends before what was read
      const std::size_t start = Next();
      const std::size_t end = std::min(text_.find_first_of(" \t\r\n,]}", start), text_.size());
      throw LoadError(PositionOfByte(file_, text_, start),
                      fmt::format("expected a number that a double can hold, found {}",
                                  ForeignText(text_.substr(start, end - start))));
    }
    if (const auto sentence = what.find("syntax error"); sentence != std::string::npos)
      what = what.substr(sentence);
    throw LoadError(PositionOfByte(file_, text_, position == 0 ? 0 : position - 1),
                    fmt::format("expected JSON, found a {}", ForeignText(what)));
  }

 private:
  struct Level {
    bool list = false;
    std::string key;  // of the value that comes
    Json::array_t items = {};
    Json::object_t::Container members = {};
    std::set<std::string> keys = {};
  };

  bool Value(std::size_t byte, Json value) override {
    budget_.Value(byte);
    Add(std::move(value));
    return true;
  }
  bool Enter(std::size_t byte, bool list) override {
    budget_.Enter(byte);
    levels_.push_back({.list = list, .key = ""});
    return true;
  }
  bool Leave() override {
    budget_.Leave();
    Level level = std::move(levels_.back());
    levels_.pop_back();
    if (level.list) {
      Add(Json(std::move(level.items)));
    } else {
      Json::object_t object;
      static_cast<Json::object_t::Container&>(object) = std::move(level.members);
      Add(Json(std::move(object)));
    }
    return true;
  }
  bool Key(std::size_t byte, const std::string& name) override {
    budget_.Key(byte);
    if (!levels_.back().keys.insert(name).second) {
      throw LoadError(PositionOfByte(file_, text_, byte),
                      fmt::format("expected every key once, found '{}' again", ForeignText(name)));
    }
    levels_.back().key = name;
    return true;
  }

  // Without a search for the key, which is not there yet: a table of many keys is read in their
  // order.
  void Add(Json value) {
    if (levels_.empty()) {
      whole_ = std::move(value);
    } else if (levels_.back().list) {
      levels_.back().items.push_back(std::move(value));
    } else {
      levels_.back().members.emplace_back(std::move(levels_.back().key), std::move(value));
    }
  }

  structured_text::Budget budget_;
  std::vector<Level> levels_;
  Json whole_;
};

// Finds where the value with a pointer starts, or its key.
class Locator : public Tokens {
 public:
  Locator(std::string_view text, const std::string& file, const std::string& wanted, bool key)
      : Tokens(text, file), wanted_(wanted), wanted_key_(key) {}

  std::size_t Find() {
    Read();
    return found_;
  }

  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override {
    return false;  // the text that was parsed had none
  }

 private:
  struct Level {
    bool list = false;
    std::size_t index = 0;
    std::size_t pointer_bytes = 0;
  };

  bool Value(std::size_t byte, Json) override { return Item(byte) && Done(); }
  bool Enter(std::size_t byte, bool list) override {
    if (!Item(byte)) return false;
    levels_.push_back({list, 0, pointer_.size()});
    return true;
  }
  bool Leave() override {
    levels_.pop_back();
    return Done();
  }
  bool Key(std::size_t byte, const std::string& name) override {
    pointer_.resize(levels_.back().pointer_bytes);
    pointer_ += PointerOfKey(name);
    return !wanted_key_ || !IsIt(byte);
  }

  // A value begins: a list gives it its number.
  bool Item(std::size_t byte) {
    if (!levels_.empty() && levels_.back().list) {
      pointer_.resize(levels_.back().pointer_bytes);
      pointer_ += fmt::format("/{}", levels_.back().index++);
    }
    return wanted_key_ || !IsIt(byte);
  }
  // A value ended.
  bool Done() {
    pointer_.resize(levels_.empty() ? 0 : levels_.back().pointer_bytes);
    return true;
  }
  bool IsIt(std::size_t byte) {
    if (pointer_ != wanted_) return false;
    found_ = byte;
    return true;
  }

  const std::string& wanted_;
  bool wanted_key_;
  std::size_t found_ = 0;
  std::string pointer_;
  std::vector<Level> levels_;
};

std::string Describe(const Json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return fmt::format("a list of {}", value.size());
  return ForeignText(value.dump(-1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace

std::string ReadTextFile(const std::string& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) {
    throw LoadError(NoFile(file),
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
  // No more than one byte too many: /dev/zero has no end.
  std::string text;
  std::vector<char> buffer(std::size_t{1} << 16);
  for (std::size_t got = 0;
       text.size() <= structured_text::kMostBytes &&
       (got = std::fread(buffer.data(), 1, buffer.size(), stream.get())) > 0;) {
    text.append(buffer.data(), got);
  }
  if (text.size() > structured_text::kMostBytes) structured_text::CheckText(text, file);
  if (std::ferror(stream.get()) != 0) {
    throw LoadError({file},
                    fmt::format("expected a readable file, found one that cannot be read ({})",
                                std::strerror(errno)));
  }
  return text;
}

std::string ReadTextFileOr(const std::string& name_or_file,
                           std::string_view expected,
                           const std::vector<std::string>& names) {
  struct stat status {};
  const bool looks_like_file = name_or_file.find_first_of("./") != std::string::npos;
  if (!looks_like_file && ::stat(name_or_file.c_str(), &status) != 0) {
    const std::string nearest = DidYouMean(name_or_file, names);
    throw LoadError(NoFile(name_or_file),
                    fmt::format("expected {} ({}), found neither{}{}",
                                expected,
                                fmt::join(names, ", "),
                                nearest.empty() ? "" : ".",
                                nearest));
  }
  return ReadTextFile(name_or_file);
}

Json NumberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json ParseJson(std::string_view text, const std::string& file) {
  structured_text::CheckText(text, file);
  return Builder(text, file).Build();
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

std::vector<double> JsonReader::Increasing(double lo, double hi) const {
  auto numbers = Numbers(lo, hi);
  for (std::size_t k = 1; k < numbers.size(); ++k) {
    if (!(numbers[k] > numbers[k - 1])) Item(k).Fail("a number greater than the one before");
  }
  return numbers;
}

void JsonReader::OnlyKeys(std::initializer_list<std::string_view> known) const {
  if (!value_->is_object()) Fail("an object");
  for (const auto& [key, unused] : value_->items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const std::string pointer = pointer_ + PointerOfKey(key);
    throw LoadError(PositionOfByte(*file_, text_, Locator(text_, *file_, pointer, true).Find()),
                    fmt::format("{}: expected one of the keys {}, found '{}'{}",
                                ForeignText(pointer),
                                fmt::join(known, ", "),
                                ForeignText(key),
                                NearKey(key, {known.begin(), known.end()})));
  }
}

void JsonReader::Fail(std::string_view expected) const {
  FailWith(fmt::format("expected {}, found {}", expected, Describe(*value_)));
}

void JsonReader::FailWith(std::string_view message) const {
  throw LoadError(PositionOfByte(*file_, text_, Locator(text_, *file_, pointer_, false).Find()),
                  fmt::format("{}: {}", pointer_.empty() ? "/" : ForeignText(pointer_), message));
}

}  // namespace lipoid
