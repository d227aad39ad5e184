#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "identify/export/fitted_targets.h"
#include "identify/export/frame_json.h"
#include "identify/export/law_limits.h"
#include "identify/export/projected.h"
#include "identify/export/projection.h"
#include "model/battery/curve_range.h"
#include "model/export/ardupilot_law.h"
#include "model/export/export_error.h"
#include "model/export/provenance.h"

namespace lipoid {
namespace {

// The fewest digits that read back to the same float.
std::string FloatText(double value) { return fmt::format("{}", static_cast<float>(value)); }

ArduPilotBattery OfPack(const Cell& cell, const ArduPilotBattery& of_cell) {
  return {.full_V = cell.series * of_cell.full_V,
          .capacity_Ah = cell.parallel * of_cell.capacity_Ah,
          .resistance_Ohm = cell.series * of_cell.resistance_Ohm / cell.parallel};
}

}  // namespace

Exported ExportArduPilot(const ExportRequest& request) {
  const Cell& cell = request.cell;
  const SingleCell one(request);
  const double full_V = cell.open_circuit_voltage(1.0);
  const double capacity_Ah = UsableCapacity_Ah(cell);
  const double drop_Ohm = one.TypicalResistance();
  const double drawn_Ah = *std::max_element(one.drawn_Ah.begin(), one.drawn_Ah.end());

  // The table falls off a cliff below 2 % of its capacity: the mission stays above it.
  constexpr double kCliff = 0.02;
  const double least_Ah = std::max(0.5 * capacity_Ah, drawn_Ah / (1.0 - kCliff));
  // A part of v_oc, or a mission over a part of the charge, does not tell where it ends: the capacity is then the
  // cell's own.
  constexpr double kTellingShare = 0.5;
  const bool known = KnowsCurve(cell, 0.0, 1.0);
  const bool held = !known || drawn_Ah < kTellingShare * capacity_Ah;
  const double held_Ah = std::max(least_Ah, capacity_Ah);
  std::vector<FreeParameter> parameters = {
      {"maxVoltage", (1.0 - kFullTolerance) * full_V, (1.0 + kFullTolerance) * full_V, full_V},
      {"refBatRes", 0.05 * drop_Ohm, 20.0 * drop_Ohm, drop_Ohm}};
  if (!held) parameters.push_back({"battCapacityAh", least_Ah, 4.0 * least_Ah, capacity_Ah});
  std::vector<std::vector<double>> starts;
  for (const double share : {1.0, 1.3, 2.0}) {
    for (const double ohm : {1.0, 2.0}) {
      starts.push_back({full_V, ohm * drop_Ohm});
      if (!held) starts.back().push_back(std::max(least_Ah, share * capacity_Ah));
    }
  }
  const auto battery_of = [&](const std::vector<double>& x) {
    return ArduPilotBattery{x[0], held ? held_Ah : x[2], x[1]};
  };
  const auto law = [&](const std::vector<double>& x) {
    return ArduPilotVoltageSmooth(battery_of(x), one.mission, one.drawn_Ah);
  };
  const Projection found = Project(law, one.reference.voltage_V, parameters, starts);

  Exported exported;
  const Prediction pack = ReferenceOf(request);
  const std::vector<double> pack_drawn_Ah = ChargeDrawn_Ah(cell, request.mission);
  const auto error_of = [&](const ArduPilotBattery& battery) {
    return VoltageError(
        pack, request.mission, ArduPilotVoltage(battery, request.mission, pack_drawn_Ah));
  };
  if (!Usable(found, exported)) return exported;
  const ArduPilotBattery battery = OfPack(cell, battery_of(found.parameters));
  const NaiveNumbers naive = NaiveNumbersOf(cell);
  exported.error = error_of(battery);
  exported.naive = error_of(OfPack(cell, {naive.full_V, naive.capacity_Ah, naive.resistance_Ohm}));
  exported.parameters = {{"maxVoltage", static_cast<float>(battery.full_V), "V"},
                         {"battCapacityAh", static_cast<float>(battery.capacity_Ah), "Ah"},
                         {"refBatRes", static_cast<float>(battery.resistance_Ohm), "Ohm"}};
  exported.cannot_hold = LeftOut(request, {});
  exported.cannot_hold.insert(
      exported.cannot_hold.begin() + (cell.diffusion ? 1 : 0),
      "The shape of v_oc: the simulator has one fixed table of resting voltages, which maxVoltage "
      "scales; it lies below that of most lithium-polymer cells in the middle, so that the best "
      "capacity is larger than the cell's.");
  exported.notes = {
      fmt::format("Volts, Ah and ohms of the pack of {} in series and {} in parallel.",
                  cell.series,
                  cell.parallel),
      fmt::format("The error is that of the simulator's float arithmetic at {:g} steps a second.",
                  kArduPilotSteps_per_s),
      "Load the frame as the model X:FILE.json of SITL, whose name ends in .json. A parameter that "
      "eeprom.bin has saved goes before the frame's; the option -w wipes it.",
      "The thrust follows the voltage, so these numbers change the flight.",
      request.target_version == "2026-06"
          ? "SIM_BATT_RES_OHM is a parameter of builds since June 2026; older ones take the "
            "resistance from the frame alone."
          : "Builds since June 2026 have SIM_BATT_RES_OHM as a parameter, which the target version "
            "2026-06 writes; older ones take the resistance from the frame alone."};
  if (held) {
    exported.notes.push_back(fmt::format(
        "battCapacityAh is the cell's own capacity and was not fitted: {} does not tell it.",
        known ? fmt::format("a mission that takes {:.0f} % of the charge",
                            100.0 * drawn_Ah / capacity_Ah)
              : "the part of v_oc that is known"));
  }
  AddStartNote(request, exported);
  AddBoundNotes(found, exported);

  const std::string comment = Commented(ProvenanceLines(request, exported), "# ");
  const std::vector<std::pair<std::string, std::string>> numbers = {
      {"maxVoltage", FloatText(battery.full_V)},
      {"battCapacityAh", FloatText(battery.capacity_Ah)},
      {"refBatRes", FloatText(battery.resistance_Ohm)}};
  const bool into = !request.into_file.empty();
  std::string frame = into ? MergeIntoFrame(request.into_text, request.into_file, numbers, comment)
                           : MergeIntoFrame("{}\n", "", numbers, comment);
  std::string parm = comment;
  parm += fmt::format("SIM_BATT_VOLTAGE {}\n", numbers[0].second);
  parm += fmt::format("SIM_BATT_CAP_AH {}\n", numbers[1].second);
  // What the autopilot counts percent and failsafe by is what the cell gives, not the law's capacity.
  parm += fmt::format("BATT_CAPACITY {}\n", std::lround(1000.0 * cell.parallel * capacity_Ah));
  if (request.target_version == "2026-06")
    parm += fmt::format("SIM_BATT_RES_OHM {}\n", numbers[2].second);
  exported.files = {{".json", std::move(frame)}, {".parm", std::move(parm)}};
  return exported;
}

}  // namespace lipoid
