#pragma once

/// @file
/// The three kinds of trouble, and no fourth.
///
///   what went wrong                          what happens
///   an input file is not what it should be   LoadError, with file:line:column
///   an option is not what it should be       OptionError
///   a caller broke a precondition            PreconditionError, thrown by Require()
///
/// Numerical trouble (no convergence, a residual that is not finite) is a result with a reason and
/// never an exception: see Termination in identify/optimizers/least_squares.h. Tests:
/// tests/model/core/errors_test.cc.

#include <cstddef>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lipoid {

/// A place in a text file; lines and columns count from 1. Where a whole file is meant (it is empty,
/// or all of its rows are) both are 1; of a file that is not there both are 0 (NoFile).
struct SourcePosition {
  std::string file;
  std::size_t line = 1;
  std::size_t column = 1;

  friend bool operator==(const SourcePosition&, const SourcePosition&) = default;
};

/// The place of a file that is not there: "cell.csv: error: ...".
[[nodiscard]] inline SourcePosition NoFile(std::string file) { return {std::move(file), 0, 0}; }

/// One thing that is wrong with an input file: what was expected and what was found, as one
/// sentence.
struct Diagnostic {
  SourcePosition position;
  std::string message;

  /// "cell.csv:12:7: error: expected a number, found 'abc'".
  [[nodiscard]] std::string Text() const;
  friend bool operator==(const Diagnostic&, const Diagnostic&) = default;
};

/// Something is wrong with an input file. what() holds one line per diagnostic: repeated ones once,
/// at most kMaxLines of them, and a last line that counts the rest.
class LoadError : public std::runtime_error {
 public:
  static constexpr std::size_t kMaxLines = 5;

  LoadError(SourcePosition position, std::string message);
  explicit LoadError(std::vector<Diagnostic> diagnostics);

  [[nodiscard]] const std::vector<Diagnostic>& diagnostics() const { return diagnostics_; }

 private:
  std::vector<Diagnostic> diagnostics_;
};

/// What is wrong with the inputs of `body`; empty where it comes to its end.
template <class Body>
[[nodiscard]] std::vector<Diagnostic> DiagnosticsOf(Body&& body) {
  try {
    body();
  } catch (const LoadError& error) {
    return error.diagnostics();
  }
  return {};
}

/// Something is wrong with an option or an argument; what() is a sentence that says what to do
/// instead.
class OptionError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A caller broke a rule that a function states in its header.
class PreconditionError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// Throws PreconditionError with the rule, the values and the caller's place unless `holds`.
///   Require(dt_s > 0, "dt_s > 0", {{"dt_s", dt_s}});
void Require(bool holds,
             std::string_view rule,
             std::initializer_list<std::pair<std::string_view, double>> values = {},
             const char* file = __builtin_FILE(),
             int line = __builtin_LINE());

}  // namespace lipoid
