// Neware BTSDA CSV: flat, or with three levels of header (cycle, step, record) told apart by
// leading empty fields. Time restarts with each step; Total Time or Cumulative Time is taken where
// the file has it. Charging is positive.

#include "identify/logs/formats/layout.h"

namespace lipoid {
namespace {

constexpr std::string_view kNewareCycleLevel[] = {"cycle_index|cycle_id"};
constexpr std::string_view kNewareStepLevel[] = {"step_index|step_id|step_number", "step_type"};
constexpr std::span<const std::string_view> kNewareLevels[] = {kNewareCycleLevel, kNewareStepLevel};

}  // namespace

constinit const Layout kNeware{
    .name = "neware",
    .summary =
        "Neware BTSDA CSV, flat or in three levels: DataPoint, Step Type, Time, Total Time, "
        "Current(A), Voltage(V)",
    .signature = {{"datapoint|record_number", "current", "voltage"}},
    .columns = {{{.names = "total_time|cumulative_time", .in_order = true},
                 {.names = "current", .in_order = true},
                 {.names = "voltage", .in_order = true},
                 {.names = "t1", .in_order = true},
                 {.names = "step_index|step_number|step_id", .in_order = true},
                 {.names = "cycle_index|cycle_id", .in_order = true},
                 {.names = "step_type"}}},
    .step_clock = {.names = "time|step_time", .in_order = true},
    .level_signatures = kNewareLevels,
};

}  // namespace lipoid
