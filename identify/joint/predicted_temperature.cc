#include "identify/joint/predicted_temperature.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "identify/validation.h"
#include "model/battery/prediction.h"
#include "model/battery/typical_temperature.h"

namespace lipoid {
namespace {

// What becomes of HalfAsWarm() (structure_spread.h).
constexpr std::string_view kCounted = ", half of which the intervals count as a standard error";

std::string Said(const PredictedTemperatures& warm, const std::string& what) {
  return fmt::format(
      "{} {} the temperature of the surroundings alone (ambient_degC): {}; a column temperature_degC would know",
      fmt::join(warm.files, ", "),
      warm.files.size() == 1 ? "tells" : "tell",
      what);
}

std::string Balance(const PredictedTemperatures& warm) {
  if (!warm.assumed) return "its heat balance";
  return fmt::format("a typical heat balance ({:.3g} J/K and {:.3g} K/W, assumed)",
                     warm.by.heat_capacity_J_per_K,
                     warm.by.thermal_resistance_K_per_W);
}

bool TellsSurroundingsAlone(const LoadedLog& log) {
  return log.entry.kind != LogKind::kValidation && log.entry.ambient_degC &&
         log.log.record.temperature_degC.empty();
}

}  // namespace

std::string PredictedTemperatures::Predicted() const {
  return Said(*this,
              fmt::format("that of the cell is predicted by {}, up to {:.2g} K above{}",
                          Balance(*this),
                          most_K,
                          assumed ? kCounted : ""));
}

std::string PredictedTemperatures::NotTaken() const {
  return Said(
      *this,
      fmt::format(
          "the cell is taken to be as warm as they are, which fits better than the {:.2g} K by which "
          "{} would warm it{}",
          most_K,
          Balance(*this),
          assumed ? kCounted : ""));
}

std::vector<LoadedLog> PredictedTemperatures::HalfAsWarm() const {
  std::vector<LoadedLog> half = logs;
  for (LoadedLog& log : half) {
    if (!log.temperature_predicted) continue;
    for (double& degC : log.log.record.temperature_degC)
      degC = 0.5 * (degC + *log.entry.ambient_degC);
  }
  return half;
}

bool TellTemperature(const std::vector<LoadedLog>& logs) {
  return std::any_of(logs.begin(), logs.end(), [](const LoadedLog& log) {
    return log.entry.kind != LogKind::kValidation && !log.temperature_predicted &&
           !log.log.record.temperature_degC.empty();
  });
}

void AssumeHeat(const HeatBalance<double>& heat, Cell& cell) {
  cell.temperature->heat = heat;
  cell.heat_assumed = true;
  if (cell.temperature->entropy) cell.temperature->entropy->reversible_heat = false;
}

std::optional<PredictedTemperatures> PredictTemperatures(const Cell& cell,
                                                         const std::vector<LoadedLog>& logs) {
  constexpr double kLeastPredictedRise_K = 1.0;
  if (!cell.temperature || std::none_of(logs.begin(), logs.end(), TellsSurroundingsAlone))
    return std::nullopt;
  Cell one = cell.AsOne();
  PredictedTemperatures warm;
  const std::optional<HeatBalance<double>>& heat = one.temperature->heat;
  if (!TellTemperature(logs)) {
    if (!heat) AssumeHeat(TypicalHeat(one.capacity_Ah), one);
    warm.assumed = one.heat_assumed;
  }
  if (!heat) return std::nullopt;
  warm.by = *heat;
  warm.logs = logs;
  for (LoadedLog& log : warm.logs) {
    if (!TellsSurroundingsAlone(log)) continue;
    Record& record = log.log.record;
    auto predicted_degC = Predict(one,
                                  record.time_s,
                                  record.current_A,
                                  record.hold,
                                  log.entry.initial_soc,
                                  SurroundingsOf(record, log.entry))
                              .temperature_degC;
    if (predicted_degC.empty()) continue;
    const double most_degC = *std::max_element(predicted_degC.begin(), predicted_degC.end());
    warm.most_K = std::max(warm.most_K, most_degC - *log.entry.ambient_degC);
    warm.files.push_back(log.entry.file);
    record.temperature_degC = std::move(predicted_degC);
    log.temperature_predicted = true;
  }
  if (!(warm.most_K >= kLeastPredictedRise_K)) return std::nullopt;
  return warm;
}

}  // namespace lipoid
