#include "identify/logs/formats/betaflight.h"

namespace lipoid {
namespace {

constexpr std::string_view kSignature[] = {"loopiteration", "time", "vbatlatest"};

}  // namespace

constinit const Layout kBetaflight{
    .name = "betaflight",
    .summary = "Betaflight blackbox, decoded to CSV: time (us), vbatLatest (V), amperageLatest (A)",
    .signature = kSignature,
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
