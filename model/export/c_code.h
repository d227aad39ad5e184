#pragma once

/// @file
/// The cell as C: a header and a source for a microcontroller or a game engine, made of the same
/// law as lipoid's cell (cell_model.h), with a test of its own. Numbers are double, or float where
/// precision or the version "float" asks for it. Tests: tests/model/export/c_code_test.cc.

#include "model/export/exported.h"

namespace lipoid {

/// Files: the header, the source (".c"). OptionError where the version is another or the stem of
/// the files could not stand in an #include.
[[nodiscard]] Exported ExportC(const ExportRequest& request);

}  // namespace lipoid
