#include "identify/logs/formats/maccor.h"

namespace lipoid {
namespace {

constexpr std::string_view kDate[] = {"dpt_time"};
constexpr std::string_view kSignature[] = {
    "rec#|rec", "step", "testtime|test_time|test", "es|dpt_time|state|md|step_time|steptime"};
constexpr std::string_view kTime[] = {"testtime", "test_time", "test"};
constexpr std::string_view kCurrent[] = {"amps", "mamps", "current"};
constexpr std::string_view kVoltage[] = {"volts", "voltage"};
constexpr std::string_view kTemperature[] = {"temperature_cell", "temp_1"};
constexpr std::string_view kStep[] = {"step"};
constexpr std::string_view kCycle[] = {"cyc#", "cycle_c", "cycle_p"};
constexpr std::string_view kState[] = {"state", "md"};

}  // namespace

constinit const Layout kMaccor{
    .name = "maccor",
    .summary =
        "Maccor text and CSV: Rec#, Cyc#, Step, TestTime or Test (Sec), Amps, Volts, State; also "
        "Current [A], Md",
    .signature = kSignature,
    .columns = {{ColumnNames{.names = kTime, .in_order = true},
                 ColumnNames{.names = kCurrent, .in_order = true, .known_unit = "A"},
                 ColumnNames{.names = kVoltage, .in_order = true, .known_unit = "V"},
                 ColumnNames{.names = kTemperature, .in_order = true, .known_unit = "degC"},
                 ColumnNames{.names = kStep},
                 ColumnNames{.names = kCycle, .in_order = true},
                 ColumnNames{.names = kState}}},
    .date = {.names = kDate},
    .date_order = DateOrder::kMonthFirst,
    .millivolts_beside = "mamps",
};

}  // namespace lipoid
