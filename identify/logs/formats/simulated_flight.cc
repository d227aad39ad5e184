#include "identify/logs/formats/simulated_flight.h"

namespace lipoid {
namespace {

constexpr std::string_view kSignature[] = {"time_s", "x_m", "battery_v", "battery_a"};

}  // namespace

constinit const Layout kSimulatedFlight{
    .name = "simulated-flight",
    .summary = "a flight of `lipoid fly`: time_s, x_m, ..., battery_V, battery_A",
    .signature = kSignature,
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
