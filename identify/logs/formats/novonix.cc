// Novonix UHPC: [Summary] ... [Data], then Run Time (h), Current (A), Potential (V); older
// programs wrap each row, header included, in one pair of quotes. Charging is positive.

#include "identify/logs/formats/layout.h"

namespace lipoid {
namespace {

constexpr std::string_view kNovonixSignature[] = {
    "run_time", "step_time", "potential", "circuit_temperature|step_position"};

}  // namespace

constinit const Layout kNovonix{
    .name = "novonix",
    .summary =
        "Novonix UHPC CSV: [Summary] ... [Data], then Run Time (h), Current (A), Potential (V)",
    .signature = kNovonixSignature,
    .columns = {{ColumnNames{.names = "run_time", .in_order = true},
                 ColumnNames{.names = "current", .in_order = true},
                 ColumnNames{.names = "potential", .in_order = true},
                 ColumnNames{.names = "temperature", .in_order = true},
                 ColumnNames{.names = "step_number"},
                 ColumnNames{.names = "cycle_number"},
                 ColumnNames{}}},
};

}  // namespace lipoid
