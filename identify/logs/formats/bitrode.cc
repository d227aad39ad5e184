// Bitrode CSV: Exclude, Time(s), Cycle, Loop (three times), Step, ..., Current(A), Voltage(V),
// ..., Mode, Data; some programs leave the header out. Discharging is negative.

#include "identify/logs/formats/layout.h"

namespace lipoid {
namespace {

constexpr std::string_view kBitrodeHeader =
    "Exclude,Time(s),Cycle,Loop,Loop,Loop,Step,StepTime(s),Current(A),Voltage(V),Power(W),Capacity("
    "Ah),"
    "Energy(Wh),Mode,Data,";

// No,1.0,1,1,1,1,3,1.0,0.00,3.147,0.0,0.00,0.00,REST, ,
bool IsBitrodeRow(std::span<const TextCell> cells) {
  constexpr std::size_t kFields = 15;
  if (cells.size() != kFields && !(cells.size() == kFields + 1 && cells.back().text.empty()))
    return false;
  const auto exclude = LowerCase(cells[0].text);
  if (exclude != "no" && exclude != "yes") return false;
  for (std::size_t k = 1; k < 13; ++k) {
    double value = 0.0;
    if (!ParseNumber(cells[k].text, '.', value)) return false;
  }
  const auto mode = cells[13].text;
  return mode == "REST" || mode == "CHRG" || mode == "DCHG" || mode == "PAUS" || mode == "STOP";
}

}  // namespace

constinit const Layout kBitrode{
    .name = "bitrode",
    .summary =
        "Bitrode CSV: Exclude,Time(s),Cycle,Loop,Loop,Loop,Step,...,Mode,Data, or the same without "
        "a header",
    .signature = {{"loop", "step", "steptime", "current", "voltage", "mode"}},
    .columns = {{{.names = "time", .in_order = true},
                 {.names = "current", .in_order = true},
                 {.names = "voltage", .in_order = true},
                 {},
                 {.names = "step"},
                 {.names = "cycle"},
                 {.names = "mode"}}},
    .implied_header = kBitrodeHeader,
    .is_row = &IsBitrodeRow,
};

}  // namespace lipoid
