#pragma once

/// @file
/// Flights that say nothing of a battery: too short, too idle, too slowly sampled.
/// Tests: tests/tools/health_test.cc.

#include "identify/logs/record.h"

namespace lipoid {

/// LoadError with the reason. The record and the capacity are of the same pack, or of one cell.
void RefuseIdleFlight(const Record& record, double capacity_Ah);

}  // namespace lipoid
