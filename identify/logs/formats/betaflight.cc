#include "identify/logs/formats/betaflight.h"

namespace lipoid {
namespace {

constexpr std::string_view kSignature[] = {"loopiteration", "time", "vbatlatest"};
constexpr std::string_view kTime[] = {"time"};
constexpr std::string_view kCurrent[] = {"amperagelatest"};
constexpr std::string_view kVoltage[] = {"vbatlatest"};

}  // namespace

constinit const Layout kBetaflight{
    .name = "betaflight",
    .summary = "Betaflight blackbox, decoded to CSV: time (us), vbatLatest (V), amperageLatest (A)",
    .signature = kSignature,
    .columns = {{ColumnNames{.names = kTime},
                 ColumnNames{.names = kCurrent},
                 ColumnNames{.names = kVoltage},
                 ColumnNames{},
                 ColumnNames{},
                 ColumnNames{},
                 ColumnNames{}}},
    .discharge_is_positive = true,
};

}  // namespace lipoid
