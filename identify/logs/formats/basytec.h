#pragma once

/// @file
/// Basytec text: preamble lines that start with '~', then ~Time[s] (or [h]), ..., U[V], I[A], ...,
/// Command. Tests: tests/identify/logs/formats/formats_test.cc.

#include "identify/logs/formats/layout.h"

namespace lipoid {

extern const Layout kBasytec;

}  // namespace lipoid
