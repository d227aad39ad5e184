#include "identify/logs/formats/arbin.h"

namespace lipoid {
namespace {

constexpr std::string_view kSignature[] = {
    "data_point", "test_time", "step_index|step_id", "current", "voltage"};
constexpr std::string_view kTime[] = {"test_time"};
constexpr std::string_view kCurrent[] = {"current"};
constexpr std::string_view kVoltage[] = {"voltage"};
constexpr std::string_view kTemperature[] = {"aux_temperature_1", "temperature"};
constexpr std::string_view kStep[] = {"step_index", "step_id"};
constexpr std::string_view kCycle[] = {"cycle_index", "cycle_id"};

}  // namespace

constinit const Layout kArbin{
    .name = "arbin",
    .summary = "Arbin MITS Pro CSV: Data_Point, Test_Time(s), Step_Index, Current(A), Voltage(V)",
    .signature = kSignature,
    .columns = {{ColumnNames{.names = kTime, .in_order = true, .known_unit = "s"},
                 ColumnNames{.names = kCurrent, .in_order = true, .known_unit = "A"},
                 ColumnNames{.names = kVoltage, .in_order = true, .known_unit = "V"},
                 ColumnNames{.names = kTemperature, .in_order = true, .known_unit = "degC"},
                 ColumnNames{.names = kStep},
                 ColumnNames{.names = kCycle},
                 ColumnNames{}}},
    .date_order = DateOrder::kMonthFirst,
};

}  // namespace lipoid
