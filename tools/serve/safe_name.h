#pragma once

/// @file
/// The name under which an upload is kept. Tests: tests/tools/serve/safe_name_test.cc.

#include <set>
#include <string>
#include <string_view>

namespace lipoid {

/// A name of a file, near to the one that was given, that leads nowhere: letters and digits, blanks
/// and "._-+,()@" alone, of ASCII or in valid UTF-8 that no terminal misreads; it begins with a letter
/// or a digit and has at most 100 bytes. It is none of `taken`, without regard to case.
[[nodiscard]] std::string SafeName(std::string_view given, const std::set<std::string>& taken);

}  // namespace lipoid
