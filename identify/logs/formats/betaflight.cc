// The blackbox of Betaflight flight controllers, as blackbox_decode writes it to CSV: units in the
// header, microseconds since the controller started, current positive in discharge.
// Source: betaflight/blackbox-tools, README and src/blackbox_decode.c.

#include "identify/logs/formats/layout.h"

namespace lipoid {
namespace {

constexpr std::string_view kBetaflightSignature[] = {"loopiteration", "time", "vbatlatest"};

}  // namespace

constinit const Layout kBetaflight{
    .name = "betaflight",
    .summary = "Betaflight blackbox, decoded to CSV: time (us), vbatLatest (V), amperageLatest (A)",
    .signature = kBetaflightSignature,
    .columns = {{ColumnNames{.names = "time"},
                 ColumnNames{.names = "amperagelatest"},
                 ColumnNames{.names = "vbatlatest"},
                 ColumnNames{},
                 ColumnNames{},
                 ColumnNames{},
                 ColumnNames{}}},
    .discharge_is_positive = true,
};

}  // namespace lipoid
