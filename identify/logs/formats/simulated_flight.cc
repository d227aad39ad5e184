// A flight as `lipoid fly` logs it: the current that is decided in a row flows until the next one.

#include "identify/logs/formats/layout.h"

namespace lipoid {
namespace {

constexpr std::string_view kSimulatedFlightSignature[] = {
    "time_s", "x_m", "battery_v", "battery_a"};

}  // namespace

constinit const Layout kSimulatedFlight{
    .name = "simulated-flight",
    .summary = "a flight of `lipoid fly`: time_s, x_m, ..., battery_V, battery_A",
    .signature = kSimulatedFlightSignature,
    .columns = {{ColumnNames{.names = "time"},
                 ColumnNames{.names = "battery"},  // the unit tells it from the voltage
                 ColumnNames{.names = "battery"},
                 ColumnNames{},
                 ColumnNames{},
                 ColumnNames{},
                 ColumnNames{}}},
    .discharge_is_positive = true,
    .hold = Hold::kForward,
};

}  // namespace lipoid
