// Digatron CSV: a preamble, a header, a line of units ([V], [A], ...) and Prog Time in hhh:mm:ss;
// or headers that carry the unit after '#': Program Duration#s, Current#A. Discharging is
// negative.

#include "identify/logs/formats/layout.h"

namespace lipoid {

constinit const Layout kDigatron{
    .name = "digatron",
    .summary =
        "Digatron CSV: Prog Time, Step, Status, Voltage, Current over a line of units, or "
        "Current#A and Voltage#V",
    .signature = {{"prog_time|program_duration|progtime",
                   "status",
                   "step_time|step_duration|steptime",
                   "procedure|cycle_level"}},
    .columns = {{{.names = "prog_time|program_duration|progtime", .in_order = true},
                 {.names = "current", .in_order = true},
                 {.names = "voltage", .in_order = true},
                 {.names = "temperature|t1|logtemp001", .in_order = true},
                 {.names = "step"},
                 {.names = "cycle"},
                 {.names = "status"}}},
    .date_order = DateOrder::kMonthFirst,
};

}  // namespace lipoid
