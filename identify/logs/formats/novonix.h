#pragma once

/// @file
/// Novonix UHPC: [Summary] ... [Data], then Run Time (h), Current (A), Potential (V); older
/// programs wrap each row, header included, in one pair of quotes. Charging is positive. Tests:
/// tests/identify/logs/formats/formats_test.cc.

#include "identify/logs/formats/layout.h"

namespace lipoid {

extern const Layout kNovonix;

}  // namespace lipoid
