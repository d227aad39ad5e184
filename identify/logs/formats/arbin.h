#pragma once

/// @file
/// Arbin MITS Pro and its databases, as CSV: Data_Point, Test_Time(s), ..., Current(A), Voltage(V),
/// with blanks or underscores, with or without units (then s, A and V). Charging is positive.
/// Tests: tests/identify/logs/formats/formats_test.cc.

#include "identify/logs/formats/layout.h"

namespace lipoid {

extern const Layout kArbin;

}  // namespace lipoid
