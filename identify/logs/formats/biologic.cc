#include "identify/logs/formats/biologic.h"

namespace lipoid {
namespace {

constexpr std::string_view kSignature[] = {"time/s", "ecell/v|ewe/v|<ewe>/v|<ecell>/v|ewe-ece/v"};
constexpr std::string_view kTime[] = {"time"};
constexpr std::string_view kCurrent[] = {"i", "<i>"};
constexpr std::string_view kVoltage[] = {"ecell", "ewe-ece", "ewe", "<ecell>", "<ewe>"};
constexpr std::string_view kTemperature[] = {"temperature"};
constexpr std::string_view kStep[] = {"ns"};
constexpr std::string_view kCycle[] = {"cycle_number"};

}  // namespace

constinit const Layout kBiologic{
    .name = "biologic",
    .summary = "BioLogic EC-Lab and BT-Lab text export: time/s, Ecell/V or Ewe/V, I/mA",
    .signature = kSignature,
    .columns = {{ColumnNames{.names = kTime, .in_order = true},
                 ColumnNames{.names = kCurrent, .in_order = true},
                 ColumnNames{.names = kVoltage, .in_order = true},
                 ColumnNames{.names = kTemperature, .in_order = true},
                 ColumnNames{.names = kStep},
                 ColumnNames{.names = kCycle},
                 ColumnNames{}}},
    .date_order = DateOrder::kMonthFirst,
};

}  // namespace lipoid
