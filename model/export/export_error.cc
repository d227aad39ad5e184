#include "model/export/export_error.h"

#include <cmath>

#include "model/core/errors.h"
#include "model/core/special_values.h"

namespace lipoid {
namespace {

struct Largest {
  double rms = kNaN;
  double most = kNaN;
  std::size_t row = 0;
};

Largest Compare(std::span<const double> truth, std::span<const double> law) {
  Require(
      truth.size() == law.size() && !law.empty(),
      "one value for each row",
      {{"rows", static_cast<double>(truth.size())}, {"values", static_cast<double>(law.size())}});
  Largest result{.rms = 0.0, .most = 0.0};
  for (std::size_t k = 0; k < law.size(); ++k) {
    const double error = std::abs(law[k] - truth[k]);
    result.rms += error * error;
    if (error > result.most || (std::isnan(error) && !std::isnan(result.most))) {
      result.most = error;
      result.row = k;
    }
  }
  result.rms = std::sqrt(result.rms / static_cast<double>(law.size()));
  return result;
}

}  // namespace

Prediction ReferenceOf(const Cell& cell, const ExportMission& mission) {
  return Predict(cell,
                 mission.time_s,
                 mission.current_A,
                 mission.hold,
                 mission.initial_soc,
                 {.measured_degC = mission.temperature_degC});
}

Prediction ReferenceOf(const ExportRequest& request) {
  return ReferenceOf(request.Whole(), request.mission);
}

ExportError VoltageError(const Prediction& cell,
                         const ExportMission& mission,
                         std::span<const double> voltage_V) {
  const Largest found = Compare(cell.voltage_V, voltage_V);
  return {.rmse_V = found.rms,
          .max_error_V = found.most,
          .worst_s = mission.time_s[found.row],
          .worst_soc = cell.soc[found.row],
          .law_V = {voltage_V.begin(), voltage_V.end()}};
}

ExportChargeError ChargeError(const Prediction& cell,
                              const ExportMission& mission,
                              std::span<const double> soc) {
  const Largest found = Compare(cell.soc, soc);
  return {.rms = found.rms,
          .max_error = found.most,
          .worst_s = mission.time_s[found.row],
          .lifetime_percent = {}};
}

std::vector<double> ChargeDrawn_Ah(const Cell& cell, const ExportMission& mission) {
  double drawn_C = cell.parallel * cell.alpha_C() * (1.0 - mission.initial_soc);
  std::vector<double> drawn_Ah(mission.time_s.size());
  for (std::size_t k = 0; k < drawn_Ah.size(); ++k) {
    if (k > 0) drawn_C += (mission.time_s[k] - mission.time_s[k - 1]) * mission.FlowBefore_A(k);
    drawn_Ah[k] = drawn_C / 3600.0;
  }
  return drawn_Ah;
}

NaiveNumbers NaiveNumbersOf(const Cell& cell) {
  return {.full_V = cell.open_circuit_voltage(1.0),
          .empty_V = cell.cutoff_V,
          .capacity_Ah = cell.capacity_Ah,
          .resistance_Ohm = cell.series_resistance_Ohm(1.0)};
}

double UsableCapacity_Ah(const Cell& cell) { return cell.alpha_C() / 3600.0; }

}  // namespace lipoid
