// Maccor text and CSV: a few lines about the test, then Rec# (or Rec), Step, TestTime or Test
// (Sec), Amps or Current, Volts or Voltage, State or Md. Amps are often unsigned: the state says
// which way. A TestTime that is a plain number has no unit, and one program writes minutes: the
// dates beside it decide.

#include "identify/logs/formats/layout.h"

namespace lipoid {

constinit const Layout kMaccor{
    .name = "maccor",
    .summary =
        "Maccor text and CSV: Rec#, Cyc#, Step, TestTime or Test (Sec), Amps, Volts, State; also "
        "Current [A], Md",
    .signature = {{"rec#|rec",
                   "step",
                   "testtime|test_time|test",
                   "es|dpt_time|state|md|step_time|steptime"}},
    .columns = {{{.names = "testtime|test_time|test", .in_order = true},
                 {.names = "amps|mamps|current", .in_order = true, .known_unit = "A"},
                 {.names = "volts|voltage", .in_order = true, .known_unit = "V"},
                 {.names = "temperature_cell|temp_1", .in_order = true, .known_unit = "degC"},
                 {.names = "step"},
                 {.names = "cyc#|cycle_c|cycle_p", .in_order = true},
                 {.names = "state|md"}}},
    .date = {.names = "dpt_time"},
    .date_order = DateOrder::kMonthFirst,
    .millivolts_beside = "mamps",
};

}  // namespace lipoid
