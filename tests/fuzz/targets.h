#pragma once

/// @file
/// What is open to files from elsewhere, as functions of bytes: for fuzzers (fuzz_main.cc), and for
/// the tests that give each its old finds again (replay_test.cc). Any bytes end in an answer or in a
/// refusal that says something in printable characters; all else is a failure.

#include <array>
#include <ostream>
#include <span>
#include <string>
#include <string_view>

namespace lipoid::test {

struct FuzzTarget {
  std::string_view name;
  /// What seeds are taken from: files below fixtures/ whose path contains one of these.
  std::array<std::string_view, 3> seeds;
  /// PreconditionError, an assertion or a signal: a find. std::logic_error: the answer contradicts
  /// itself.
  void (*run)(const std::string& bytes);
};

inline void PrintTo(const FuzzTarget& target, std::ostream* out) { *out << target.name; }

/// One row for each reader, sorted by name.
[[nodiscard]] std::span<const FuzzTarget> FuzzTargets();

/// Runs the target; a refusal is checked and swallowed.
void RunFuzzTarget(const FuzzTarget& target, std::string_view bytes);

}  // namespace lipoid::test
