#include "identify/logs/formats/neware.h"

namespace lipoid {
namespace {

constexpr std::string_view kStepClock[] = {"time", "step_time"};
constexpr std::string_view kCycleLevel[] = {"cycle_index|cycle_id"};
constexpr std::string_view kStepLevel[] = {"step_index|step_id|step_number", "step_type"};
constexpr std::span<const std::string_view> kLevels[] = {kCycleLevel, kStepLevel};
constexpr std::string_view kSignature[] = {"datapoint|record_number", "current", "voltage"};
constexpr std::string_view kTime[] = {"total_time", "cumulative_time"};
constexpr std::string_view kCurrent[] = {"current"};
constexpr std::string_view kVoltage[] = {"voltage"};
constexpr std::string_view kTemperature[] = {"t1"};
constexpr std::string_view kStep[] = {"step_index", "step_number", "step_id"};
constexpr std::string_view kCycle[] = {"cycle_index", "cycle_id"};
constexpr std::string_view kState[] = {"step_type"};

}  // namespace

constinit const Layout kNeware{
    .name = "neware",
    .summary =
        "Neware BTSDA CSV, flat or in three levels: DataPoint, Step Type, Time, Total Time, "
        "Current(A), Voltage(V)",
    .signature = kSignature,
    .columns = {{ColumnNames{.names = kTime, .in_order = true},
                 ColumnNames{.names = kCurrent, .in_order = true},
                 ColumnNames{.names = kVoltage, .in_order = true},
                 ColumnNames{.names = kTemperature, .in_order = true},
                 ColumnNames{.names = kStep, .in_order = true},
                 ColumnNames{.names = kCycle, .in_order = true},
                 ColumnNames{.names = kState}}},
    .step_clock = {.names = kStepClock, .in_order = true},
    .level_signatures = kLevels,
};

}  // namespace lipoid
