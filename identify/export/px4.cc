#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "identify/export/fitted_targets.h"
#include "identify/export/law_limits.h"
#include "identify/export/projected.h"
#include "model/export/provenance.h"
#include "model/export/px4_law.h"

namespace lipoid {

Exported ExportPx4(const ExportRequest& request) {
  const Cell& cell = request.cell;
  const SingleCell one(request);
  const double full_V = cell.open_circuit_voltage(1.0);
  const double capacity_mAh = 1000.0 * UsableCapacity_Ah(cell);
  const double drop_Ohm = one.TypicalResistance();
  const double most_Ohm = std::min(20.0 * drop_Ohm, kPx4LargestResistance_Ohm * cell.parallel);
  const std::vector<FreeParameter> parameters = {
      {"BAT1_V_EMPTY", 0.2 * full_V, (1.0 - 2.0 * kFullTolerance) * full_V, full_V},
      {"BAT1_V_CHARGED", (1.0 - kFullTolerance) * full_V, (1.0 + kFullTolerance) * full_V, full_V},
      {"BAT1_R_INTERNAL", std::min(0.05 * drop_Ohm, 0.5 * most_Ohm), most_Ohm, drop_Ohm}};
  const auto law = [&](const std::vector<double>& x) {
    return Px4Voltage({1, x[0], x[1], x[2], capacity_mAh}, one.mission, one.drawn_Ah);
  };
  // Linear in all three: one start finds the one minimum.
  const Projection found =
      Project(law, one.reference.voltage_V, parameters, {{0.8 * full_V, full_V, drop_Ohm}});

  Exported exported;
  if (!Usable(found, exported)) return exported;
  const Prediction pack = ReferenceOf(request);
  const std::vector<double> drawn_Ah = ChargeDrawn_Ah(cell, request.mission);
  const auto of_pack = [&](double empty_V, double charged_V, double ohm, double mAh) {
    // As the autopilot stores them.
    return Px4Battery{cell.series,
                      static_cast<float>(empty_V),
                      static_cast<float>(charged_V),
                      static_cast<float>(ohm / cell.parallel),
                      static_cast<float>(cell.parallel * mAh)};
  };
  const auto error_of = [&](const Px4Battery& battery) {
    return VoltageError(pack, request.mission, Px4Voltage(battery, request.mission, drawn_Ah));
  };
  const auto charge_error_of = [&](const Px4Battery& battery) {
    return ChargeError(
        pack, request.mission, Px4StateOfCharge(battery, request.mission, pack.voltage_V));
  };
  const Px4Battery battery =
      of_pack(found.parameters[0], found.parameters[1], found.parameters[2], capacity_mAh);
  const NaiveNumbers numbers = NaiveNumbersOf(cell);
  const Px4Battery naive = of_pack(
      numbers.empty_V, numbers.full_V, numbers.resistance_Ohm, 1000.0 * numbers.capacity_Ah);
  exported.error = error_of(battery);
  exported.naive = error_of(naive);
  exported.charge_error = charge_error_of(battery);
  exported.naive_charge_error = charge_error_of(naive);
  exported.parameters = {{"BAT1_N_CELLS", static_cast<double>(battery.cells), ""},
                         {"BAT1_V_EMPTY", battery.empty_V, "V"},
                         {"BAT1_V_CHARGED", battery.charged_V, "V"},
                         {"BAT1_R_INTERNAL", battery.resistance_Ohm, "Ohm"},
                         {"BAT1_CAPACITY", battery.capacity_mAh, "mAh"}};
  exported.cannot_hold = LeftOut(request, {});
  exported.cannot_hold.insert(
      exported.cannot_hold.begin() + (cell.diffusion ? 1 : 0),
      "The shape of v_oc: the law is one straight line between empty and charged, so that the "
      "voltage of empty lies far from the cell's cut-off.");
  exported.notes = {
      "PX4 estimates a state of charge from voltage and current and simulates no voltage: the "
      "error in volts is that of what these numbers mean, the error in state of charge that of the "
      "estimator, fed with the cell's voltage and current 100 times a second.",
      fmt::format(
          "Volts of one cell; the resistance is that of one cell over {} in parallel, since "
          "PX4 multiplies it by the pack's current.",
          cell.parallel),
      "The parameters need a reboot. The simulated battery of PX4 (SIM_BAT_DRAIN) ignores the "
      "current, and so these numbers but for the voltages."};
  AddBoundNotes(found, exported);

  std::string params = Commented(ProvenanceLines(request, exported), "# ");
  params += "# Vehicle-Id Component-Id Name Value Type\n";
  params += fmt::format("1\t1\tBAT1_N_CELLS\t{}\t6\n", battery.cells);
  for (std::size_t k = 1; k < exported.parameters.size(); ++k) {
    const auto& parameter = exported.parameters[k];
    params += fmt::format("1\t1\t{}\t{}\t9\n", parameter.name, static_cast<float>(parameter.value));
  }
  exported.files = {{".params", std::move(params)}};
  return exported;
}

}  // namespace lipoid
