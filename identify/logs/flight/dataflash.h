#pragma once

/// @file
/// ArduPilot's DataFlash log: messages that begin with A3 95 and their type; messages FMT (type 128)
/// say for each type how long it is, what it is called and which fields it has.
///
///   FMT      uint8 type, uint8 length with the three bytes before it, char[4] name, char[16] format,
///            char[64] names of the fields, with commas
///   format   a letter a field: b B int8/uint8, h H 16 bits, i I 32, q Q 64, f d, g half; c C e E the
///            same of 16 and 32 bits in hundredths; L degrees in 1e-7; M mode; n N Z text of 4, 16, 64
///
/// Source: ArduPilot, libraries/AP_Logger/LogStructure.h. The battery is in BAT, in CURR before
/// Copter 3.6; second batteries of old logs are in BAT2 and CUR2. Volt and Curr in h or H are hundredths.

#include <string_view>

#include "identify/logs/flight/autopilot_log.h"

namespace lipoid {

[[nodiscard]] bool IsDataFlash(std::string_view bytes);
[[nodiscard]] AutopilotLog ReadDataFlash(std::string_view bytes);

}  // namespace lipoid
