#pragma once

/// @file
/// One battery of an autopilot's log as a Log, as ReadLog() returns it: the battery is chosen, rows
/// that cannot be used are counted and dropped, and a log that holds no flight on a battery is
/// refused with the reason. Tests: tests/identify/logs/flight/flight_log_test.cc.

#include <string>
#include <string_view>

#include "identify/logs/flight/autopilot_log.h"
#include "identify/logs/log.h"

namespace lipoid {

/// The rows of the battery that the options choose, with times since the autopilot started. LoadError
/// where there is no battery, more than one and none is chosen, no row, no current, a voltage that
/// never moves under load or one below 1 V throughout.
[[nodiscard]] Log FlightLog(const std::string& file,
                            const AutopilotFormat& format,
                            AutopilotLog flight,
                            const ReadOptions& options);

/// LoadError where the voltage stands still while the current comes and goes: a simulation, or a sensor that
/// is not connected. Columns hold no NaN.
void RefuseFlatVoltage(const SourcePosition& position, const Record& record);

}  // namespace lipoid
