#include "identify/still_temperature.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "identify/logs/columns.h"
#include "model/battery/arrhenius.h"
#include "model/battery/prediction.h"
#include "model/battery/typical_temperature.h"

namespace lipoid {
namespace {

// By how much the cell warms above its first temperature.
double Warming(const Cell& cell, const LoadedLog& log) {
  const Record& record = log.log.record;
  const double start_degC = record.temperature_degC.front();
  double warmest_degC = start_degC;
  PredictRows(cell,
              record.time_s,
              record.current_A,
              record.hold,
              log.entry.initial_soc,
              {.ambient_degC = start_degC},
              [&](std::size_t, const PredictedRow& row) {
                warmest_degC = std::max(warmest_degC, CelsiusOf(row.stepper.state().temperature_K));
              });
  return warmest_degC - start_degC;
}

}  // namespace

std::string DoubtAboutStillTemperatures(const Cell& cell, const std::vector<LoadedLog>& logs) {
  constexpr double kLeast_K = 5.0;
  constexpr double kShare = 0.1;
  constexpr double kMost_K = 3.0;  // a tenth of what any test of a cell warms it by
  Cell one = cell.AsOne();
  if (!one.temperature) one = WithTypicalTemperature(std::move(one));
  one.temperature->heat = TypicalHeat(one.alpha_C() / 3600.0);
  std::vector<std::string> still;
  for (const LoadedLog& log : logs) {
    if (!TakesPartInLabFit(log.entry.kind) || log.log.record.temperature_degC.empty()) continue;
    const Extent extent = FindExtent(log.log.record.temperature_degC);
    const double moved_K = extent.most - extent.least;
    if (moved_K > kMost_K) continue;
    const double warming_K = Warming(one, log);
    if (warming_K < kLeast_K || moved_K > kShare * warming_K) continue;
    still.push_back(
        fmt::format("{} by {:.2g} K where {:.2g} K are usual", log.entry.file, moved_K, warming_K));
  }
  if (still.empty()) return "";
  return fmt::format(
      "the temperature hardly moves in logs in which a cell of this size warms ({}): unless the cell was held at one "
      "temperature, that is the temperature of the air, or of a thermometer that is stuck. Then take the column out of "
      "these logs and give ambient_degC",
      fmt::join(still, ", "));
}

}  // namespace lipoid
