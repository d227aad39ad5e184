// The blackbox of Betaflight flight controllers, as blackbox_decode writes it to CSV: units in the
// header, microseconds since the controller started, current positive in discharge.
// Source: betaflight/blackbox-tools, README and src/blackbox_decode.c.

#include "identify/logs/formats/layout.h"

namespace lipoid {

constinit const Layout kBetaflight{
    .name = "betaflight",
    .summary = "Betaflight blackbox, decoded to CSV: time (us), vbatLatest (V), amperageLatest (A)",
    .signature = {{"loopiteration", "time", "vbatlatest"}},
    .columns = {{{.names = "time"}, {.names = "amperagelatest"}, {.names = "vbatlatest"}}},
    .discharge_is_positive = true,
};

}  // namespace lipoid
