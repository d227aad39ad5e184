#include "identify/logs/formats/bdf.h"

namespace lipoid {
namespace {

constexpr std::string_view kSignature[] = {
    "test_time_second|test_time_minute|test_time_hour|test_time_millisecond|test_time_/"
    "_s|test_time_/_min|test_time_/_h|test_time_/_ms",
    "current_ampere|current_milliampere|current_/_a|current_/_ma",
    "voltage_volt|voltage_millivolt|voltage_/_v|voltage_/_mv"};

}  // namespace

constinit const Layout kBdf{
    .name = "bdf",
    .summary =
        "Battery Data Format: Test Time / s, Current / A, Voltage / V or test_time_second, "
        "current_ampere, ...",
    .signature = kSignature,
    .columns = {{ColumnNames{.names = "test_time", .in_order = true},
                 ColumnNames{.names = "current", .in_order = true},
                 ColumnNames{.names = "voltage", .in_order = true},
                 ColumnNames{.names = "temperature_t1|surface_temperature_t1", .in_order = true},
                 ColumnNames{.names = "step_id|step_index|step_count", .in_order = true},
                 ColumnNames{.names = "cycle_count"},
                 ColumnNames{.names = "step_type"}}},
};

}  // namespace lipoid
