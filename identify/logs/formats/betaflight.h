#pragma once

/// @file
/// The blackbox of Betaflight flight controllers, as blackbox_decode writes it to CSV: units in the
/// header, microseconds since the controller started, current positive in discharge.
/// Source: betaflight/blackbox-tools, README and src/blackbox_decode.c.

#include "identify/logs/formats/layout.h"

namespace lipoid {

extern const Layout kBetaflight;

}  // namespace lipoid
