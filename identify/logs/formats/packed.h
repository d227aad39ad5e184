#pragma once

/// @file
/// Files that hold logs but not as text: recognised by their first bytes, whatever the name, and
/// refused with advice. Tests: tests/identify/logs/log_test.cc.

#include <string>
#include <string_view>

namespace lipoid {

/// LoadError for `file`, which begins with `head`, where that is not text.
void RefusePacked(const std::string& file, std::string_view head);

}  // namespace lipoid
