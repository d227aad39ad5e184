// Basytec text: preamble lines that start with '~', then ~Time[s] (or [h]), ..., U[V], I[A], ...,
// Command.

#include "identify/logs/formats/layout.h"

namespace lipoid {

constinit const Layout kBasytec{
    .name = "basytec",
    .summary = "Basytec text: lines that start with ~, then ~Time[s] or [h], Command, U[V], I[A]",
    .signature = {{"~time", "u", "i", "line|command|dataset"}},
    .columns = {{{.names = "~time", .in_order = true},
                 {.names = "i", .in_order = true},
                 {.names = "u", .in_order = true},
                 {.names = "t1", .in_order = true},
                 {.names = "line"},
                 {.names = "cyc_count"},
                 {.names = "command"}}},
};

}  // namespace lipoid
