// A flight as `lipoid fly` logs it: the current that is decided in a row flows until the next one.

#include "identify/logs/formats/layout.h"

namespace lipoid {

constinit const Layout kSimulatedFlight{
    .name = "simulated-flight",
    .summary = "a flight of `lipoid fly`: time_s, x_m, ..., battery_V, battery_A",
    .signature = {{"time_s", "x_m", "battery_v", "battery_a"}},
    .columns = {{{.names = "time"},
                 {.names = "battery"},  // the unit tells it from the voltage
                 {.names = "battery"},
                 {.names = "temperature"}}},
    .discharge_is_positive = true,
    .hold = Hold::kForward,
};

}  // namespace lipoid
