#include "identify/logs/formats/digatron.h"

namespace lipoid {
namespace {

constexpr std::string_view kSignature[] = {"prog_time|program_duration|progtime",
                                           "status",
                                           "step_time|step_duration|steptime",
                                           "procedure|cycle_level"};
constexpr std::string_view kTime[] = {"prog_time", "program_duration", "progtime"};
constexpr std::string_view kCurrent[] = {"current"};
constexpr std::string_view kVoltage[] = {"voltage"};
constexpr std::string_view kTemperature[] = {"temperature", "t1", "logtemp001"};
constexpr std::string_view kStep[] = {"step"};
constexpr std::string_view kCycle[] = {"cycle"};
constexpr std::string_view kState[] = {"status"};

}  // namespace

constinit const Layout kDigatron{
    .name = "digatron",
    .summary =
        "Digatron CSV: Prog Time, Step, Status, Voltage, Current over a line of units, or "
        "Current#A and Voltage#V",
    .signature = kSignature,
    .columns = {{ColumnNames{.names = kTime, .in_order = true},
                 ColumnNames{.names = kCurrent, .in_order = true},
                 ColumnNames{.names = kVoltage, .in_order = true},
                 ColumnNames{.names = kTemperature, .in_order = true},
                 ColumnNames{.names = kStep},
                 ColumnNames{.names = kCycle},
                 ColumnNames{.names = kState}}},
    .date_order = DateOrder::kMonthFirst,
};

}  // namespace lipoid
