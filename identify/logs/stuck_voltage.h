#pragma once

/// @file
/// A voltage in a log of the laboratory that is not measured: it is beyond the end of its sensor's range, or an earlier
/// value is repeated. Flights have a current that moves all the time, and a way of their own
/// (identify/health/stuck_sensor.h). Tests: tests/identify/logs/stuck_voltage_test.cc.

#include <string>

#include "identify/logs/record.h"

namespace lipoid {

/// In a sentence, that the voltage shows one value for far more rows than elsewhere while current flows, and that either
/// the current moves meanwhile by what moves the voltage elsewhere, or the voltage then jumps where the current does
/// not. "" where it does not: not of a rest, of a voltage that is held while the current falls (under charge, or by a
/// load), or of a sensor of coarse steps. For a record whose voltages are as the file has them.
[[nodiscard]] std::string DoubtAboutStuckVoltage(const Record& record);

}  // namespace lipoid
