#pragma once

/// @file
/// Any delimited text with a header that names time, current and voltage in one of the usual ways;
/// Landt and PEC exports are read by it as they are. Tests:
/// tests/identify/logs/formats/formats_test.cc.

#include "identify/logs/formats/layout.h"

namespace lipoid {

extern const Layout kPlainCsv;

}  // namespace lipoid
