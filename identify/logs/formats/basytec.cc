// Basytec text: preamble lines that start with '~', then ~Time[s] (or [h]), ..., U[V], I[A], ...,
// Command.

#include "identify/logs/formats/layout.h"

namespace lipoid {
namespace {

constexpr std::string_view kBasytecSignature[] = {"~time", "u", "i", "line|command|dataset"};

}  // namespace

constinit const Layout kBasytec{
    .name = "basytec",
    .summary = "Basytec text: lines that start with ~, then ~Time[s] or [h], Command, U[V], I[A]",
    .signature = kBasytecSignature,
    .columns = {{ColumnNames{.names = "~time", .in_order = true},
                 ColumnNames{.names = "i", .in_order = true},
                 ColumnNames{.names = "u", .in_order = true},
                 ColumnNames{.names = "t1", .in_order = true},
                 ColumnNames{.names = "line"},
                 ColumnNames{.names = "cyc_count"},
                 ColumnNames{.names = "command"}}},
};

}  // namespace lipoid
