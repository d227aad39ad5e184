#pragma once

/// @file
/// Bitrode CSV: Exclude, Time(s), Cycle, Loop (three times), Step, ..., Current(A), Voltage(V),
/// ..., Mode, Data; some programs leave the header out. Discharging is negative. Tests:
/// tests/identify/logs/formats/formats_test.cc.

#include "identify/logs/formats/layout.h"

namespace lipoid {

extern const Layout kBitrode;

}  // namespace lipoid
