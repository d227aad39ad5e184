#include "identify/logs/formats/basytec.h"

namespace lipoid {
namespace {

constexpr std::string_view kSignature[] = {"~time", "u", "i", "line|command|dataset"};

}  // namespace

constinit const Layout kBasytec{
    .name = "basytec",
    .summary = "Basytec text: lines that start with ~, then ~Time[s] or [h], Command, U[V], I[A]",
    .signature = kSignature,
    .columns = {{ColumnNames{.names = "~time", .in_order = true},
                 ColumnNames{.names = "i", .in_order = true},
                 ColumnNames{.names = "u", .in_order = true},
                 ColumnNames{.names = "t1", .in_order = true},
                 ColumnNames{.names = "line"},
                 ColumnNames{.names = "cyc_count"},
                 ColumnNames{.names = "command"}}},
};

}  // namespace lipoid
