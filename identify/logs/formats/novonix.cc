#include "identify/logs/formats/novonix.h"

namespace lipoid {
namespace {

constexpr std::string_view kSignature[] = {
    "run_time", "step_time", "potential", "circuit_temperature|step_position"};
constexpr std::string_view kTime[] = {"run_time"};
constexpr std::string_view kCurrent[] = {"current"};
constexpr std::string_view kVoltage[] = {"potential"};
constexpr std::string_view kTemperature[] = {"temperature"};
constexpr std::string_view kStep[] = {"step_number"};
constexpr std::string_view kCycle[] = {"cycle_number"};

}  // namespace

constinit const Layout kNovonix{
    .name = "novonix",
    .summary =
        "Novonix UHPC CSV: [Summary] ... [Data], then Run Time (h), Current (A), Potential (V)",
    .signature = kSignature,
    .columns = {{ColumnNames{.names = kTime, .in_order = true},
                 ColumnNames{.names = kCurrent, .in_order = true},
                 ColumnNames{.names = kVoltage, .in_order = true},
                 ColumnNames{.names = kTemperature, .in_order = true},
                 ColumnNames{.names = kStep},
                 ColumnNames{.names = kCycle},
                 ColumnNames{}}},
};

}  // namespace lipoid
