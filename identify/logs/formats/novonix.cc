// Novonix UHPC: [Summary] ... [Data], then Run Time (h), Current (A), Potential (V); older
// programs wrap each row, header included, in one pair of quotes. Charging is positive.

#include "identify/logs/formats/layout.h"

namespace lipoid {

constinit const Layout kNovonix{
    .name = "novonix",
    .summary =
        "Novonix UHPC CSV: [Summary] ... [Data], then Run Time (h), Current (A), Potential (V)",
    .signature = {{"run_time", "step_time", "potential", "circuit_temperature|step_position"}},
    .columns = {{{.names = "run_time", .in_order = true},
                 {.names = "current", .in_order = true},
                 {.names = "potential", .in_order = true},
                 {.names = "temperature", .in_order = true},
                 {.names = "step_number"},
                 {.names = "cycle_number"}}},
};

}  // namespace lipoid
