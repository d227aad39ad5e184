#pragma once

/// @file
/// Neware BTSDA CSV: flat, or with three levels of header (cycle, step, record) told apart by
/// leading empty fields. Time restarts with each step; Total Time or Cumulative Time is taken where
/// the file has it. Charging is positive. Tests: tests/identify/logs/formats/formats_test.cc.

#include "identify/logs/formats/layout.h"

namespace lipoid {

extern const Layout kNeware;

}  // namespace lipoid
