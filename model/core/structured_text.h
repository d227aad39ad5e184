#pragma once

/// @file
/// What is too much for a structured file (JSON, TOML, a table of v_oc): the one place of these
/// limits, which docs/formats.md states. A file beyond them is no file of lipoid's, and a parser
/// that recurses or compares key with key would take forever over it or run out of stack. Logs have
/// no such limit but that of their rows. Tests: tests/model/core/structured_text_test.cc.

#include <cstddef>
#include <string>
#include <string_view>

#include "model/core/errors.h"

namespace lipoid::structured_text {

inline constexpr std::size_t kMostBytes = std::size_t{16} << 20;
inline constexpr std::size_t kMostBytesOfLine = std::size_t{1} << 20;
inline constexpr std::size_t kMostDepth = 64;  ///< lists and tables in one another, dots of a key
inline constexpr std::size_t kMostKeys = 50'000;
inline constexpr std::size_t kMostValues = 1'000'000;

/// Line and column of a byte; the end of the text where it is beyond.
[[nodiscard]] SourcePosition PositionOfByte(const std::string& file,
                                            std::string_view text,
                                            std::size_t byte);

/// LoadError where the text is too long, has a line that is too long, or holds a NUL.
void CheckText(std::string_view text, const std::string& file);

/// The same for the depth, keys and values of TOML, before a parser that recurses sees it. What is
/// no TOML may pass: the parser says what is wrong.
void CheckToml(std::string_view text, const std::string& file);

/// Counts what a parser meets. LoadError at the byte where it is too much.
class Budget {
 public:
  Budget(std::string_view text, const std::string& file) : text_(text), file_(file) {}
  void Enter(std::size_t byte);  ///< a list or a table
  void Leave() { --depth_; }
  void Key(std::size_t byte);
  void Value(std::size_t byte);
  /// A key of so many parts.
  void Dots(std::size_t dots, std::size_t byte) const;

 private:
  [[noreturn]] void Fail(std::size_t byte, std::size_t most, std::string_view of_what) const;

  std::string_view text_;
  const std::string& file_;
  std::size_t depth_ = 0;
  std::size_t keys_ = 0;
  std::size_t values_ = 0;
};

}  // namespace lipoid::structured_text
