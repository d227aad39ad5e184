#pragma once

/// @file
/// Maccor text and CSV: a few lines about the test, then Rec# (or Rec), Step, TestTime or Test
/// (Sec), Amps or Current, Volts or Voltage, State or Md. Amps are often unsigned: the state says
/// which way. A TestTime that is a plain number has no unit, and one program writes minutes: the
/// dates beside it decide. Tests: tests/identify/logs/formats/formats_test.cc.

#include "identify/logs/formats/layout.h"

namespace lipoid {

extern const Layout kMaccor;

}  // namespace lipoid
