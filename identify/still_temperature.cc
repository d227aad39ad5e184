#include "identify/still_temperature.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "identify/logs/columns.h"
#include "model/battery/arrhenius.h"
#include "model/battery/prediction.h"
#include "model/battery/typical_temperature.h"

namespace lipoid {

double UnshownWarming_K(const Cell& cell, const Record& record, double initial_soc) {
  constexpr double kLeast_K = 5.0;
  constexpr double kShare = 0.1;
  constexpr double kMost_K = 3.0;  // a tenth of what any test of a cell warms it by
  if (record.temperature_degC.empty()) return 0.0;
  const Extent extent = FindExtent(record.temperature_degC);
  const double moved_K = extent.most - extent.least;
  if (moved_K > kMost_K) return 0.0;
  Cell one = cell.AsOne();
  if (!one.temperature) one = WithTypicalTemperature(std::move(one));
  one.temperature->heat = TypicalHeat(one.alpha_C() / 3600.0);
  const double start_degC = record.temperature_degC.front();
  double warmest_degC = start_degC;
  PredictRows(one,
              record.time_s,
              record.current_A,
              record.hold,
              initial_soc,
              {.ambient_degC = start_degC},
              [&](std::size_t, const PredictedRow& row) {
                warmest_degC = std::max(warmest_degC, CelsiusOf(row.stepper.state().temperature_K));
              });
  const double warming_K = warmest_degC - start_degC;
  return warming_K < kLeast_K || moved_K > kShare * warming_K ? 0.0 : warming_K;
}

std::string DoubtAboutStillTemperatures(const Cell& cell, const std::vector<LoadedLog>& logs) {
  std::vector<std::string> still;
  for (const LoadedLog& log : logs) {
    if (!TakesPartInLabFit(log.entry.kind)) continue;
    const double warming_K = UnshownWarming_K(cell, log.log.record, log.entry.initial_soc);
    if (warming_K == 0.0) continue;
    const Extent extent = FindExtent(log.log.record.temperature_degC);
    still.push_back(fmt::format("{} by {:.2g} K where {:.2g} K are usual",
                                log.entry.file,
                                extent.most - extent.least,
                                warming_K));
  }
  if (still.empty()) return "";
  return fmt::format(
      "the temperature hardly moves in logs in which a cell of this size warms ({}): unless the cell was held at one "
      "temperature, that is the temperature of the air, or of a thermometer that is stuck. Then take the column out of "
      "these logs and give ambient_degC",
      fmt::join(still, ", "));
}

}  // namespace lipoid
