#include <fmt/format.h>

#include <algorithm>

#include "identify/export/fitted_targets.h"
#include "identify/export/law_limits.h"
#include "identify/export/projected.h"
#include "model/export/gazebo_law.h"
#include "model/export/provenance.h"

namespace lipoid {
namespace {

GazeboBattery OfPack(const Cell& cell, const GazeboBattery& one) {
  return {.constant_V = cell.series * one.constant_V,
          .linear_V = cell.series * one.linear_V,
          .capacity_Ah = cell.parallel * one.capacity_Ah,
          .resistance_Ohm = cell.series * one.resistance_Ohm / cell.parallel,
          .smoothing_s = one.smoothing_s};
}

// What the cell gives in every row, and its mean while it gives any.
struct Power {
  std::vector<double> row_W;
  double mean_W = 0.0;
};

Power PowerOf(const ExportMission& mission, const Prediction& pack) {
  Power power;
  power.row_W.push_back(0.0);
  double energy_J = 0.0;
  double busy_s = 0.0;
  for (std::size_t k = 1; k < mission.time_s.size(); ++k) {
    const double current_A = mission.FlowBefore_A(k);
    power.row_W.push_back(current_A * pack.voltage_V[k]);
    if (current_A > 0.0) {
      const double dt_s = mission.time_s[k] - mission.time_s[k - 1];
      energy_J += power.row_W[k] * dt_s;
      busy_s += dt_s;
    }
  }
  power.mean_W = busy_s > 0.0 ? energy_J / busy_s : 0.0;
  return power;
}

}  // namespace

Exported ExportGazebo(const ExportRequest& request) {
  const Cell& cell = request.cell;
  const SingleCell one(request);
  const double full_V = cell.open_circuit_voltage(1.0);
  const double capacity_Ah = UsableCapacity_Ah(cell);
  const double drop_Ohm = one.TypicalResistance();
  const std::vector<FreeParameter> parameters = {
      {"open_circuit_voltage_constant_coef",
       (1.0 - kFullTolerance) * full_V,
       (1.0 + kFullTolerance) * full_V,
       full_V},
      {"open_circuit_voltage_linear_coef", -full_V, 0.0, full_V},
      {"resistance", 0.05 * drop_Ohm, 20.0 * drop_Ohm, drop_Ohm},
      {"smooth_current_tau", 0.01, 300.0, 1.0}};
  std::vector<std::vector<double>> starts;
  for (const double tau_s : {0.1, 2.0, 20.0}) {
    for (const double ohm : {1.0, 1.5})
      starts.push_back({full_V, -0.7 * (full_V - cell.cutoff_V), ohm * drop_Ohm, tau_s});
  }
  const auto battery_of = [&](const std::vector<double>& x) {
    return GazeboBattery{x[0], x[1], capacity_Ah, x[2], x[3]};
  };
  const auto law = [&](const std::vector<double>& x) {
    return GazeboVoltage(battery_of(x), one.mission, one.drawn_Ah);
  };
  const Projection found = Project(law, one.reference.voltage_V, parameters, starts);

  Exported exported;
  if (!Usable(found, exported)) return exported;
  const Prediction pack = ReferenceOf(request);
  const std::vector<double> drawn_Ah = ChargeDrawn_Ah(cell, request.mission);
  const auto error_of = [&](const GazeboBattery& battery) {
    return VoltageError(pack, request.mission, GazeboVoltage(battery, request.mission, drawn_Ah));
  };
  const GazeboBattery battery = OfPack(cell, battery_of(found.parameters));
  const NaiveNumbers naive = NaiveNumbersOf(cell);
  exported.error = error_of(battery);
  exported.naive = error_of(OfPack(cell,
                                   {.constant_V = naive.full_V,
                                    .linear_V = naive.empty_V - naive.full_V,
                                    .capacity_Ah = naive.capacity_Ah,
                                    .resistance_Ohm = naive.resistance_Ohm,
                                    .smoothing_s = 1.0}));
  const Power power = PowerOf(request.mission, pack);
  const ExportError under_power =
      VoltageError(pack,
                   request.mission,
                   GazeboVoltageUnderPower(battery, request.mission, power.row_W, drawn_Ah));
  exported.parameters = {{"open_circuit_voltage_constant_coef", battery.constant_V, "V"},
                         {"open_circuit_voltage_linear_coef", battery.linear_V, "V"},
                         {"capacity", battery.capacity_Ah, "Ah"},
                         {"initial_charge", battery.capacity_Ah, "Ah"},
                         {"resistance", battery.resistance_Ohm, "Ohm"},
                         {"smooth_current_tau", battery.smoothing_s, "s"},
                         {"power_load", power.mean_W, "W"}};
  exported.cannot_hold = LeftOut(request, {});
  exported.cannot_hold.insert(
      exported.cannot_hold.begin() + (cell.diffusion ? 1 : 0),
      "The shape of v_oc: the law is one straight line over the charge, so that the fall near empty "
      "is missing.");
  exported.notes = {
      fmt::format(
          "With the mission's power in place of its current, as Gazebo's consumers have it, "
          "the error is {:.3f} mV rms, {:.3f} mV at most.",
          1e3 * under_power.rmse_V,
          1e3 * under_power.max_error_V),
      fmt::format("power_load is the mission's mean power while it discharges, {:.4g} W: set it to "
                  "that of the model.",
                  power.mean_W),
      "The battery drains from the first command of a joint on, or from a message on a topic of "
      "power_draining_topic.",
      "The plugin's voltage does not reach an autopilot's own estimate of the battery."};
  AddStartNote(request, exported);
  AddBoundNotes(found, exported);

  const bool ignition = request.target_version == "fortress";
  const std::string in = ignition ? "ignition::gazebo" : "gz::sim";
  std::string sdf = "<plugin filename=\"";
  sdf += ignition ? "ignition-gazebo" : "gz-sim";
  sdf += "-linearbatteryplugin-system";
  sdf += "\"\n        name=\"" + in + "::systems::LinearBatteryPlugin\">\n";
  sdf += "  <!--\n" + Commented(ProvenanceLines(request, exported), "  ") + "  -->\n";
  const auto element = [&](std::string_view name, const std::string& value) {
    sdf += fmt::format("  <{}>{}</{}>\n", name, value, name);
  };
  element("battery_name", request.name.empty() ? "battery" : request.name);
  element("voltage", fmt::format("{}", battery.constant_V));
  for (const auto& parameter : exported.parameters)
    element(parameter.name, fmt::format("{}", parameter.value));
  element("fix_issue_225", "true");
  sdf += "</plugin>\n";
  exported.files = {{".sdf", std::move(sdf)}};
  return exported;
}

}  // namespace lipoid
