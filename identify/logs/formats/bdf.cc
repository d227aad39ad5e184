// Battery Data Format, a CSV with the names Test Time / s, Voltage / V, Current / A, or their
// machine-readable twins test_time_second, voltage_volt, current_ampere. Its rule is that charging
// is positive; the sign is found from the data all the same, because real files break it.

#include "identify/logs/formats/layout.h"

namespace lipoid {

constinit const Layout kBatteryDataFormat{
    .name = "bdf",
    .summary =
        "Battery Data Format: Test Time / s, Current / A, Voltage / V or test_time_second, "
        "current_ampere, ...",
    .signature =
        {{"test_time_second|test_time_minute|test_time_hour|test_time_millisecond|test_time_/"
          "_s|test_time_/_min|test_time_/_h|test_time_/_ms",
          "current_ampere|current_milliampere|current_/_a|current_/_ma",
          "voltage_volt|voltage_millivolt|voltage_/_v|voltage_/_mv"}},
    .columns = {{{.names = "test_time", .in_order = true},
                 {.names = "current", .in_order = true},
                 {.names = "voltage", .in_order = true},
                 {.names = "temperature_t1|surface_temperature_t1", .in_order = true},
                 {.names = "step_id|step_index|step_count", .in_order = true},
                 {.names = "cycle_count"},
                 {.names = "step_type"}}},
};

}  // namespace lipoid
