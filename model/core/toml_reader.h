#pragma once

/// @file
/// TOML, strictly: tables are read key by key, and what is wrong is kept, so that one run names
/// every mistake of a file with its line and column.
///
///   const toml::table document = ParseToml(text, file, "a campaign");
///   std::vector<Diagnostic> problems;
///   const TomlReader top(document, file, problems);
///   top.OnlyKeys({"name", "mass_kg"});
///   top.Number("mass_kg", top.kAboveZero, top.kLargest, "a mass above 0 kg", mass_kg);
///   ThrowProblems(std::move(problems));
///
/// Not installed: it includes toml++, and who uses lipoid need not. For .cc files only. Tests:
/// tests/model/core/toml_reader_test.cc.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <initializer_list>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/core/errors.h"

namespace lipoid {

/// Text that came from `file`. LoadError "not a campaign in TOML: ..." at the place of a syntax
/// error.
[[nodiscard]] toml::table ParseToml(const std::string& text,
                                    const std::string& file,
                                    std::string_view what);

/// LoadError of all of them in the order of the file; nothing where there are none.
void ThrowProblems(std::vector<Diagnostic> problems);

/// A number that TOML reads back to the last bit, and as a float.
[[nodiscard]] std::string TomlFloat(double value);

/// A text in quotes, as TOML reads it back.
[[nodiscard]] std::string TomlText(const std::string& text);

/// A value as it stands in the file, short enough for a message.
[[nodiscard]] std::string TomlFound(const toml::node& node);

class TomlReader {
 public:
  /// Ends of ranges: NaN and the infinities are outside all of them.
  static constexpr double kAboveZero = std::numeric_limits<double>::min();
  static constexpr double kLargest = std::numeric_limits<double>::max();

  /// All three outlive the reader.
  TomlReader(const toml::table& table, const std::string& file, std::vector<Diagnostic>& problems)
      : table_(table), file_(file), problems_(problems) {}

  [[nodiscard]] SourcePosition At(const toml::source_region& source) const;
  [[nodiscard]] SourcePosition At() const { return At(table_.source()); }

  void Problem(SourcePosition position, std::string message) const;
  /// "key: expected ..., found ..." at the node.
  void Expected(const toml::node& node, std::string_view key, std::string_view expected) const;
  void OnlyKeys(std::span<const std::string_view> known) const;
  void OnlyKeys(std::initializer_list<std::string_view> known) const {
    OnlyKeys(std::span(known.begin(), known.size()));
  }

  /// The node of a key that may be absent.
  [[nodiscard]] const toml::node* Find(std::string_view key) const { return table_.get(key); }

  /// Each reads into `value` if the key is there and right. True where it was read.
  bool Text(std::string_view key, std::string& value) const;
  bool Number(
      std::string_view key, double lo, double hi, std::string_view expected, double& value) const;
  /// A list of exactly as many numbers.
  bool Numbers(std::string_view key,
               double lo,
               double hi,
               std::string_view expected,
               std::span<double> values) const;
  bool Integer(std::string_view key, int lo, int hi, int& value) const;
  /// A list of any length above 0 of integers of at least 0.
  bool Integers(std::string_view key, std::vector<int>& values) const;

  /// One of the names of an enum.
  template <class E>
  bool Choice(std::string_view key, E& value) const {
    const toml::node* node = Find(key);
    if (node == nullptr) return false;
    std::vector<std::string_view> names;
    for (const auto& [candidate, name] : OptionNames(E{})) {
      if (node->is_string() && node->as_string()->get() == name) {
        value = candidate;
        return true;
      }
      names.push_back(name);
    }
    Expected(*node, key, fmt::format("one of {}", fmt::join(names, ", ")));
    return false;
  }

 private:
  const toml::table& table_;
  const std::string& file_;
  std::vector<Diagnostic>& problems_;
};

}  // namespace lipoid
