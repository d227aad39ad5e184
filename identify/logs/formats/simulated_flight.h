#pragma once

/// @file
/// A flight as `lipoid fly` logs it: the current that is decided in a row flows until the next one.

#include "identify/logs/formats/layout.h"

namespace lipoid {

extern const Layout kSimulatedFlight;

}  // namespace lipoid
