#include <fmt/format.h>

#include <cmath>

#include "identify/export/fitted_targets.h"
#include "identify/export/law_limits.h"
#include "identify/export/projected.h"
#include "model/battery/prediction.h"
#include "model/export/provenance.h"

namespace lipoid {
namespace {

constexpr int kNs3Terms = 10;  // its default: the cost grows with terms times rows squared

// mA min of a coulomb, and 1/sqrt(min) of 1/sqrt(s).
constexpr double kMilliampMinutes_per_C = 1000.0 / 60.0;
const double kPerSqrtMinute = std::sqrt(60.0);

// The battery of ns-3 as a cell whose v_oc is its state of charge.
Cell RakhmatovCell(double alpha_C, double beta_per_sqrt_s) {
  Cell cell;
  cell.cutoff_V = 0.0;
  cell.capacity_Ah = alpha_C / 3600.0;
  cell.diffusion = Cell::Diffusion{
      .alpha_C = alpha_C, .beta_per_sqrt_s = beta_per_sqrt_s, .terms = kNs3Terms, .tail = false};
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {0.0, 1.0});
  return cell;
}

std::vector<double> LevelOf(const Cell& cell, const ExportMission& mission) {
  std::vector<double> level(mission.time_s.size());
  PredictRows(cell,
              mission.time_s,
              mission.current_A,
              mission.hold,
              mission.initial_soc,
              {},
              [&](std::size_t k, const PredictedRow& row) { level[k] = row.soc; });
  return level;
}

// When a constant current has emptied a full cell: A falls with time.
double Lifetime(const Cell& cell, double current_A) {
  const CellModel<double> model(cell.Parameters());
  const auto soc_after = [&](double time_s) {
    auto state = model.Relaxed(1.0);
    model.Advance(state, current_A, model.MakeStep(time_s));
    return model.Soc(state, current_A);
  };
  double alive_s = 0.0;
  double empty_s = cell.alpha_C() / current_A;
  for (int n = 0; n < 200; ++n) {
    const double middle_s = 0.5 * (alive_s + empty_s);
    (soc_after(middle_s) > 0.0 ? alive_s : empty_s) = middle_s;
  }
  return empty_s;
}

// Over the time in which the mission discharges.
double MeanDischarge(const ExportMission& mission) {
  double charge_C = 0.0;
  double busy_s = 0.0;
  for (std::size_t k = 1; k < mission.time_s.size(); ++k) {
    const double current_A = mission.FlowBefore_A(k);
    if (!(current_A > 0.0)) continue;
    const double dt_s = mission.time_s[k] - mission.time_s[k - 1];
    charge_C += current_A * dt_s;
    busy_s += dt_s;
  }
  return charge_C / busy_s;
}

}  // namespace

Exported ExportNs3(const ExportRequest& request) {
  const Cell& cell = request.cell;
  const SingleCell one(request);
  const double alpha_C = cell.alpha_C();
  // Without diffusion nothing is held back: a beta so large that it is below a second of current.
  constexpr double kNone_per_sqrt_s = 2.0;
  const double own = cell.diffusion ? cell.diffusion->beta_per_sqrt_s : kNone_per_sqrt_s;
  Projection found;
  found.parameters = {own};
  found.termination = Termination::kConverged;
  if (cell.diffusion) {
    const auto law = [&](const std::vector<double>& x) {
      return LevelOf(RakhmatovCell(alpha_C, x[0]), one.mission);
    };
    found = Project(law,
                    one.reference.soc,
                    {{"RvBatteryModelBetaValue", 0.3 * own, 3.0 * own, own}},
                    {{own}, {0.9 * own}});
  }
  Exported exported;
  if (!Usable(found, exported)) return exported;
  const double beta = found.parameters[0];
  const double mean_A = MeanDischarge(one.mission);
  const double cell_s = Lifetime(one.cell, mean_A);
  const auto error_of = [&](double beta_per_sqrt_s) {
    const Cell law = RakhmatovCell(alpha_C, beta_per_sqrt_s);
    ExportChargeError error = ChargeError(one.reference, one.mission, LevelOf(law, one.mission));
    error.lifetime_percent = 100.0 * (Lifetime(law, mean_A) / cell_s - 1.0);
    return error;
  };
  exported.charge_error = error_of(beta);
  // A cell file without diffusion has no beta to read off.
  if (cell.diffusion) exported.naive_charge_error = error_of(own);
  exported.parameters = {
      {"RvBatteryModelAlphaValue", cell.parallel * alpha_C * kMilliampMinutes_per_C, "mA min"},
      {"RvBatteryModelBetaValue", beta * kPerSqrtMinute, "min^-1/2"},
      {"RvBatteryModelNumOfTerms", kNs3Terms, ""},
      {"RvBatteryModelOpenCircuitVoltage", cell.series * cell.open_circuit_voltage(1.0), "V"},
      {"RvBatteryModelCutoffVoltage", cell.series * cell.cutoff_V, "V"},
      {"RvBatteryModelLowBatteryThreshold", 0.0, ""}};
  exported.cannot_hold = {
      "The voltage: that of the model is a constant, the mean of its two attributes. Resistance, "
      "relaxations and v_oc are not in it."};
  if (!request.whole) exported.cannot_hold.emplace_back(kNoMoreTerms);
  if (cell.diffusion && cell.diffusion->tail)
    exported.cannot_hold.insert(
        exported.cannot_hold.begin() + 1,
        "The tail of the diffusion sum: beta is a little smaller than the cell's to make up for it.");
  exported.notes = {
      "alpha is in mA min and beta in min^-1/2, whatever the model's header says.",
      fmt::format(
          "The error in lifetime is that at {:.4g} A for each cell, the mission's mean while "
          "it discharges.",
          mean_A),
      "The life of the battery ends at a level of 0 (its own default is 0.1).",
      "The model keeps all of its load history: 10000 changes of current take minutes. It takes the "
      "current at a sample for the whole interval before it, so switch loads after a sample.",
      request.target_version == "3.37" ? "The name of the class is that of ns-3 up to 3.41."
                                       : "The name of the class is that of ns-3 from 3.42 on."};
  if (cell.series > 1)
    exported.notes.emplace_back("The current of ns-3's source is that of the pack.");
  AddBoundNotes(found, exported);

  const std::string type =
      request.target_version == "3.37" ? "ns3::RvBatteryModel" : "ns3::energy::RvBatteryModel";
  std::string text = Commented(ProvenanceLines(request, exported), "# ");
  for (const auto& parameter : exported.parameters)
    text += fmt::format("default {}::{} \"{}\"\n", type, parameter.name, parameter.value);
  exported.files = {{".txt", std::move(text)}};
  return exported;
}

}  // namespace lipoid
