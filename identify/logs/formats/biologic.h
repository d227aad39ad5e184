#pragma once

/// @file
/// BioLogic EC-Lab and BT-Lab text (.mpt, .txt): "Nb header lines : N", then time/s, Ecell/V, I/mA
/// and many more; or without that preamble; or as derived CSV with semicolons. time/s may hold
/// dates. Tests: tests/identify/logs/formats/formats_test.cc.

#include "identify/logs/formats/layout.h"

namespace lipoid {

extern const Layout kBiologic;

}  // namespace lipoid
