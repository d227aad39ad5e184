#include "identify/logs/formats/bdf.h"

namespace lipoid {
namespace {

constexpr std::string_view kSignature[] = {
    "test_time_second|test_time_minute|test_time_hour|test_time_millisecond|test_time_/"
    "_s|test_time_/_min|test_time_/_h|test_time_/_ms",
    "current_ampere|current_milliampere|current_/_a|current_/_ma",
    "voltage_volt|voltage_millivolt|voltage_/_v|voltage_/_mv"};
constexpr std::string_view kTime[] = {"test_time"};
constexpr std::string_view kCurrent[] = {"current"};
constexpr std::string_view kVoltage[] = {"voltage"};
constexpr std::string_view kTemperature[] = {"temperature_t1", "surface_temperature_t1"};
constexpr std::string_view kStep[] = {"step_id", "step_index", "step_count"};
constexpr std::string_view kCycle[] = {"cycle_count"};
constexpr std::string_view kState[] = {"step_type"};

}  // namespace

constinit const Layout kBdf{
    .name = "bdf",
    .summary =
        "Battery Data Format: Test Time / s, Current / A, Voltage / V or test_time_second, "
        "current_ampere, ...",
    .signature = kSignature,
    .columns = {{ColumnNames{.names = kTime, .in_order = true},
                 ColumnNames{.names = kCurrent, .in_order = true},
                 ColumnNames{.names = kVoltage, .in_order = true},
                 ColumnNames{.names = kTemperature, .in_order = true},
                 ColumnNames{.names = kStep, .in_order = true},
                 ColumnNames{.names = kCycle},
                 ColumnNames{.names = kState}}},
};

}  // namespace lipoid
