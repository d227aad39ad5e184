#pragma once

/// @file
/// Battery Data Format, a CSV with the names Test Time / s, Voltage / V, Current / A, or their
/// machine-readable twins test_time_second, voltage_volt, current_ampere. Its rule is that charging
/// is positive; the sign is found from the data all the same, because real files break it. Tests:
/// tests/identify/logs/formats/formats_test.cc.

#include "identify/logs/formats/layout.h"

namespace lipoid {

extern const Layout kBdf;

}  // namespace lipoid
