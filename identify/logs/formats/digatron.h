#pragma once

/// @file
/// Digatron CSV: a preamble, a header, a line of units ([V], [A], ...) and Prog Time in hhh:mm:ss;
/// or headers that carry the unit after '#': Program Duration#s, Current#A. Discharging is
/// negative. Tests: tests/identify/logs/formats/formats_test.cc.

#include "identify/logs/formats/layout.h"

namespace lipoid {

extern const Layout kDigatron;

}  // namespace lipoid
