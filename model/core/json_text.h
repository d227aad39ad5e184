#pragma once

/// @file
/// JSON as text for people too. Tests: tests/model/core/json_text_test.cc.

#include <string>

#include "model/core/json.h"

namespace lipoid {

/// Indented text in which a list of numbers or words stands on one line: a covariance takes a line a
/// row and not one a number. What is not UTF-8 in a text is replaced.
[[nodiscard]] std::string JsonText(const Json& json);

}  // namespace lipoid
