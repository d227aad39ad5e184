#pragma once

/// @file
/// JSON, strictly: a syntax error or a repeated key has a line and a column, a value of the wrong
/// type has its pointer (/diffusion/beta_per_sqrt_s), an unknown key is an error that lists the
/// known ones. nlohmann alone reads 2.7 into an int, true into a double, and keeps the last of two
/// equal keys. Who only hands JSON on needs no more than this header, which is cheap to compile; who
/// builds or looks into it includes <nlohmann/json.hpp> too. Tests: tests/model/core/json_test.cc.

#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lipoid {

/// Keys keep the order in which they were written.
using Json = nlohmann::ordered_json;

/// Reads a whole file as text; LoadError where it is missing, a folder or unreadable.
[[nodiscard]] std::string ReadTextFile(const std::string& file);

/// The same of something that has a name or stands in a file. Where no file of that name is found
/// and the name does not look like one, the LoadError says what was expected instead: "a cell file
/// or one of the shipped cells (...)", `expected` being "a cell file or one of the shipped cells".
[[nodiscard]] std::string ReadTextFileOr(const std::string& name_or_file,
                                         std::string_view expected,
                                         const std::vector<std::string>& names);

/// Parses text that came from `file` (only for messages).
[[nodiscard]] Json ParseJson(std::string_view text, const std::string& file);

/// JSON knows no NaN and no infinity: what is not finite is null.
[[nodiscard]] Json NumberOrNull(double value);

/// A cursor into a parsed document that knows its pointer, and the text for positions of messages.
class JsonReader {
 public:
  JsonReader(const Json& document, const std::string& file, std::string_view text);

  [[nodiscard]] JsonReader At(std::string_view key) const;                   ///< required member
  [[nodiscard]] std::optional<JsonReader> Find(std::string_view key) const;  ///< optional member
  [[nodiscard]] JsonReader Item(std::size_t index) const;
  [[nodiscard]] std::size_t Size() const;  ///< of an array
  [[nodiscard]] bool IsNull() const;
  [[nodiscard]] bool IsObject() const;
  [[nodiscard]] bool IsNumber() const;

  /// A finite number in [lo, hi].
  [[nodiscard]] double Number(double lo, double hi) const;
  [[nodiscard]] int Integer(int lo, int hi) const;
  [[nodiscard]] bool Boolean() const;
  [[nodiscard]] std::string Text() const;
  [[nodiscard]] std::vector<double> Numbers(double lo, double hi) const;
  /// The same, each greater than the one before: LoadError at the first that is not.
  [[nodiscard]] std::vector<double> Increasing(double lo, double hi) const;

  /// LoadError if the object has a key outside the list.
  void OnlyKeys(std::initializer_list<std::string_view> known) const;
  /// LoadError at this value: "/beta: expected ..., found ...".
  [[noreturn]] void Fail(std::string_view expected) const;
  [[noreturn]] void FailWith(std::string_view message) const;

 private:
  JsonReader(const Json& value, const JsonReader& parent, std::string pointer);

  const Json* value_;
  const std::string* file_;
  std::string_view text_;
  std::string pointer_;
};

}  // namespace lipoid
