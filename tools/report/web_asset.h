#pragma once

/// @file
/// The files of the front end that the build made of tools/web. Tests: tests/tools/serve_test.py.

#include <string_view>

namespace lipoid {

/// A file by its name ("report.js"); nullptr where this program was built without the front end.
[[nodiscard]] const std::string_view* FindWebAsset(std::string_view name);

}  // namespace lipoid
