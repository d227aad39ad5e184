// Arbin MITS Pro and its databases, as CSV: Data_Point, Test_Time(s), ..., Current(A), Voltage(V),
// with blanks or underscores, with or without units (then s, A and V). Charging is positive.

#include "identify/logs/formats/layout.h"

namespace lipoid {

constinit const Layout kArbin{
    .name = "arbin",
    .summary = "Arbin MITS Pro CSV: Data_Point, Test_Time(s), Step_Index, Current(A), Voltage(V)",
    .signature = {{"data_point", "test_time", "step_index|step_id", "current", "voltage"}},
    .columns = {{{.names = "test_time", .in_order = true, .known_unit = "s"},
                 {.names = "current", .in_order = true, .known_unit = "A"},
                 {.names = "voltage", .in_order = true, .known_unit = "V"},
                 {.names = "aux_temperature_1|temperature", .in_order = true, .known_unit = "degC"},
                 {.names = "step_index|step_id"},
                 {.names = "cycle_index|cycle_id"}}},
    .date_order = DateOrder::kMonthFirst,
};

}  // namespace lipoid
