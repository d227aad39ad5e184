#pragma once

/// @file
/// PX4's ULog: a header, definitions, then data by subscription.
///
///   file     "ULog" 01 12 35, version, uint64 start in us; then messages
///   message  uint16 size, char type, payload of that size
///   F        format: "name:type field;type field;..."
///   P        parameter: uint8 length, "type name", value
///   I        information of the same shape
///   A        subscription: uint8 multi id, uint16 message id, name
///   D        data: uint16 message id, fields of its format one after another, the last padding left out
///   O        dropout: uint16 ms in which nothing could be logged
///
/// Source: docs.px4.io, "ULog File Format". Batteries are the instances of topic battery_status; one
/// of multi id 0 is battery 1.

#include <string_view>

#include "identify/logs/flight/autopilot_log.h"

namespace lipoid {

[[nodiscard]] bool IsULog(std::string_view bytes);
[[nodiscard]] AutopilotLog ReadULog(std::string_view bytes);

}  // namespace lipoid
