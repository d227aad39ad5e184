#include "identify/logs/formats/basytec.h"

namespace lipoid {
namespace {

constexpr std::string_view kSignature[] = {"~time", "u", "i", "line|command|dataset"};
constexpr std::string_view kTime[] = {"~time"};
constexpr std::string_view kCurrent[] = {"i"};
constexpr std::string_view kVoltage[] = {"u"};
constexpr std::string_view kTemperature[] = {"t1"};
constexpr std::string_view kStep[] = {"line"};
constexpr std::string_view kCycle[] = {"cyc_count"};
constexpr std::string_view kState[] = {"command"};

}  // namespace

constinit const Layout kBasytec{
    .name = "basytec",
    .summary = "Basytec text: lines that start with ~, then ~Time[s] or [h], Command, U[V], I[A]",
    .signature = kSignature,
    .columns = {{ColumnNames{.names = kTime, .in_order = true},
                 ColumnNames{.names = kCurrent, .in_order = true},
                 ColumnNames{.names = kVoltage, .in_order = true},
                 ColumnNames{.names = kTemperature, .in_order = true},
                 ColumnNames{.names = kStep},
                 ColumnNames{.names = kCycle},
                 ColumnNames{.names = kState}}},
};

}  // namespace lipoid
